#include <pmmintrin.h>
#include <xmmintrin.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <stdexcept>
#include <string>

#include "bake/trace/embree.h"
#include "bake/trace/occlusion.h"
#include "bake/trace/scene_triangles.h"
#include "bake/trace/waiting_rays.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

// Embree wants denormals flushed to zero in every thread that traces. The destructor gives the thread its own mode
// back.
class FlushDenormals {
public:
    FlushDenormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
    ~FlushDenormals() { _mm_setcsr(saved_); }
    FlushDenormals(const FlushDenormals&) = delete;
    FlushDenormals& operator=(const FlushDenormals&) = delete;

private:
    unsigned saved_;
};

// Throws if the last call of Embree failed.
void check(RTCDevice device, const char* what) {
    const RTCError error = rtcGetDeviceError(device);
    if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
    if (error != RTC_ERROR_NONE)
        throw std::runtime_error(std::string("Embree: ") + what + " failed (error " + std::to_string(error) + ")");
}

}  // namespace

// All scenes of the process share one device. "threads=1" would cap TBB for the whole process, our own loops included
// (Embree holds a tbb::global_control). With loops on std::thread it keeps Embree's builder on the calling thread,
// since ThreadSanitizer cannot see into it.
#ifdef PENUMBRA_STD_THREAD
constexpr const char* kDeviceConfig = "threads=1";
#else
constexpr const char* kDeviceConfig = "";
#endif

namespace {

RTCDevice sharedDevice() {
    static const struct Device {
        RTCDevice handle = rtcNewDevice(kDeviceConfig);
        ~Device() { rtcReleaseDevice(handle); }
    } device;
    if (!device.handle) check(nullptr, "making a device");
    return device.handle;
}

}  // namespace

struct OcclusionScene::Impl {
    RTCDevice device = sharedDevice();
    RTCScene scene = rtcNewScene(device);
    std::vector<Triangle> triangles;  // only for nextHit()
    SceneTriangles numbers;

    Impl() = default;
    Impl(const Impl&) = delete;
    Impl& operator=(const Impl&) = delete;
    ~Impl() { rtcReleaseScene(scene); }
};

namespace {

template <class T>
void fillBuffer(RTCGeometry geometry, RTCBufferType type, RTCFormat format, std::span<const T> values) {
    static_assert(sizeof(T) == 12);
    void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), values.size());
    if (buffer) std::memcpy(buffer, values.data(), values.size_bytes());
}

// Lets rays through where the opacity of a triangle says so. The filter belongs to the geometry, so that it runs before
// those of queries, and triangles that stop all rays cost nothing.
void passThrough(const RTCFilterFunctionNArguments* arguments) {
    const auto& triangles = *static_cast<const SceneTriangles*>(arguments->geometryUserPtr);
    const unsigned n = arguments->N;
    RTCRayN* ray = arguments->ray;
    RTCHitN* hit = arguments->hit;
    for (unsigned k = 0; k < n; ++k) {
        if (arguments->valid[k] != -1) continue;
        const Vec3 origin{RTCRayN_org_x(ray, n, k), RTCRayN_org_y(ray, n, k), RTCRayN_org_z(ray, n, k)};
        const Vec3 direction{RTCRayN_dir_x(ray, n, k), RTCRayN_dir_y(ray, n, k), RTCRayN_dir_z(ray, n, k)};
        if (!triangles.stops(RTCHitN_primID(hit, n, k), RTCHitN_u(hit, n, k), RTCHitN_v(hit, n, k), origin, direction))
            arguments->valid[k] = 0;
    }
}

// Adds triangles to a scene as the geometry of this number. Rays pass through them if `filtered` is set.
void attachTriangles(RTCScene scene, unsigned number, std::span<const Vec3> positions,
                     std::span<const Triangle> triangles, SceneTriangles* filtered = nullptr) {
    RTCGeometry geometry = rtcNewGeometry(sharedDevice(), RTC_GEOMETRY_TYPE_TRIANGLE);
    fillBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, positions);
    fillBuffer(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
    if (filtered) {
        rtcSetGeometryUserData(geometry, filtered);
        rtcSetGeometryOccludedFilterFunction(geometry, passThrough);
        rtcSetGeometryIntersectFilterFunction(geometry, passThrough);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, number);
    rtcReleaseGeometry(geometry);
}

// The query of nextHit(), with what its filter needs.
struct PassingQuery {
    RayQuery query;  // first, so that the filter finds the rest by a cast
    const std::vector<Triangle>* triangles;
    const SceneTriangles* numbers;
    Triangle passed;

    const Triangle& hitOf(const RTCFilterFunctionNArguments* arguments) const {
        return (*triangles)[numbers->numberOf(RTCHitN_geomID(arguments->hit, arguments->N, 0),
                                              RTCHitN_primID(arguments->hit, arguments->N, 0))];
    }
};

// Rejects a hit on a triangle that has a corner of `passed`. Embree calls the filter for each candidate of a single
// ray.
void passOwnTriangles(const RTCFilterFunctionNArguments* arguments) {
    const auto& passing = *reinterpret_cast<const PassingQuery*>(arguments->context);
    for (const std::uint32_t corner : passing.hitOf(arguments))
        for (const std::uint32_t passed : passing.passed)
            if (corner == passed) arguments->valid[0] = 0;
}

}  // namespace

OcclusionScene::OcclusionScene(std::span<const Vec3> positions, std::span<const Triangle> triangles, Queries queries,
                               const SeeThrough& through)
    : impl_(std::make_unique<Impl>()) {
    const FlushDenormals flush;
    if (queries == Queries::kFiltered) {
        rtcSetSceneFlags(impl_->scene, kSceneTakesFilters);
        impl_->triangles.assign(triangles.begin(), triangles.end());
    }
    SceneTriangles& numbers = impl_->numbers = SceneTriangles(triangles.size(), through);
    if (numbers.all_stop) {
        attachTriangles(impl_->scene, 0, positions, triangles);
    } else {
        std::vector<Triangle> stopping, filtered;
        for (const std::uint32_t t : numbers.stopping) stopping.push_back(triangles[t]);
        for (const FilteredTriangle& t : numbers.filtered) filtered.push_back(triangles[t.number]);
        if (!stopping.empty()) attachTriangles(impl_->scene, 0, positions, stopping);
        if (!filtered.empty()) attachTriangles(impl_->scene, kFilteredGeometry, positions, filtered, &numbers);
    }
    rtcCommitScene(impl_->scene);
    check(impl_->device, "building a scene");
}

OcclusionScene::~OcclusionScene() = default;
OcclusionScene::OcclusionScene(OcclusionScene&&) noexcept = default;
OcclusionScene& OcclusionScene::operator=(OcclusionScene&&) noexcept = default;

namespace {

RTCRay makeRay(Vec3 origin, Vec3 direction, float min_distance) {
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tnear = min_distance;
    ray.tfar = kInfinity;
    ray.mask = ~0u;
    return ray;
}

}  // namespace

bool OcclusionScene::occluded(Vec3 origin, Vec3 unit_direction, float min_distance) const {
    const FlushDenormals flush;
    RayQuery query;
    RTCRay ray = makeRay(origin, unit_direction, min_distance);
    occluded1(impl_->scene, query, ray);
    return ray.tfar < 0;  // Embree marks a blocked ray by tfar = -infinity
}

namespace {

SurfaceHit surfaceHit(const RTCRayHit& hit, const SceneTriangles& numbers) {
    return {numbers.numberOf(hit.hit.geomID, hit.hit.primID),
            hit.hit.u,
            hit.hit.v,
            hit.ray.tfar,
            {hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z}};
}

}  // namespace

std::optional<SurfaceHit> OcclusionScene::closestHit(Vec3 origin, Vec3 unit_direction) const {
    const FlushDenormals flush;
    RayQuery query;
    RTCRayHit hit{};
    hit.ray = makeRay(origin, unit_direction, 0);
    hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    intersect1(impl_->scene, query, hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return surfaceHit(hit, impl_->numbers);
}

std::optional<SurfaceHit> OcclusionScene::nextHit(Vec3 origin, Vec3 unit_direction, Stretch stretch,
                                                  const Triangle& passed) const {
    const FlushDenormals flush;
    PassingQuery passing{RayQuery(passOwnTriangles), &impl_->triangles, &impl_->numbers, passed};
    RTCRayHit hit{};
    hit.ray = makeRay(origin, unit_direction, std::max(stretch.from, 0.0f));
    hit.ray.tfar = stretch.to;
    hit.hit.geomID = hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    intersect1(impl_->scene, passing.query, hit);
    if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
    return surfaceHit(hit, impl_->numbers);
}

namespace {

// Eight rays from one point. The number of each lane is the ray's id, by which a filter knows it.
RTCRay8 packetFrom(Vec3 origin) {
    RTCRay8 packet{};
    std::fill_n(packet.org_x, kLanes, origin.x);
    std::fill_n(packet.org_y, kLanes, origin.y);
    std::fill_n(packet.org_z, kLanes, origin.z);
    std::fill_n(packet.mask, kLanes, ~0u);
    std::iota(packet.id, packet.id + kLanes, 0u);
    return packet;
}

// Traces the lanes of a packet whose weight in `traced` is not 0. Afterwards packet.tfar of a blocked lane is
// -infinity. Returns false when there is no such lane; then packet.tfar means nothing.
bool tracePacket(RTCScene scene, RayQuery& query, const DirectionPacket& directions, const LaneWeights& traced,
                 RTCRay8& packet) {
    alignas(32) int valid[kLanes];
    int any = 0;
    for (std::size_t k = 0; k < kLanes; ++k) any |= valid[k] = traced.lane[k] != 0 ? -1 : 0;
    if (!any) return false;
    std::copy(directions.x.begin(), directions.x.end(), packet.dir_x);
    std::copy(directions.y.begin(), directions.y.end(), packet.dir_y);
    std::copy(directions.z.begin(), directions.z.end(), packet.dir_z);
    occluded8(valid, scene, query, packet);
    return true;
}

// Sets the weights of the blocked lanes to 0.
void dropBlocked(const RTCRay8& packet, LaneWeights& weights) {
    for (std::size_t k = 0; k < kLanes; ++k) weights.lane[k] = packet.tfar[k] < 0 ? 0.0f : weights.lane[k];
}

}  // namespace

void OcclusionScene::removeOccluded(Vec3 origin, const RayDirections& directions, std::span<LaneWeights> rays,
                                    std::span<const LaneWeights> reach) const {
    assert(rays.size() == directions.packets.size() && (reach.empty() || reach.size() == rays.size()));
    const FlushDenormals flush;
    RayQuery query;
    RTCRay8 packet = packetFrom(origin);
    for (std::size_t p = 0; p < rays.size(); ++p) {
        std::fill_n(packet.tfar, kLanes, kInfinity);
        if (!reach.empty()) std::copy_n(reach[p].lane.begin(), kLanes, packet.tfar);
        if (tracePacket(impl_->scene, query, directions.packets[p], rays[p], packet)) dropBlocked(packet, rays[p]);
    }
}

// --- Local triangles ------------------------------------------------------------------------------------------------
// A ray that escapes the whole scene escapes the local triangles too, so only blocked rays are in question. The first
// triangle that Embree finds for a blocked ray is often local, which answers the question as well. The other rays are
// traced once more through the same tree, where a filter now rejects all triangles that are not local.

namespace {

// A query of removeOccludedLocally(), with what its filters need.
struct LocalQuery {
    RayQuery query;  // first, so that a filter finds the rest by a cast
    const LocalTriangles* local;
    const SceneTriangles* numbers;
    LaneWeights* near;  // written for the packet that is traced

    bool isLocal(const RTCFilterFunctionNArguments* arguments, unsigned lane) const {
        return local->contains(numbers->numberOf(RTCHitN_geomID(arguments->hit, arguments->N, lane),
                                                 RTCHitN_primID(arguments->hit, arguments->N, lane)));
    }
};

// Accepts every hit, and notes which lanes hit a local triangle. The trace goes on as if there was no filter.
void noteLocal(const RTCFilterFunctionNArguments* arguments) {
    const auto& query = *reinterpret_cast<const LocalQuery*>(arguments->context);
    for (unsigned k = 0; k < arguments->N; ++k)
        if (arguments->valid[k] == -1 && query.isLocal(arguments, k))
            query.near->lane[RTCRayN_id(arguments->ray, arguments->N, k)] = 0;
}

// Rejects the hits on triangles that are not local.
void passFar(const RTCFilterFunctionNArguments* arguments) {
    const auto& query = *reinterpret_cast<const LocalQuery*>(arguments->context);
    for (unsigned k = 0; k < arguments->N; ++k)
        if (arguments->valid[k] == -1 && !query.isLocal(arguments, k)) arguments->valid[k] = 0;
}

// Traces the waiting rays against what the query's filter accepts. Sets the weights of those that it blocks to 0.
void traceWaiting(RTCScene scene, RayQuery& query, WaitingRays& waiting, RTCRay8& packet) {
    std::fill(waiting.reach.lane.begin() + std::ptrdiff_t(waiting.count), waiting.reach.lane.end(), 0.0f);
    std::copy(waiting.reach.lane.begin(), waiting.reach.lane.end(), packet.tfar);
    if (!tracePacket(scene, query, waiting.directions, waiting.reach, packet)) return;
    for (std::size_t k = 0; k < waiting.count; ++k)
        if (packet.tfar[k] < 0) *waiting.weight[k] = 0;
    waiting.count = 0;
}

}  // namespace

void OcclusionScene::removeOccludedLocally(Vec3 origin, const RayDirections& directions, const LocalTriangles& local,
                                           std::span<LaneWeights> rays, std::span<LaneWeights> near) const {
    assert(rays.size() == directions.packets.size() && near.size() == rays.size());
    const FlushDenormals flush;
    const SceneTriangles& numbers = impl_->numbers;
    LocalQuery first{RayQuery(noteLocal), &local, &numbers, nullptr},
        second{RayQuery(passFar), &local, &numbers, nullptr};
    RTCRay8 packet = packetFrom(origin);
    WaitingRays waiting;
    for (std::size_t p = 0; p < rays.size(); ++p) {
        // 1. Trace all rays, and note those that a local triangle blocks.
        first.near = &near[p];
        std::fill_n(packet.tfar, kLanes, kInfinity);
        if (tracePacket(impl_->scene, first.query, directions.packets[p], rays[p], packet))
            dropBlocked(packet, rays[p]);
        // 2. Trace again the rays that something else blocks. Most packets have few of them, so they wait until there
        // are enough for a packet.
        if (rays[p].lane == near[p].lane) continue;
        const LaneWeights reach = localReach(origin, directions.packets[p], local);
        for (std::size_t k = 0; k < kLanes; ++k) {
            if (near[p].lane[k] == rays[p].lane[k] || reach.lane[k] == 0) continue;
            waiting.add(directions.packets[p], k, reach.lane[k], near[p].lane[k]);
            if (waiting.count == kLanes) traceWaiting(impl_->scene, second.query, waiting, packet);
        }
    }
    traceWaiting(impl_->scene, second.query, waiting, packet);
}

// --- First hits -----------------------------------------------------------------------------------------------------

namespace {

// Eight rays from one point for intersect8().
RTCRayHit8 hitPacketFrom(Vec3 origin) {
    RTCRayHit8 packet{};
    packet.ray = packetFrom(origin);
    return packet;
}

// Finds what the lanes with valid = -1 meet first. Afterwards geomID of a lane that meets nothing is
// RTC_INVALID_GEOMETRY_ID.
void intersectPacket(RTCScene scene, RayQuery& query, const DirectionPacket& directions, const int* valid,
                     RTCRayHit8& packet) {
    std::copy(directions.x.begin(), directions.x.end(), packet.ray.dir_x);
    std::copy(directions.y.begin(), directions.y.end(), packet.ray.dir_y);
    std::copy(directions.z.begin(), directions.z.end(), packet.ray.dir_z);
    std::fill_n(packet.ray.tfar, kLanes, kInfinity);
    std::fill_n(packet.hit.geomID, kLanes, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(packet.hit.instID[0], kLanes, RTC_INVALID_GEOMETRY_ID);
    intersect8(valid, scene, query, packet);
}

// Tells whether a lane of a traced packet met the back of its triangle.
bool metBack(const RTCRayHit8& packet, std::size_t k) {
    const RTCHit8& hit = packet.hit;
    const RTCRay8& ray = packet.ray;
    return hit.Ng_x[k] * ray.dir_x[k] + hit.Ng_y[k] * ray.dir_y[k] + hit.Ng_z[k] * ray.dir_z[k] > 0;
}

}  // namespace

void OcclusionScene::removeOccluded(Vec3 origin, const RayDirections& directions, std::span<LaneWeights> rays,
                                    std::vector<FirstHit>& hits) const {
    assert(rays.size() == directions.packets.size());
    const FlushDenormals flush;
    RayQuery query;
    RTCRayHit8 packet = hitPacketFrom(origin);
    for (std::size_t p = 0; p < rays.size(); ++p) {
        alignas(32) int valid[kLanes];
        int any = 0;
        for (std::size_t k = 0; k < kLanes; ++k) any |= valid[k] = rays[p].lane[k] != 0 ? -1 : 0;
        if (!any) continue;
        intersectPacket(impl_->scene, query, directions.packets[p], valid, packet);
        for (std::size_t k = 0; k < kLanes; ++k) {
            if (!valid[k] || packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
            rays[p].lane[k] = 0;
            hits.push_back({std::uint32_t(p * kLanes + k),
                            impl_->numbers.numberOf(packet.hit.geomID[k], packet.hit.primID[k]), packet.hit.u[k],
                            packet.hit.v[k], metBack(packet, k)});
        }
    }
}

void OcclusionScene::firstSides(Vec3 origin, std::span<const DirectionPacket> packets,
                                std::span<const std::uint8_t> sheets, std::span<LaneSides> sides) const {
    assert(sides.size() == packets.size());
    const FlushDenormals flush;
    RayQuery query;
    RTCRayHit8 packet = hitPacketFrom(origin);
    for (std::size_t p = 0; p < packets.size(); ++p) {
        const DirectionPacket& d = packets[p];
        alignas(32) int valid[kLanes];
        for (std::size_t k = 0; k < kLanes; ++k) valid[k] = d.x[k] != 0 || d.y[k] != 0 || d.z[k] != 0 ? -1 : 0;
        intersectPacket(impl_->scene, query, d, valid, packet);
        for (std::size_t k = 0; k < kLanes; ++k) {
            const bool met = valid[k] && packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
            bool back = met && metBack(packet, k) && !impl_->numbers.isTwin(packet.hit.geomID[k], packet.hit.primID[k]);
            if (back && !sheets.empty())
                back = !sheets[impl_->numbers.numberOf(packet.hit.geomID[k], packet.hit.primID[k])];
            sides[p].lane[k] = !met ? MetSide::kNone : back ? MetSide::kBack : MetSide::kFront;
        }
    }
}

SceneScale sceneScale(std::span<const Vec3> positions, double diagonal) {
    assert(!positions.empty() && diagonal > 0);
    const BoundingBox box = boundsOf(positions);
    return {(toDouble(box.low) + toDouble(box.high)) * 0.5, diagonal};
}

}  // namespace penumbra
