#pragma once
// Interpolates between the keys of an animated property, as in appendix C of glTF 2.0.
#include <algorithm>
#include <cstddef>
#include <vector>

namespace penumbra {

// Tells where a time lies between keys: at `fraction` of the way from key `from` to key `to`.
struct KeySpan {
    std::size_t from = 0, to = 0;
    double fraction = 0, duration = 0;  // seconds between the keys
};

inline KeySpan findKeys(const std::vector<double>& times, double time) {
    if (time <= times.front()) return {};
    const std::size_t last = times.size() - 1;
    if (time >= times.back()) return {last, last};
    const std::size_t to = std::size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin());
    const double duration = times[to] - times[to - 1];
    return {to - 1, to, (time - times[to - 1]) / duration, duration};
}

// Returns number i of a key of 3 n numbers (in-tangents, values, out-tangents) by a Hermite spline: p(t) =
// (2t^3-3t^2+1) v0 + d (t^3-2t^2+t) b0 + (3t^2-2t^3) v1 + d (t^3-t^2) a1. A key has the in-tangent a, the value v and
// the out-tangent b; d is the time between the two keys.
inline double cubicSpline(const float* from, const float* to, std::size_t n, std::size_t i, const KeySpan& span) {
    const double t = span.fraction, t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * from[n + i] + span.duration * (t3 - 2 * t2 + t) * from[2 * n + i] +
           (3 * t2 - 2 * t3) * to[n + i] + span.duration * (t3 - t2) * to[i];
}

}  // namespace penumbra
