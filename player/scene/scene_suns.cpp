#include "player/scene/scene_suns.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "player/scene/scene_receivers.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

bool shine(const PosedScene& scene, SunChoice choice) {
    if (choice == SunChoice::kOff) return false;
    std::string lacking;
    if (!scene.light())
        lacking = "the scene has no light";
    else if (scene.light()->suns.empty())
        lacking = "the light \"" + std::string(scene.light()->name) +
                  "\" has none; penumbra-fit light finds them where it factors the light";
    else if (scene.castWay().mode != CastMode::kProduct)
        lacking = "needs shadows of others that join as a product";
    if (!lacking.empty() && choice == SunChoice::kOn) throw BadOption("suns", lacking);
    return lacking.empty();
}

}  // namespace

void drawSunMaps(const Sun& sun, const SunCasters& casters, int size, int threads, SunMaps& maps) {
    constexpr int kMaxBands = 16;
    const int bands = threads > 0 ? std::min(threads, kMaxBands) : kMaxBands;  // each looks at all triangles
    maps.begin(casters, sun.direction, sun.radius, size);
    parallelFor(std::size_t(bands), threads, [&](std::size_t band) { maps.draw(casters, int(band), bands); });
}

void addRealMeshes(const PosedScene& scene, SunCasters& casters) {
    for (const RealMesh& mesh : scene.realMeshes())
        if (castsInSuns(*mesh.file)) casters.members.push_back({mesh.positions, mesh.triangles});
}

std::vector<Sun> sunsOf(const LightView& light, const Mat3& rotation) {
    std::vector<Sun> suns(light.suns.begin(), light.suns.end());
    for (Sun& sun : suns) sun.direction = rotation * sun.direction;
    return suns;
}

std::vector<float> remainderOf(const LightView& light) {
    std::vector<float> sh(light.sh.begin(), light.sh.end());
    subtractSuns(light.suns, light.window, sh);
    return sh;
}

SceneSuns sceneSuns(const PosedScene& scene, SunChoice choice, int map_size, int threads) {
    if (!shine(scene, choice)) return {};
    Mat3 rotation;
    std::ranges::transform(scene.lightRotation().m, rotation.m.begin(), [](double x) { return float(x); });
    SceneSuns out{sunsOf(*scene.light(), rotation), remainderOf(*scene.light()), {}};
    std::vector<FrameVertices> members(scene.members().size());
    SunCasters casters;
    for (std::size_t m = 0; m < members.size(); ++m) {
        skinMember(*scene.members()[m], threads, members[m]);
        if (castsInSuns(*scene.members()[m]->file))
            casters.members.push_back({members[m].positions, scene.members()[m]->asset->view.mesh.castingTriangles()});
    }
    addRealMeshes(scene, casters);
    std::vector<Vec3> points;
    std::vector<std::uint32_t> triangles;
    if (scene.field()) {
        scene.field()->heights().castingPoints(points);
        triangles = castingTriangles(scene.field()->heights().field().grid());
        casters.ground = {points, triangles};
    }
    for (const Sun& sun : out.suns) drawSunMaps(sun, casters, map_size, threads, out.maps.emplace_back());
    return out;
}

}  // namespace penumbra
