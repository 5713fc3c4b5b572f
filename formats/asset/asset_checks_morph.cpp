// The checks of morph targets.
#include <cmath>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"

namespace penumbra {

namespace {

// Checks that the rows of every target follow those of the one before, with ascending vertices.
void checkRows(const Field& at, const MorphsView& morphs) {
    for (std::size_t m = 0; m < morphs.count(); ++m) {
        checkRange((at / "first")[m], morphs.first[m], m == 0 ? 0 : morphs.first[m - 1],
                   m == 0 ? 0 : std::int64_t(morphs.vertices.size()));
        for (std::size_t r = std::size_t(morphs.first[m]) + 1; r < morphs.first[m + 1] && r < morphs.vertices.size();
             ++r)
            (at / "vertices")[r].require(morphs.vertices[r] > morphs.vertices[r - 1], "does not ascend");
    }
    checkRange((at / "first")[morphs.count()], morphs.first[morphs.count()], std::int64_t(morphs.vertices.size()),
               std::int64_t(morphs.vertices.size()));
}

// Checks that a pose has every weight: bones carry them to the run time.
void checkInputs(const Field& at, const AssetView& asset, std::size_t morphs) {
    const std::size_t inputs = asset.animation.input_names.size();
    at.require(morphs <= inputs, "are more than animation.input_names");
    if (!asset.has_model) return;
    std::vector<bool> carried(morphs);
    for (const InputJointView& input : asset.model.input_joints)
        if (input.columns == 1 && input.column + morphs >= inputs && std::abs(input.scale) > 1e-30f)
            carried[input.column + morphs - inputs] = true;
    for (std::size_t m = 0; m < morphs; ++m) at[m].require(carried[m], "has no joint in model.input_joints");
}

}  // namespace

void setMorphs(const fbs::Asset& stored_asset, const Field& file, AssetView& asset) {
    const fbs::Morphs* stored = asset.has_mesh ? stored_asset.mesh()->morphs() : nullptr;
    if (!stored) return;
    const Field at = file / "mesh.morphs";
    MorphsView morphs;
    morphs.rest_weights = requiredSpanOf<float>(stored->rest_weights(), at / "rest_weights");
    checkFinite(at / "rest_weights", morphs.rest_weights);
    (at / "rest_weights").require(!morphs.empty(), "is empty");
    morphs.first = spanOf<std::uint32_t>(stored->first(), at / "first");
    checkCount(at / "first", morphs.first, std::uint64_t(morphs.count()) + 1);
    morphs.vertices = spanOf<std::uint32_t>(stored->vertices(), at / "vertices");
    checkIndices(at / "vertices", morphs.vertices, asset.mesh.positions.size());
    morphs.positions = spanOf<Vec3>(stored->positions(), at / "positions");
    checkCount(at / "positions", morphs.positions, morphs.vertices.size());
    checkFinite(at / "positions", morphs.positions);
    morphs.normals = spanOf<Vec3>(stored->normals(), at / "normals");
    checkCount(at / "normals", morphs.normals, morphs.vertices.size());
    checkFinite(at / "normals", morphs.normals);
    checkRows(at, morphs);
    checkInputs(at, asset, morphs.count());
    at.require(!asset.model.deforming && !stored_asset.transfer(), "are not possible in this kind of asset");
    asset.mesh.morphs = morphs;
}

}  // namespace penumbra
