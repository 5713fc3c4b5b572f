// Visibility past spheres, for 8 receivers at a time.
//
// Problem: one receiver takes a microsecond and more: 15 lookups with three roots each, and three SH products whose
// terms are scattered.
//
// Naive: netLog() and expOfLog() (sh/cast/cap_visibility.h, sh/cast/log_visibility.h), which this is held to.
//
// Here: receivers fill the lanes of vectors. All of them go through the same spheres and the same terms, so that
// nothing but the rows of the table is gathered, 32 bytes each. Only the number of squarings differs; lanes that have
// enough keep what they have.
#include "sh/cast/cap_visibility.h"
#include "sh/cast/cast_kernel.h"
#include "sh/far/anchor_lanes.h"
#include "sh/far/far_turns.h"
#include "sh/fixed_basis.h"

namespace penumbra {

namespace {

constexpr float kEntryOfHalfSine = 515.40939f;  // (kCapLogEntries - 1) / sin(kMaxCapAngle / 2)
constexpr int kMaxCastSquarings = 8;
constexpr float kMaxNorm = 24;  // of a logarithm; those of one person are below 15

// The unit direction to the center, and the place of the cap in the table; both are 0 where nothing is hidden.
struct CapLanes {
    Lanes x, y, z, entry;
};

// Returns whether any receiver sees the sphere. The comments are in sineOfCap(). `weight` is that of its logarithm.
// Spheres that fade with distance also fade towards their centers instead of near their surfaces: sin^2, and with it E
// where the normal points at the center, is linear in the distance from there.
inline bool seeSphere(const CastScene& scene, const float* sphere, const Lanes* at, CapLanes& cap, Lanes& weight) {
    const Lanes x = sphere[0] - at[0], y = sphere[1] - at[1], z = sphere[2] - at[2];
    const float radius = sphere[3];
    if (!(radius > 0)) return false;
    Lanes distance = x * x + y * y + z * z, per_distance, inside, sine, cosine, both;
    root(distance);
    choose(distance >= 1e-6f, 1 / distance, kZeros, per_distance);
    inside = distance * (1 / radius);
    if (scene.full > 0)
        root(inside);
    else
        inside = (inside - 0.85f) * (1 / 0.15f);
    choose(distance >= radius, radius * per_distance, inside, sine);
    choose(distance >= 1e-6f, sine, kZeros, sine);
    clamp(sine, kZeros, kZeros + 1);
    if (scene.full > 0) {
        const Lanes half = 0.5f * radius * per_distance;
        weight = (half * half - scene.least) * (1 / (scene.full - scene.least));
        clamp(weight, kZeros, kZeros + 1);
        choose(weight > 0, sine, kZeros, sine);
    }
    if (!any(sine > 0)) return false;
    cosine = (1 - sine) * (1 + sine);
    root(cosine);
    both = 2 + 2 * cosine;
    root(both);
    cap = {x * per_distance, y * per_distance, z * per_distance, sine / both * kEntryOfHalfSine};
    return true;
}

// Turns the direction to the cap into the frame of the receiver.
inline void turnCap(const Frames& frames, CapLanes& cap) {
    const Lanes *t = frames.tangent, *b = frames.bitangent, *n = frames.normal;
    const Lanes x = cap.x * t[0] + cap.y * t[1] + cap.z * t[2], y = cap.x * b[0] + cap.y * b[1] + cap.z * b[2],
                z = cap.x * n[0] + cap.y * n[1] + cap.z * n[2];
    cap.x = x, cap.y = y, cap.z = z;
}

// Reads the row of each lane. out[l] is that of band l, of 8.
inline void lookUpLogs(const float* logs, const Lanes& entry, Lanes* out) {
    Lanes rows[kLanes];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const int e = int(entry[lane]);  // caps of spheres are 90 degrees at most, so e + 1 is in the table
        Lanes low, high;
        loadFloats(logs + 8 * e, low);
        loadFloats(logs + 8 * e + 8, high);
        rows[lane] = low + (entry[lane] - float(e)) * (high - low);
    }
    transpose((const float*)rows, 8, out);
}

// sum_lm += row_l y_lm(axis), by the recurrences of sh/fixed_basis.h.
template <int Order>
inline void addTurned(const CapLanes& cap, const Lanes* row, Lanes* sum) {
    Lanes re = kZeros + 1, im = kZeros;
    for (int m = 0; m < Order; ++m) {
        Lanes before = kZeros, q = kZeros + float(kRecurrence.start[m]);
        for (int l = m; l < Order; ++l) {
            if (l > m) {
                const Lanes next = float(kRecurrence.rise[l][m]) * cap.z * q - float(kRecurrence.fall[l][m]) * before;
                before = q;
                q = next;
            }
            const Lanes scaled = row[l] * q;
            sum[l * (l + 1) + m] += scaled * re;
            if (m > 0) sum[l * (l + 1) - m] += scaled * im;
        }
        const Lanes next_re = cap.x * re - cap.y * im;
        im = cap.x * im + cap.y * re;
        re = next_re;
    }
}

template <int Order>
inline void sumTerms(const CastTables& tables, const Lanes* pairs, Lanes* out) {
    for (int i = 0; i < Order * Order; ++i) {
        Lanes sum = kZeros;
        for (int t = tables.first[i]; t < tables.first[i + 1]; ++t)
            sum += tables.terms[t].value * pairs[tables.terms[t].pair];
        out[i] = sum;
    }
}

template <int Order>
inline void multiplyLanes(const CastTables& tables, const Lanes* a, const Lanes* b, Lanes* out) {
    constexpr int n = Order * Order;
    Lanes pairs[n * (n + 1) / 2];
    Lanes* next = pairs;
    for (int j = 0; j < n; ++j) {
        *next++ = a[j] * b[j];
        for (int k = j + 1; k < n; ++k) *next++ = a[j] * b[k] + a[k] * b[j];
    }
    sumTerms<Order>(tables, pairs, out);
}

template <int Order>
inline void squareLanes(const CastTables& tables, const Lanes* a, Lanes* out) {
    constexpr int n = Order * Order;
    Lanes pairs[n * (n + 1) / 2];
    Lanes* next = pairs;
    for (int j = 0; j < n; ++j) {
        const Lanes twice = 2 * a[j];
        *next++ = a[j] * a[j];
        for (int k = j + 1; k < n; ++k) *next++ = twice * a[k];
    }
    sumTerms<Order>(tables, pairs, out);
}

// v = exp(v), the smooth form of ExpMethod::kHybPs2.
template <int Order>
inline void exponentialLanes(const CastTables& tables, Lanes* v) {
    constexpr int n = Order * Order;
    // 1. Halve each lane until its norm is 1/2 at the most.
    Lanes norm = kZeros, scale = kZeros + 1;
    for (int i = 1; i < n; ++i) norm += v[i] * v[i];
    root(norm);
    // Where a crowd hides all, its logarithm tells by how much more than all.
    choose(norm > kMaxNorm, kMaxNorm / norm, scale, scale);
    for (int i = 0; i < n; ++i) v[i] *= scale;
    norm *= scale;
    scale = kZeros + 1;
    Ints squarings = {};
    for (int k = 0; k < kMaxCastSquarings; ++k) {
        const Ints large = norm * scale > 0.5f;
        if (!any(large)) break;
        squarings -= large;
        choose(large, scale * 0.5f, scale, scale);
    }
    // 2. Take the power series up to x^3/6.
    Lanes x[n], power[n], cube[n], constant = v[0] * scale * (1 / kRootOfSphere);
    for (std::size_t lane = 0; lane < kLanes; ++lane) setLane(constant, lane, __builtin_expf(constant[lane]));
    x[0] = kZeros;
    for (int i = 1; i < n; ++i) x[i] = v[i] * scale;
    squareLanes<Order>(tables, x, power);
    multiplyLanes<Order>(tables, power, x, cube);
    v[0] = kZeros + kRootOfSphere;
    for (int i = 1; i < n; ++i) v[i] = x[i];
    for (int i = 0; i < n; ++i) v[i] = (v[i] + 0.5f * power[i] + (1 / 6.0f) * cube[i]) * constant;
    // 3. Square each lane as often as it was halved.
    for (int k = 0; any(squarings > k); ++k) {
        squareLanes<Order>(tables, v, power);
        const Ints on = squarings > k;
        for (int i = 0; i < n; ++i) choose(on, power[i], v[i], v[i]);
    }
}

constexpr std::size_t kMirroredCoefficients = std::size_t(kEven), kMirroredRow = std::size_t(kPaddedEven);
template <int... I>
inline void mirrorLanes(const CastTables& tables, const Lanes* v, Lanes* out, Numbers<I...>) {
    (mirrorOrder<I - kOrder + 1>(tables.turns->mirror, v, kZeros + 1, kZeros, out), ...);
}

// Lanes beyond the last position get the first one of the block.
inline void loadPositions(const Vec3* positions, std::size_t lanes, Lanes* at) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) setLane(at, lane, positions[lane < lanes ? lane : 0]);
}

// Takes the sum of the spheres that are not near into the frames of 8 receivers. Returns whether there are any.
inline bool takeAnchors(const CastTables& tables, const CastScene& scene, std::size_t first, const Frames& frames,
                        Lanes* v, Lanes* near) {
    interpolate(scene.anchors, scene.count, first, v, near, 1);
    if (!any(v[0] < 0)) return false;
    Turns turns;
    makeTurns(frames.tangent, frames.bitangent, frames.normal[2], turns);
    toLocal(*tables.turns, turns, v);
    return true;
}

template <int Order>
inline void castLanesOf(const CastTables& tables, const CastScene& scene, float* out) {
    constexpr int n = Order * Order;
    for (std::size_t first = 0; first < scene.count; first += kLanes) {
        const std::size_t lanes = scene.count - first < kLanes ? scene.count - first : kLanes;
        Lanes at[3];
        loadPositions(scene.positions + first, lanes, at);
        Frames frames = {};
        if (scene.normals) gatherFrames({scene.positions, scene.normals, scene.tangents, scene.count}, first, frames);
        Lanes v[40] = {}, row[8];
        CapLanes cap;
        Lanes weight = kZeros + 1, near[kMaxNearParts];
        bool seen = scene.anchors.values && takeAnchors(tables, scene, first, frames, v, near);
        for (std::size_t s = 0; s < scene.sphere_count; ++s) {
            if (scene.anchors.values && !any(near[s] > 0)) continue;
            if (!seeSphere(scene, scene.spheres + 4 * s, at, cap, weight)) continue;
            if (scene.anchors.values) weight *= near[s];
            lookUpLogs(tables.logs, cap.entry, row);
            for (int l = 0; l < Order; ++l) row[l] *= weight;
            if (scene.normals) turnCap(frames, cap);
            addTurned<Order>(cap, row, v);
            seen = true;
        }
        if (seen)
            exponentialLanes<Order>(tables, v);
        else
            v[0] = kZeros + kRootOfSphere;
        if (!scene.normals) {
            storeRows(v, std::size_t(n), n, lanes, out + first * std::size_t(n));
            continue;
        }
        Lanes mirrored[kMirroredRow];
        mirrorLanes(tables, v, mirrored, Upto<2 * kOrder - 1>());
        storeRows(mirrored, kMirroredCoefficients, int(kMirroredCoefficients), lanes,
                  out + first * kMirroredCoefficients);
    }
}

void castAnchorLanes(const CastTables& tables, const CastScene& scene, float* values) {
    constexpr int kLogOrder = 5;
    const std::size_t stride = anchorStride(scene.sphere_count);
    for (std::size_t first = 0; first < scene.count; first += kLanes) {
        const std::size_t lanes = scene.count - first < kLanes ? scene.count - first : kLanes;
        Lanes at[3];
        loadPositions(scene.positions + first, lanes, at);
        Lanes v[kAnchorSums] = {}, row[8];
        CapLanes cap;
        Lanes weight = kZeros + 1;
        float* const out = values + first * stride;
        for (std::size_t s = 0; s < scene.sphere_count; ++s) {
            const float* sphere = scene.spheres + 4 * s;
            const Lanes way[3] = {sphere[0] - at[0], sphere[1] - at[1], sphere[2] - at[2]};
            Lanes near;
            nearness(way, sphere[3], scene.spacing, near);
            for (std::size_t lane = 0; lane < lanes; ++lane) out[lane * stride + kAnchorSums + s] = near[lane];
            if (!any(near < 1) || !seeSphere(scene, sphere, at, cap, weight)) continue;
            weight *= 1 - near;
            lookUpLogs(tables.logs, cap.entry, row);
            for (int l = 0; l < kLogOrder; ++l) row[l] *= weight;
            addTurned<kLogOrder>(cap, row, v);
        }
        storeRows(v, stride, int(kAnchorSums), lanes, out);
        for (std::size_t s = kAnchorSums + scene.sphere_count; s < stride; ++s)
            for (std::size_t lane = 0; lane < lanes; ++lane) out[lane * stride + s] = 0;
    }
}

void castLanes(const CastTables& tables, const CastScene& scene, float* out) {
    switch (tables.order) {
        case 3:
            return castLanesOf<3>(tables, scene, out);
        case 4:
            return castLanesOf<4>(tables, scene, out);
        case 5:
            return castLanesOf<5>(tables, scene, out);
        default:
            return castLanesOf<6>(tables, scene, out);
    }
}

}  // namespace

const CastPath CastPath::PENUMBRA_TARGET{castLanes, castAnchorLanes};

}  // namespace penumbra
