// Far visibility of 8 receivers at a time.
//
// Problem: every vertex sees some ten far parts. Each takes a lookup in its field, two SH rotations, a mirror at the
// horizon and a product of SH functions, a microsecond in all. That is 100 ms for a character.
//
// Naive: farVisibility() (sh/far/far_visibility.h), which this is held to.
//
// Here: receivers of one part go through all of it 8 at a time, one in each lane.
// - Parts go by in the outer loop, so that the points of a field stay in the cache for all receivers.
// - Only the 8 corners of a lookup are gathered receiver by receiver, 40 bytes each.
// - The rotation into the model frame is the same for all lanes. The one from there into the local frames takes three
//   turns about z and two fixed ones, without trigonometry (as in shade_lanes.cpp).
// - Products are taken at 64 directions above the horizon. There and back take a third of what the product of SH
//   coefficients takes, and several products in a row, and the exponential, need no way back in between.
// - Parts that block little are not multiplied in one by one. A few anchors sum them in the model frame, since log V is
//   nearly V - 1, and the receivers around interpolate the sum; one turn and one exponential bring it in. Anchors also
//   say how near each part is, so that what they leave out is what receivers multiply in, and nothing pops.
//
// AVX-512 has twice as many registers, which takes a sixth of the time of AVX2 away; they stay 256 bits wide.
#include "sh/far/anchor_lanes.h"
#include "sh/far/far_grid.h"
#include "sh/far/far_lookup.h"

namespace penumbra {

namespace {

// What a block of 8 receivers has seen so far.
struct Seen {
    Frames frames;
    Lanes near[kDirections];  // product of the parts that block much
    Lanes rest[kFull];        // sum of log V of the others, in the model frame
    Lanes light;              // what being inside of parts leaves, 1 outside of all
    bool has_near, has_rest;
};

// Adds `weight` times the part to the sum. A part that blocks little has log V = V - 1. One that blocks more is darker
// than that in its middle: a cap of a small share s of the sphere goes down to 1 - 36 s with 36 coefficients, so that
// its logarithm is about 1 + depth * 36 s times as large. Few bands cannot keep what lies below the horizon from
// blocking a little of what lies above, so that the weight falls with the sine of the part's height.
inline void addToRest(const FarConstants& constants, const Lanes& weight, const Lanes& share, const Lanes& sine,
                      const Lanes* model, Seen& seen) {
    Lanes dark = kFull * share, above = 1 + sine;
    clamp(dark, kZeros, kZeros + 1);
    clamp(above, kZeros, kZeros + 1);
    const Lanes scale = weight * above * (1 + constants.depth * dark);
    for (int i = 0; i < kFull; ++i) seen.rest[i] += scale * model[i];
    seen.has_rest = true;
}

// What a part multiplies by: `whole`, plus `weight` times what it blocks from its height over the horizon.
struct Factor {
    Lanes whole, weight, height;
};

inline void addToProduct(const FarConstants& constants, const FarPart& posed, const Factor& factor, Lanes* coefficients,
                         Seen& seen) {
    Turns turns;
    Lanes local[kEven], values[kDirections], by_height;
    makeTurnsFromPart(posed, seen.frames, turns);
    toLocal(constants, turns, coefficients);
    const Lanes sure = factor.height * factor.height, by_bands = factor.weight * (1 - sure);
    choose(factor.height > 0, 2 * factor.weight * sure, kZeros, by_height);
    mirror(constants, coefficients, by_bands, by_height, local, Upto<2 * kOrder - 1>());
    local[0] += kRootOfSphere * factor.whole;
    toGrid<kOrder>(constants.grid, local, values);
    for (int d = 0; d < kDirections; ++d) seen.near[d] = seen.has_near ? seen.near[d] * values[d] : values[d];
    seen.has_near = true;
}

// Adds a part to receivers. `owed` is what anchors have left for them to add, 1 where there are none.
inline void addPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Lanes& owed,
                    Seen& seen) {
    Lanes height, sine;
    Blocked blocked;
    Ints small;
    heightOf(constants, posed, seen.frames, height, sine, small);
    const Ints wanted = (height > -1) & ~small & (owed > 0);
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked)) return;
    seen.light *= 1 - blocked.inside * owed;
    addToProduct(constants, posed, {kZeros + 1, owed * blocked.weight, height}, blocked.coefficients, seen);
}

// Multiplies by a near part. With the gain a, 1 - a (1 - (1 + w g) (1 - inside)) is 1 - a inside + a (1 - inside) w g.
inline void addNearPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Lanes& gain,
                        Seen& seen) {
    Factor factor;
    Lanes sine;
    Blocked blocked;
    Ints small;
    heightOf(constants, posed, seen.frames, factor.height, sine, small);
    const Ints wanted = (factor.height > -1) & ~small & (gain > 0);
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked)) return;
    factor.whole = 1 - gain * blocked.inside;
    factor.weight = gain * (1 - blocked.inside) * blocked.weight;
    addToProduct(constants, posed, factor, blocked.coefficients, seen);
}

// Reads the gains of a near part for the block that begins with receiver `first`.
inline void gatherGains(const FarReceivers& receivers, std::size_t first, std::size_t stride, std::size_t near_part,
                        Lanes& gain) {
    float gains[kLanes];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t r = first + lane < receivers.count ? first + lane : receivers.count - 1;
        gains[lane] = kPerGain * float(receivers.gains[r * stride + near_part]);
    }
    loadFloats(gains, gain);
}

// Sets x to exp(x) = exp(x / 8)^8, for x in [-6, 2].
inline void exponential(Lanes& x) {
    clamp(x, kZeros - 6, kZeros + 2);
    most(x, kZeros - 8, x);  // a crowd may hide more than the series can say
    x *= 0.125f;
    x = 1 + x * (1 + x * (0.5f + x * (1.0f / 6 + x * (1.0f / 24))));
    x *= x;
    x *= x;
    x *= x;
}

inline void finish(const FarConstants& constants, Seen& seen, Lanes* out) {
    if (seen.has_rest) {
        Lanes local[kEven], values[kDirections];
        const Frames& frames = seen.frames;
        Turns turns;
        makeTurns(frames.tangent, frames.bitangent, frames.normal[2], turns);
        toLocal(constants, turns, seen.rest);
        mirror(constants, seen.rest, kZeros + 1, kZeros, local, Upto<2 * kOrder - 1>());
        toGrid<kOrder>(constants.grid, local, values);
        for (int d = 0; d < kDirections; ++d) {
            exponential(values[d]);
            seen.near[d] = seen.has_near ? seen.near[d] * values[d] : values[d];
        }
    }
    if (seen.has_rest || seen.has_near) {
        if (constants.most > 0)
            for (int d = 0; d < kDirections; ++d) least(seen.near[d], kZeros + constants.most, seen.near[d]);
        fromGrid<kOrder>(constants.grid, seen.near, out);
        for (int i = 0; i < kEven; ++i) out[i] *= seen.light;
        return;
    }
    for (int i = 0; i < kEven; ++i) out[i] = kZeros;
    out[0] = kRootOfSphere * seen.light;
}

inline void begin(const FarReceivers& receivers, std::size_t first, Seen& seen) {
    gatherFrames(receivers, first, seen.frames);
    seen.has_near = seen.has_rest = false;
    seen.light = kZeros + 1;
    for (int i = 0; i < kFull; ++i) seen.rest[i] = kZeros;
}

// Writes the sums, and how near each part is. That does not depend on the horizon, which is another one at each
// receiver around.
inline void anchorLanes(const FarConstants& constants, const FarScene& scene, const FarReceivers& receivers,
                        float* values) {
    const std::size_t stride = anchorStride(scene.part_count);
    for (std::size_t first = 0; first < receivers.count; first += kLanes) {
        Seen seen;
        begin(receivers, first, seen);
        Lanes nears[kMaxAnchorParts];
        for (std::size_t p = 0; p < scene.part_count; ++p) {
            const FarPart& posed = scene.posed[scene.parts[p]];
            Lanes height, sine, model[kFull];
            Blocked blocked;
            Ints small;
            nears[p] = kZeros;
            heightOf(constants, posed, seen.frames, height, sine, small);
            if (!any(~small)) continue;
            if (!blockedBy(constants, scene.tables[scene.parts[p]], posed, seen.frames, ~small, blocked)) continue;
            nears[p] = (blocked.share - constants.near[0]) * (1 / (constants.near[1] - constants.near[0]));
            clamp(nears[p], kZeros, kZeros + 1);
            if (scene.spacing > 0) {
                Lanes way[3], by_distance;
                for (int axis = 0; axis < 3; ++axis) way[axis] = posed.center[axis] - seen.frames.position[axis];
                nearness(way, posed.radius, scene.spacing, by_distance);
                most(nears[p], by_distance, nears[p]);
                sine = kZeros;  // the horizons of the receivers around do not agree with that of the anchor
            }
            const Lanes rest = blocked.weight * (1 - nears[p]);
            if (!any(rest > 0)) continue;
            toModel(posed.to_model, blocked.coefficients, model);
            addToRest(constants, rest, blocked.share, sine, model, seen);
        }
        for (std::size_t lane = 0; lane < kLanes && first + lane < receivers.count; ++lane) {
            float* out = values + (first + lane) * stride;
            for (int i = 0; i < kFull; ++i) out[i] = seen.rest[i][lane];
            for (std::size_t i = kFull; i < kAnchorSums; ++i) out[i] = 0;
            for (std::size_t p = 0; p < scene.part_count; ++p) out[kAnchorSums + p] = nears[p][lane];
        }
    }
}

inline void farLanes(const FarConstants& constants, const FarScene& scene, const FarAnchors& anchors,
                     const FarReceivers& receivers, float* far) {
    constexpr std::size_t kMaxBlocks = kMaxReceivers / kLanes;
    Seen seen[kMaxBlocks];
    Lanes nears[kMaxNearParts][kMaxBlocks];
    const std::size_t blocks = (receivers.count + kLanes - 1) / kLanes;
    for (std::size_t b = 0; b < blocks; ++b) {
        begin(receivers, b * kLanes, seen[b]);
        if (!anchors.values) continue;
        Lanes sums[kAnchorSums];
        interpolate(anchors, receivers.count, b * kLanes, sums, &nears[0][b], kMaxBlocks);
        for (int i = 0; i < kFull; ++i) seen[b].rest[i] = sums[i];
        seen[b].has_rest = any(sums[0] < 0);  // a sum of V - 1
    }
    for (std::size_t p = 0; p < scene.part_count; ++p)
        for (std::size_t b = 0; b < blocks; ++b) {
            const FarTable& table = scene.tables[scene.parts[p]];
            const FarPart& posed = scene.posed[scene.parts[p]];
            if (!anchors.values)
                addPart(constants, table, posed, kZeros + 1, seen[b]);
            else if (any(nears[p][b] > 0))
                addPart(constants, table, posed, nears[p][b], seen[b]);
        }
    for (std::size_t n = 0; n < scene.near_count; ++n) {
        const std::uint16_t part = scene.near_parts[n];
        if (part == kNoPart) continue;
        for (std::size_t b = 0; b < blocks; ++b) {
            Lanes gain;
            gatherGains(receivers, b * kLanes, scene.near_count, n, gain);
            addNearPart(constants, scene.tables[part], scene.posed[part], gain, seen[b]);
        }
    }
    for (std::size_t b = 0; b < blocks; ++b) {
        const std::size_t left = receivers.count - b * kLanes;
        Lanes out[kPaddedEven];
        finish(constants, seen[b], out);
        storeRows(out, kEven, kEven, left < kLanes ? left : kLanes, far + b * kLanes * kEven);
    }
}

inline void composeLanes(const FarConstants& constants, const float* far, const float* mean, std::size_t vertices,
                         std::size_t stride, float* coefficients) {
    const int size = constants.compose.size_out;
    for (std::size_t first = 0; first < vertices; first += kLanes) {
        const std::size_t lanes = vertices - first < kLanes ? vertices - first : kLanes;
        Lanes a[kPaddedMaxEven], b[kPaddedMaxEven], out[kPaddedMaxEven];
        loadRows(coefficients + first * stride, stride, size, lanes, a);
        loadRows(far + first * kEven, kEven, kEven, lanes, b);
        for (int i = size; i < kMaxEven; ++i) a[i] = kZeros;
        for (int i = kEven; i < kMaxEven; ++i) b[i] = kZeros;
        if (constants.order == 5)
            multiplyOnGrid<5>(constants, a, b, out);
        else if (constants.order <= kOrder)
            multiplyOnGrid<kOrder>(constants, a, b, out);
        else
            product(constants.compose, a, b, out);
        storeRows(out, stride, size, lanes, coefficients + first * stride);
        if (!mean) continue;
        for (std::size_t lane = 0; lane < lanes; ++lane)
            for (std::size_t i = (first + lane) * stride; i < (first + lane) * stride + std::size_t(size); ++i)
                coefficients[i] += mean[i];
    }
}

}  // namespace

const FarPath FarPath::PENUMBRA_TARGET{anchorLanes, farLanes, composeLanes};

}  // namespace penumbra
