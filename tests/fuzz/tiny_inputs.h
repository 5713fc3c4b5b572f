#pragma once
// Tiny valid inputs for fuzz targets whose mutator falls back to them and for their corpora.
#include <cstddef>
#include <string>
#include <vector>

#include "formats/stage/model_file.h"
#include "pack/pack_asset.h"
#include "pack/pack_transfer.h"
#include "tests/fuzz/memory_file.h"
#include "tests/synthetic_cloth.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_dense.h"
#include "tests/synthetic_indirect.h"
#include "tests/synthetic_transfer.h"

namespace penumbra {

// A model whose far parts are tables of two points along each side.
inline Model tinyComposed() {
    Model model = synthetic::composedTube(
        {.rings = 3, .segments = 3, .joints = 4, .clusters = 1, .components = 1, .inputs = 1, .frames = 2},
        {.cells = 2});
    synthetic::addNearParts(model, 2);
    return model;
}

// A light of two bands with a sun and the picture of what is left.
inline LightFile tinySunny() {
    LightFile light = synthetic::light(2, 0.3);
    light.factor = "hand-over";
    light.suns = {{{0.6, 0.8, 0}, {5, 4, 3}, 0.005}};
    light.window = {1, 0.5};
    light.picture = {4, 2, std::vector<float>(24, 0.5f)};
    return light;
}

// A live material and a membrane.
inline std::vector<BrdfFile> tinyNewLooks() {
    BrdfFile live, membrane;
    live.name = "live";
    membrane.name = "membrane";
    live.slice_order = live.view_order = membrane.slice_order = membrane.view_order = 1;
    live.even_index = membrane.even_index = {0};
    live.lobes = {lobeOf(parseBrdf("phong-live"))};
    membrane.lobes = {lobeOf({})};
    membrane.slices = {1, 1, 1};
    membrane.membrane = Membrane();
    return {live, membrane};
}

// A material with two steps.
inline BrdfFile tinySteps() {
    BrdfFile steps;
    steps.name = "steps";
    steps.slice_order = steps.view_order = 1;
    steps.even_index = {0};
    steps.slices = {1, 1, 1};
    steps.lobes = {lobeOf(parseBrdf("ggx:alpha=0.25"))};
    steps.steps = BrdfSteps{0, {0.25, 0.5}, {1, 1, 1, 2, 2, 2}, 0.01};
    return steps;
}

// The same of two lobes of a material that glows.
inline BrdfFile tinyPrincipled() {
    BrdfFile brdf = tinySteps();
    brdf.name = "principled";
    brdf.lobes = {lobeOf(parseBrdf("principled-diffuse")), lobeOf(parseBrdf("ggx-f0:roughness=0.25")),
                  lobeOf(parseBrdf("ggx-f90:roughness=0.25"))};
    brdf.steps->lobes = 0b110;
    brdf.emission = {1, 0.5f, 0.25f};
    return brdf;
}

// Pictures of two roles, which lie differently on every triangle.
inline SurfaceLook tinySurface(const Mesh& mesh) {
    SurfaceLook look;
    look.materials = {diffuseMaterial({1, 1, 1})};
    std::vector<Uv>& uv = look.surface.uv.emplace_back();
    for (std::size_t corner = 0; corner < 3 * mesh.triangles.size(); ++corner) uv.push_back({float(corner / 3), 0.5f});
    SlotSurface slot;
    slot.use(TextureRole::kBaseColor) = {0, 0, 4};
    slot.use(TextureRole::kNormal) = {1, 0, 0};
    look.surface.slots.assign(std::max<std::size_t>(1, mesh.slots.size()), slot);
    look.surface.textures = {{"images[0]", "", {std::byte(1)}}, {"images[1]", "b.png", {}}};
    return look;
}

// Tiny assets, one for each kind of model and of features, a composed one, one with blockers, two under a sun (with a
// model and without), one with a live material and a membrane, two of transfer, two that light bounces to, one with
// steps of a material, one with pictures, and one whose vertices follow points.
inline const std::vector<std::vector<std::byte>>& tinyAssets() {
    static const std::vector<std::vector<std::byte>> all = [] {
        std::vector<std::vector<std::byte>> made;
        const std::vector<LightFile> lights = {synthetic::light(2, 0.3)};
        BrdfFile brdf;
        brdf.name = "plain";
        brdf.slice_order = brdf.view_order = 1;
        brdf.even_index = {0};
        brdf.slices = {1, 1, 1};
        brdf.lobes = {lobeOf({})};
        for (const ModelKind kind : kModelKinds)
            for (const FeatureKind features : synthetic::kSkinnedFeatures) {
                const Model model = synthetic::tubeModel({.rings = 2,
                                                          .segments = 3,
                                                          .joints = 2,
                                                          .clusters = 1,
                                                          .components = 1,
                                                          .inputs = 1,
                                                          .frames = 2,
                                                          .features = features,
                                                          .kind = kind});
                made.push_back(packAsset(model, std::vector<BrdfFile>{brdf}, lights, {}, "{}", 1).bytes);
            }
        for (const FeatureKind features : {FeatureKind::kRelativeBones, FeatureKind::kDihedrals}) {
            const Model cloth = synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2, .features = features});
            made.push_back(packAsset(cloth, std::vector<BrdfFile>{brdf}, lights, {}, "{}", 1).bytes);
        }
        made.push_back(packAsset(tinyComposed(), std::vector<BrdfFile>{brdf}, lights, {}, "{}", 1).bytes);
        const SphereBlockers blockers{{{{0, 1, 0}, 0.5f}, {{0, 0.5f, 0}, 0.25f}}, {1, 0}};
        made.push_back(packAsset(synthetic::tubeModel({.rings = 2, .segments = 3, .joints = 2, .frames = 2}), {},
                                 lights, {.blockers = blockers}, "{}", 1)
                           .bytes);
        brdf.lobes = {lobeOf(parseBrdf("lambert:color=0.5/0.25/0.1")), lobeOf(parseBrdf("ggx:alpha=0.3"))};
        const std::vector<BrdfFile> glossy = {brdf};
        const std::vector<LightFile> sunny = {tinySunny()};
        made.push_back(packAsset(synthetic::tubeModel({.rings = 2, .segments = 3, .joints = 2, .frames = 2}), glossy,
                                 sunny, {}, "{}", 1)
                           .bytes);
        made.push_back(packLibrary(glossy, sunny, "{}"));
        made.push_back(
            packAsset(synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2}), tinyNewLooks(), sunny, {}, "{}", 1)
                .bytes);
        for (const TransferModelKind kind : kTransferModelKinds)
            made.push_back(
                packTransfer(synthetic::tubeTransfer(kind, 2, {.rings = 2, .segments = 3, .joints = 2, .frames = 2}),
                             std::vector<BrdfFile>{diffuseMaterial({0.5f, 0.25f, 0.125f})}, sunny, {}, "{}"));
        Model composed = tinyComposed();
        synthetic::addIndirect(composed);
        for (const Model& lit : {synthetic::litTube({.rings = 2, .segments = 3, .joints = 2, .frames = 2}), composed})
            made.push_back(packAsset(lit, glossy, sunny, {.indirect_bytes_per_vertex = 1000}, "{}", 1).bytes);
        made.push_back(packLibrary(std::vector<BrdfFile>{tinySteps(), tinyPrincipled()}, sunny, "{}"));
        const Model pictured = synthetic::tubeModel({.rings = 2, .segments = 3, .joints = 2, .frames = 2});
        made.push_back(packAsset(pictured, glossy, sunny, {.surface = tinySurface(pictured.mesh)}, "{}", 1).bytes);
        Model dense = synthetic::tubeModel({.rings = 2, .segments = 3, .joints = 2, .clusters = 1, .frames = 2});
        synthetic::addDense(dense);
        made.push_back(packAsset(dense, {}, {}, {}, "{}", 1).bytes);
        return made;
    }();
    return all;
}

// Tiny model files: a rig, cloth of both kinds of features with two sides and inputs, and last a composed model.
inline const std::vector<std::string>& tinyModels() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> made;
        for (const Model& model :
             {synthetic::tubeModel({.rings = 2, .segments = 3, .frames = 2}),
              synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2}),
              synthetic::clothModel({.rows = 2, .columns = 3, .frames = 2, .features = FeatureKind::kDihedrals}),
              tinyComposed()}) {
            const std::filesystem::path path = memoryFile("seed", nullptr, 0);
            writeModel(path, model);
            std::ifstream in(path, std::ios::binary);
            made.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
            std::filesystem::remove(path);
        }
        return made;
    }();
    return all;
}

}  // namespace penumbra
