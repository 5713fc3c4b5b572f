// The part of penumbra.h that handles suns.
#include <cmath>

#include "runtime/capi/capi_handles.h"

namespace penumbra {

namespace {

static_assert(PENUMBRA_MAX_SUNS == kMaxSuns);

void requireCallerLight(const penumbra_shading& shading) {
    if (shading.caller_light.empty())
        throw Unsupported("the shading was made without room for a light of the caller (caller_light_order)");
}

void requireSeconds(const char* name, double seconds) {
    if (!(seconds >= 0) || !std::isfinite(seconds))
        throw UsageError(std::string(name) + " must be a finite number of seconds, 0 or more");
}

void requireSun(const penumbra_sun* sun) {
    requirePointer(sun, "sun");
    requireFinite("sun->direction", sun->direction);
    const float* d = sun->direction;
    const double size = length(Vec3d{d[0], d[1], d[2]});
    if (!(std::abs(size - 1) < 1e-3)) throw UsageError("sun->direction has length " + std::to_string(size) + ", not 1");
    if (!(sun->radius >= 0) || !std::isfinite(sun->radius))
        throw UsageError("sun->radius must be a finite number of radians, 0 or more");
}

void requireCaster(const penumbra_sun_caster& caster) {
    if (caster.vertex_count > 0) requirePointer(caster.positions, "the positions of a caster");
    requireCount("vertex_count", caster.vertex_count, 3 * sizeof(float));
    requireCount("triangle_count", caster.triangle_count, 3 * sizeof(std::uint32_t));
    if (caster.triangle_count == 0) return;
    requirePointer(caster.triangles, "the triangles of a caster");
    for (std::size_t i = 0; i < 3 * caster.triangle_count; ++i)
        requireIndex("a vertex of a triangle", caster.triangles[i], caster.vertex_count);
}

SunCaster casterOf(const penumbra_sun_caster& caster) {
    return {vectors(caster.positions, caster.vertex_count), {caster.triangles, 3 * caster.triangle_count}};
}

}  // namespace

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_shading_set_suns(penumbra_shading* shading, int on, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        if (on && shading->set->choice().light_form != LightForm::kRotation)
            throw Unsupported("suns need light_form PENUMBRA_ROTATION");
        shading->set->setSuns(on != 0);
    });
}

size_t penumbra_shading_sun_count(const penumbra_shading* shading) { return shading ? shading->set->suns().size() : 0; }

penumbra_status penumbra_shading_get_sun(const penumbra_shading* shading, size_t sun, penumbra_sun* out) {
    if (!shading || !out || sun >= shading->set->suns().size()) return PENUMBRA_INVALID_ARGUMENT;
    const auto& [direction, irradiance, radius] = shading->set->suns()[sun];
    *out = {{direction.x, direction.y, direction.z}, {irradiance.x, irradiance.y, irradiance.z}, radius};
    return PENUMBRA_OK;
}

penumbra_status penumbra_shading_find_suns(penumbra_shading* shading, int most, double time_constant,
                                           penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requireCallerLight(*shading);
        if (most < 0 || most > kMaxSuns)
            throw UsageError("most is " + std::to_string(most) + ", allowed are 0.." + std::to_string(kMaxSuns));
        requireSeconds("time_constant", time_constant);
        shading->set->factorLive(shading->view.lights.size() - 1, most, time_constant);
    });
}

penumbra_status penumbra_shading_set_sh_light(penumbra_shading* shading, int order, const float* sh, double seconds,
                                              penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading", sh, "sh");
        requireCallerLight(*shading);
        const int most = shading->view.lights.back().order;
        if (order < 1 || order > most)
            throw UsageError("order is " + std::to_string(order) + ", allowed are 1.." + std::to_string(most));
        requireSeconds("seconds", seconds);
        const std::span<const float> numbers(sh, 3 * std::size_t(coefficientCount(order)));
        requireFinite("sh", numbers);
        shading->set->setLight(shading->view.lights.size() - 1, numbers, seconds);
    });
}

penumbra_status penumbra_shading_add_suns(const penumbra_shading* shading, const penumbra_vertices* vertices,
                                          const float eye[3], const float* visible, float* radiance,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        const std::size_t n = shading->view.mesh.positions.size();
        const VertexFrames frames = framesOf(vertices, n, 0);
        const Vec3 from = pointFrom("eye", eye);
        requirePointer(visible, "visible", radiance, "radiance");
        shading->set->addSuns(frames, {visible, n * shading->set->suns().size()}, from, vectors(radiance, n));
    });
}

penumbra_status penumbra_sun_map_create(int size, penumbra_sun_map** map, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(map, "map");
        if (size != 0 && (size < kSmallestSunMap || size > kLargestSunMap))
            throw UsageError("size is " + std::to_string(size) + ", allowed are 0 and " +
                             std::to_string(kSmallestSunMap) + ".." + std::to_string(kLargestSunMap));
        auto made = std::make_unique<penumbra_sun_map>();
        made->size = size == 0 ? kSunMapSize : size;
        *map = made.release();
    });
}

void penumbra_sun_map_destroy(penumbra_sun_map* map) { delete map; }

penumbra_status penumbra_sun_map_set_casters(penumbra_sun_map* map, const penumbra_sun* sun,
                                             const penumbra_sun_caster* casters, size_t count,
                                             const penumbra_sun_caster* ground, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(map, "map");
        requireSun(sun);
        if (count > 0) requirePointer(casters, "casters");
        requireCount("count", count, sizeof *casters);
        for (std::size_t i = 0; i < count; ++i) requireCaster(casters[i]);
        if (ground) requireCaster(*ground);
        map->casters.members.clear();
        for (const penumbra_sun_caster& caster : std::span(casters, count))
            map->casters.members.push_back(casterOf(caster));
        map->casters.ground = ground ? casterOf(*ground) : SunCaster{};
        const Vec3 direction{sun->direction[0], sun->direction[1], sun->direction[2]};
        map->maps.begin(map->casters, direction, sun->radius, map->size);
        map->maps.draw(map->casters);
    });
}

penumbra_status penumbra_sun_map_visibility(const penumbra_sun_map* map, const float* positions, const float* normals,
                                            size_t count, float* visible, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(map, "map");
        if (count == 0) return;
        requireCount("count", count, 3 * sizeof(float));
        requirePointer(positions, "positions", normals, "normals", visible, "visible");
        const std::span<const Vec3> at = vectors(positions, count), normal = vectors(normals, count);
        for (std::size_t i = 0; i < count; ++i) visible[i] = map->maps.visibility(at[i], normal[i]);
    });
}
