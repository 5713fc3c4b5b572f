#pragma once
#include <vector>

#include "runtime/evaluate/evaluator.h"
#include "runtime/shade/shading_set.h"
#include "tests/posed_vertices.h"

namespace penumbra {

// Does what a player does with an asset that was accepted: every part of the run time reads it. Tests on hostile bytes
// use it.
inline void useAsset(const AssetView& asset) {
    if (asset.has_truth && asset.animation.frameCount() > 0) {
        std::vector<float> moments(std::size_t(coefficientCount(asset.truth.order)));
        readTruth(asset, asset.animation.frameCount() - 1, asset.mesh.positions.size() - 1, moments);
    }
    if (!asset.hasCharacter() || asset.animation.frameCount() == 0) return;
    Evaluator evaluator(asset);
    const std::size_t count = evaluator.vertexCount();
    std::vector<Vec3> radiance(count);
    if (evaluator.deformation()) {
        std::vector<Vec3> points(evaluator.points().begin(), evaluator.points().end());
        if (!asset.animation.playback.positions.empty()) evaluator.setFrame(asset.animation.frameCount() - 1);
        points[0] += Vec3{0.1f, 0.2f, 0.3f};
        evaluator.setPositions(points, evaluator.deformation()->restInputs());
    } else {
        if (asset.model.features == FeatureKind::kJointAngles && asset.animation.pose.empty()) return;
        evaluator.setFrame(0);
    }
    const PosedArrays vertices(evaluator);
    if (asset.materials.empty() || asset.lights.empty()) return;
    if (evaluator.transfer()) {
        ShadingSet set(asset);
        evaluator.transfer()->setLight(set.lightTables().sh());
        evaluator.transfer()->irradiance(0, count, radiance);
        for (std::size_t m = 0; m < asset.materials.size(); ++m)
            if (set.hasMaterial(m)) set.setMaterial(m);
        if (set.hasMaterial(set.materialOfSlot()[0])) set.shade(vertices.all(), {0, 0, 5}, radiance);
        return;
    }
    for (const Reflectance reflectance : {Reflectance::kSlices, Reflectance::kOperators})
        for (const LightForm form : {LightForm::kLobes, LightForm::kFixed, LightForm::kRotation}) {
            ShadingSet set(asset, {reflectance, form});
            set.setSuns(form == LightForm::kRotation);
            for (std::size_t m = 0; m < asset.materials.size(); ++m)
                for (std::size_t l = 0; l < asset.lights.size(); ++l) {
                    if (!set.hasMaterial(m) || !set.hasLight(l)) continue;
                    set.setMaterial(m);
                    set.setLight(l);
                    set.showSurface();
                    std::vector<Vec3> terms(set.terms() * count);
                    set.shadeTerms(vertices.all(), {0, 0, 5}, terms);
                    set.shade(vertices.all(), {0, 0, 5}, radiance);
                }
        }
}

}  // namespace penumbra
