// Baked moments, convention D5, times a reflectance slice and an SH light, against brute-force integrals of the same
// band-limited light with a shadow ray for every direction: the whole chain of approximations that a picture goes
// through, without the model of the pose (formulas: sh/reflectance.h).
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "bake/reference/direct_light.h"
#include "bake/trace/moments.h"
#include "fit/reflectance/fit_brdf.h"
#include "fit/reflectance/shading_error.h"
#include "formats/source/source_readers.h"
#include "sh/sh_rotation.h"
#include "tests/accuracy/extent.h"

namespace penumbra::test_baked_shading {
namespace {

struct Scene {
    std::vector<Vec3> positions, normals;  // the points that are shaded
    SceneScale scale;
    OcclusionScene occluders;
};

Scene middleFrame(const std::filesystem::path& path, std::size_t points) {
    const Rig rig = readRig({path});
    const FrameList frames = sampleFrames(rig, {}, 3);
    const std::size_t f = frames.frameCount() / 2;
    int clip = 0;
    while (rig.clips[std::size_t(clip)].name != frames.clip_names[frames.clip[f]]) ++clip;
    std::vector<Vec3> positions, normals, scaled, some_positions, some_normals;
    skinVertices(rig.mesh, rig.skin, rig.rest_normals, evaluatePose(rig, clip, frames.time[f]).bones, positions,
                 normals);
    const SceneScale scale = sceneScale(positions, boxDiagonal(positions));
    for (Vec3 p : positions) scaled.push_back(scale.apply(p));
    const std::size_t step = positions.size() / points;
    for (std::size_t v = step / 2; v < positions.size(); v += step) {
        some_positions.push_back(positions[v]);
        some_normals.push_back(normals[v]);
    }
    return {some_positions, some_normals, scale, OcclusionScene(scaled, rig.mesh.triangles)};
}

// Lights and views of the reference scenes, and an occluder for every point of `scene`: a shadow ray for every
// direction of the grid about the point's normal.
ShadingTest testOf(const Scene& scene) {
    ShadingScenes scenes = referenceScenes();
    const std::size_t points = scene.positions.size();
    scenes.occluders.assign(points, {});
    ShadingTest test = makeShadingTest(scenes, 2);
    for (std::size_t v = 0; v < points; ++v) {
        const Mat3d model_from_local = transposed(shadingFrame(toDouble(scene.normals[v])));
        const Vec3 origin = scene.scale.apply(scene.positions[v]) + scene.normals[v] * 1e-4f;
        for (std::size_t q = 0; q < test.directions.size(); ++q)
            test.open[q * points + v] =
                !scene.occluders.occluded(origin, toFloat(model_from_local * test.directions[q]), 0);
    }
    return test;
}

// The moments of a bake with `rays` directions take the place of those in `test`.
void useBakedMoments(const Scene& scene, int rays, ShadingTest& test) {
    const RayDirections directions = makeRayDirections(rays, 1, 5);
    std::vector<float> baked(scene.positions.size() * 25);
    traceMoments({scene.occluders, directions, scene.scale, 1e-4f}, scene.positions, scene.normals, {baked});
    for (std::size_t v = 0; v < scene.positions.size(); ++v) {
        const std::vector<double> model(baked.begin() + std::ptrdiff_t(25 * v),
                                        baked.begin() + std::ptrdiff_t(25 * v + 25));
        apply(makeShRotation(5, shadingFrame(toDouble(scene.normals[v]))), model,
              std::span(test.moments).subspan(v * coefficientCount(kMaxOrder), 25));
    }
}

struct Errors {
    double lambert, noisy, ggx;
};

// Lambert and GGX with 4096 directions, and Lambert with 1024.
Errors bakedErrors(const std::filesystem::path& path, std::size_t points) {
    const Scene scene = middleFrame(path, points);
    ShadingTest test = testOf(scene);
    const auto errorOf = [&](const char* text) {
        const RgbBrdf brdf = rgbBrdf(parseBrdf(text));
        const BrdfFile file = fitBrdf(brdf, {}, 2);
        return shadingError({test, bruteForceRadiance(test, brdf, 2)}, parseConvention("D5"),
                            slicesOfViews(test.scenes.views, file.slices, file.even_index), file.slice_order);
    };
    useBakedMoments(scene, 4096, test);
    Errors errors{errorOf("lambert"), 0, errorOf("ggx:alpha=0.3,f0=0.9")};
    useBakedMoments(scene, 1024, test);
    errors.noisy = errorOf("lambert");
    std::printf("%s, %zu points: shading error Lambert %.4f (1024 directions: %.4f), GGX %.4f\n",
                path.filename().c_str(), scene.positions.size(), errors.lambert, errors.noisy, errors.ggx);
    return errors;
}

// The bounds are the table's for D5, J = 5. It was made with exact visibility; with 1024 directions the noise of the
// bake adds to Lambert's small error (square root of the sum of squares), so that has a bound of its own.
// Measured on 62 points of the synthetic character: .0048, .0062 and .0411.
void expectAccuracy(const std::filesystem::path& path, std::size_t points) {
    const Errors errors = bakedErrors(path, points);
    EXPECT_LT(errors.lambert, 0.006) << path;
    EXPECT_LT(errors.noisy, 0.008) << path;
    EXPECT_LT(errors.ggx, 0.050) << path;
}

}  // namespace

// The synthetic character, and real ones where PENUMBRA_DATA has them.
TEST(ShadingAccuracy, Characters) {
    expectAccuracy(PENUMBRA_BINARY_DIR "/../samples/capsule_man.glb", every_row ? 60 : 24);
    if (const char* data = std::getenv("PENUMBRA_DATA"))
        for (const char* name : {"mh_male_cmu05.glb", "mannequin_7clips.glb"})
            expectAccuracy(std::filesystem::path(data) / "rigs" / name, 24);
}

}  // namespace penumbra::test_baked_shading
