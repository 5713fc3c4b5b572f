// Points stand in lanes, and emitters are the same for all of them, so that nothing is gathered.
#include "player/scene/emitter_kernel.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

constexpr float kPerPi = 0.318309886f;

struct EmitterSum {
    Lanes radiance[3], shares;
};

inline void addEmitter(const Emitter& emitter, const Lanes* point, const Lanes* normal, EmitterSum& sum) {
    const Vec3 &at = emitter.position, &area = emitter.area, &radiance = emitter.radiance;
    const Lanes x = at.x - point[0], y = at.y - point[1], z = at.z - point[2];
    const Lanes above = x * normal[0] + y * normal[1] + z * normal[2], front = -(x * area.x + y * area.y + z * area.z);
    const float size = __builtin_sqrtf(area.x * area.x + area.y * area.y + area.z * area.z) * kPerPi;
    const Lanes near = x * x + y * y + z * z + size;
    Lanes share;
    choose((above > 0) & (front > 0), above * front / (near * near), kZeros, share);
    sum.radiance[0] += radiance.x * share;
    sum.radiance[1] += radiance.y * share;
    sum.radiance[2] += radiance.z * share;
    sum.shares += share;
}

inline void meanLanes(const Emitter* emitters, std::size_t emitter_count, const EmitterPoints& points, Vec3* means) {
    for (std::size_t first = 0; first < points.count; first += kLanes) {
        Lanes point[3] = {}, normal[3] = {};
        for (std::size_t lane = 0; lane < kLanes && first + lane < points.count; ++lane) {
            setLane(point, lane, points.positions[first + lane]);
            setLane(normal, lane, points.normals[first + lane]);
        }
        EmitterSum sum = {};
        for (std::size_t e = 0; e < emitter_count; ++e) addEmitter(emitters[e], point, normal, sum);
        for (std::size_t lane = 0; lane < kLanes && first + lane < points.count; ++lane) {
            const float shares = sum.shares[lane], scale = shares > 0 ? 1 / shares : 0;
            Vec3& mean = means[first + lane];
            mean.x = sum.radiance[0][lane] * scale;
            mean.y = sum.radiance[1][lane] * scale;
            mean.z = sum.radiance[2][lane] * scale;
        }
    }
}

}  // namespace

const EmitterPath EmitterPath::PENUMBRA_TARGET{meanLanes};

}  // namespace penumbra
