#pragma once
// Embree 3 (Debian 12) and Embree 4 (Debian 13 and Ubuntu 24.04) under one set of names. Everything in which the two
// differ for us is in this file: how a query of a scene is put. Their bakes are the same bytes (docs/accuracy.md).
#if PENUMBRA_EMBREE_MAJOR == 3
#include <embree3/rtcore.h>
#else
#include <embree4/rtcore.h>
#endif

namespace penumbra {

// Whether the rays of a packet go nearly the same way, from nearly the same place.
enum class Packets { kAny, kCoherent };

#if PENUMBRA_EMBREE_MAJOR == 3

constexpr RTCSceneFlags kSceneTakesFilters = RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION;

// How rays are traced: with a filter or none, and whether Embree shall take the rays of a packet for coherent. Embree
// gives the filter the address of `context`, which is the first member, so that the filter finds by a cast what stands
// behind the query. A scene that is asked with a filter needs the flag kSceneTakesFilters.
struct RayQuery {
    RTCIntersectContext context;

    explicit RayQuery(RTCFilterFunctionN filter = nullptr, Packets packets = Packets::kAny) {
        rtcInitIntersectContext(&context);
        context.filter = filter;
        if (packets == Packets::kCoherent) context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    }
};

inline void occluded1(RTCScene scene, RayQuery& query, RTCRay& ray) { rtcOccluded1(scene, &query.context, &ray); }
inline void occluded8(const int* valid, RTCScene scene, RayQuery& query, RTCRay8& rays) {
    rtcOccluded8(valid, scene, &query.context, &rays);
}
inline void intersect1(RTCScene scene, RayQuery& query, RTCRayHit& hit) { rtcIntersect1(scene, &query.context, &hit); }
inline void intersect8(const int* valid, RTCScene scene, RayQuery& query, RTCRayHit8& hits) {
    rtcIntersect8(valid, scene, &query.context, &hits);
}

#else

constexpr RTCSceneFlags kSceneTakesFilters = RTC_SCENE_FLAG_FILTER_FUNCTION_IN_ARGUMENTS;

// A query as Embree 4 wants it: the filter and the flags stand apart from the context.
struct RayQuery {
    RTCRayQueryContext context;
    RTCOccludedArguments occluded;
    RTCIntersectArguments intersect;

    explicit RayQuery(RTCFilterFunctionN filter = nullptr, Packets packets = Packets::kAny) {
        rtcInitRayQueryContext(&context);
        rtcInitOccludedArguments(&occluded);
        rtcInitIntersectArguments(&intersect);
        occluded.filter = intersect.filter = filter;
        occluded.flags = intersect.flags = RTCRayQueryFlags(
            (packets == Packets::kCoherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT) |
            (filter ? RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER : RTC_RAY_QUERY_FLAG_NONE));
    }
};

inline void occluded1(RTCScene scene, RayQuery& query, RTCRay& ray) {
    query.occluded.context = &query.context;
    rtcOccluded1(scene, &ray, &query.occluded);
}
inline void occluded8(const int* valid, RTCScene scene, RayQuery& query, RTCRay8& rays) {
    query.occluded.context = &query.context;
    rtcOccluded8(valid, scene, &rays, &query.occluded);
}
inline void intersect1(RTCScene scene, RayQuery& query, RTCRayHit& hit) {
    query.intersect.context = &query.context;
    rtcIntersect1(scene, &hit, &query.intersect);
}
inline void intersect8(const int* valid, RTCScene scene, RayQuery& query, RTCRayHit8& hits) {
    query.intersect.context = &query.context;
    rtcIntersect8(valid, scene, &hits, &query.intersect);
}

#endif

}  // namespace penumbra
