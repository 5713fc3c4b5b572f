// Far visibility of 8 receivers at a time.
//
// Problem: every vertex sees some ten far parts. Each takes a lookup in its field, two SH rotations, a mirror at the
// horizon and a product of SH functions, a microsecond in all. That is 100 ms for a character.
//
// Naive: farVisibility() (sh/far_visibility.h), which this is held to.
//
// Here: receivers of one part go through all of it 8 at a time, one in each lane.
// - Parts go by in the outer loop, so that the points of a field stay in the cache for all receivers.
// - Only the 8 corners of a lookup are gathered receiver by receiver, 40 bytes each.
// - The rotation into the model frame is the same for all lanes. The one from there into the local frames takes three
//   turns about z and two fixed ones, without trigonometry (as in shade_lanes.h).
// - A product needs each a_j b_k + a_k b_j once.
// - Parts that block little are summed in the model frame instead of being multiplied: log V is nearly V - 1. One
//   exponential brings them in at the end. Parts move from one way to the other smoothly.
// - These sums vary slowly over a part, so that a few anchors compute them, and the receivers around take their mean.
//   Anchors also say how near each part is, so that what they leave out is what receivers add, and nothing pops.
//
// far_portable.cpp and far_avx2.cpp include this source and differ in the processor that they are compiled for.
// Everything has internal linkage and calls nothing inline from the standard library (shade_lanes.h tells why).
#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "player/runtime/far_kernel.h"
#include "sh/far_visibility.h"

namespace penumbra {

namespace {

constexpr int kOrder = 6, kFull = 36, kEven = 21, kRow = 40, kDistance = 36;
constexpr int kMostEven = 36;                // numbers of a mirrored function of order kMaxOrder
constexpr float kRootOfSphere = 3.5449077f;  // sqrt(4 pi): the coefficient of the function 1

typedef float Lanes __attribute__((vector_size(4 * kFarLanes)));
typedef std::int32_t Ints __attribute__((vector_size(4 * kFarLanes)));
typedef signed char Bytes __attribute__((vector_size(kFarLanes)));

const Lanes kZeros = {};
inline void choose(const Ints& mask, const Lanes& yes, const Lanes& no, Lanes& out) {
    out = (Lanes)((mask & (Ints)yes) | (~mask & (Ints)no));
}
// The smaller and the larger of the two; b where a is not a number.
inline void least(const Lanes& a, const Lanes& b, Lanes& out) { choose(a < b, a, b, out); }
inline void most(const Lanes& a, const Lanes& b, Lanes& out) { choose(a > b, a, b, out); }
inline void clamp(Lanes& x, const Lanes& low, const Lanes& high) {
    most(x, low, x);
    least(x, high, x);
}
inline bool any(const Ints& mask) {
#ifdef __AVX2__
    return !_mm256_testz_si256((__m256i)mask, (__m256i)mask);
#else
    std::int32_t bits = 0;
    for (std::size_t i = 0; i < kFarLanes; ++i) bits |= mask[i];
    return bits != 0;
#endif
}
inline void root(Lanes& x) {
#ifdef __AVX2__
    x = (Lanes)_mm256_sqrt_ps((__m256)x);
#else
    for (std::size_t i = 0; i < kFarLanes; ++i) x[i] = __builtin_sqrtf(x[i]);
#endif
}
inline void loadBytes(const std::int8_t* at, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_cvtepi32_ps(_mm256_cvtepi8_epi32(_mm_loadl_epi64((const __m128i*)at)));
#else
    Bytes bytes;
    __builtin_memcpy(&bytes, at, sizeof bytes);
    out = __builtin_convertvector(bytes, Lanes);
#endif
}
inline void loadFloats(const float* at, Lanes& out) { __builtin_memcpy(&out, at, sizeof out); }

// Turns 8 rows of 8 numbers into columns.
inline void transpose(const float* rows, std::size_t row, Lanes* out) {
    Lanes a[8], b[8];
    for (std::size_t i = 0; i < 8; ++i) loadFloats(rows + i * row, a[i]);
    for (std::size_t i = 0; i < 8; i += 2) {
        b[i] = __builtin_shufflevector(a[i], a[i + 1], 0, 8, 1, 9, 4, 12, 5, 13);
        b[i + 1] = __builtin_shufflevector(a[i], a[i + 1], 2, 10, 3, 11, 6, 14, 7, 15);
    }
    for (std::size_t i = 0; i < 8; i += 4)
        for (std::size_t h = 0; h < 2; ++h) {
            a[i + 2 * h] = __builtin_shufflevector(b[i + h], b[i + h + 2], 0, 1, 8, 9, 4, 5, 12, 13);
            a[i + 2 * h + 1] = __builtin_shufflevector(b[i + h], b[i + h + 2], 2, 3, 10, 11, 6, 7, 14, 15);
        }
    for (std::size_t i = 0; i < 4; ++i) {
        out[i] = __builtin_shufflevector(a[i], a[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
        out[i + 4] = __builtin_shufflevector(a[i], a[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
    }
}

struct Frames {
    Lanes position[3], tangent[3], bitangent[3], normal[3];
    // Multiples of the angles of Q = Z(a) Y(b) Z(c), whose rows are tangent, bitangent and normal.
    Lanes cos_a[kOrder], sin_a[kOrder], cos_b[kOrder], sin_b[kOrder], cos_c[kOrder], sin_c[kOrder];
    bool turned;
};

inline void gatherFrames(const FarReceivers& receivers, std::size_t first, Frames& out) {
    for (std::size_t lane = 0; lane < kFarLanes; ++lane) {
        const std::size_t r = first + lane < receivers.count ? first + lane : receivers.count - 1;
        const Vec3 p = receivers.positions[r], n = receivers.normals[r], t = receivers.tangents[r];
        out.position[0][lane] = p.x, out.position[1][lane] = p.y, out.position[2][lane] = p.z;
        out.normal[0][lane] = n.x, out.normal[1][lane] = n.y, out.normal[2][lane] = n.z;
        out.tangent[0][lane] = t.x, out.tangent[1][lane] = t.y, out.tangent[2][lane] = t.z;
    }
    const Lanes *n = out.normal, *t = out.tangent;
    out.bitangent[0] = n[1] * t[2] - n[2] * t[1];
    out.bitangent[1] = n[2] * t[0] - n[0] * t[2];
    out.bitangent[2] = n[0] * t[1] - n[1] * t[0];
    out.turned = false;
}

inline void multiples(Lanes* cosine, Lanes* sine) {
    for (int m = 2; m < kOrder; ++m) {
        cosine[m] = cosine[m - 1] * cosine[1] - sine[m - 1] * sine[1];
        sine[m] = sine[m - 1] * cosine[1] + cosine[m - 1] * sine[1];
    }
}

// As makeTurns() of shade_lanes.h.
inline void makeTurns(Frames& q) {
    for (std::size_t lane = 0; lane < kFarLanes; ++lane) {
        const float x = q.tangent[2][lane], y = q.bitangent[2][lane], square = x * x + y * y;
        const float scale = square > 1e-30f ? 1 / __builtin_sqrtf(square) : 0;
        q.cos_a[1][lane] = square > 1e-30f ? x * scale : 1;
        q.sin_a[1][lane] = y * scale;
    }
    const Lanes cos_a = q.cos_a[1], sin_a = q.sin_a[1];
    q.cos_b[1] = q.normal[2];
    q.sin_b[1] = cos_a * q.tangent[2] + sin_a * q.bitangent[2];
    q.cos_c[1] = cos_a * q.bitangent[1] - sin_a * q.tangent[1];
    q.sin_c[1] = cos_a * q.bitangent[0] - sin_a * q.tangent[0];
    multiples(q.cos_a, q.sin_a);
    multiples(q.cos_b, q.sin_b);
    multiples(q.cos_c, q.sin_c);
    q.turned = true;
}

// Sets f to R(Z(angle)) f.
inline void turn(const Lanes* cosine, const Lanes* sine, Lanes* f) {
    for (int l = 1; l < kOrder; ++l)
        for (int m = 1; m <= l; ++m) {
            Lanes &plus = f[l * l + l + m], &minus = f[l * l + l - m];
            const Lanes turned = cosine[m] * plus - sine[m] * minus;
            minus = cosine[m] * minus + sine[m] * plus;
            plus = turned;
        }
}

inline void multiply(const FarMatrix& matrix, int first_row, int rows, const Lanes* in, Lanes* out) {
    const FarTerm* term = matrix.terms + matrix.first[first_row];
    for (int r = first_row; r < rows; ++r) {
        const FarTerm* end = matrix.terms + matrix.first[r + 1];
        Lanes sum = kZeros;
        for (; term < end; ++term) sum += term->value * in[term->from];
        out[r] = sum;
    }
}

// Turns f [36] of the model frame into the local frames, in place.
inline void toLocal(const FarConstants& constants, Frames& frames, Lanes* f) {
    if (!frames.turned) makeTurns(frames);
    Lanes turned[kFull];
    turn(frames.cos_c, frames.sin_c, f);
    turned[0] = f[0];
    multiply(constants.turn, 1, kFull, f, turned);
    turn(frames.cos_b, frames.sin_b, turned);
    multiply(constants.turn_back, 1, kFull, turned, f);
    turn(frames.cos_a, frames.sin_a, f);
}

inline void product(const FarProduct& table, const Lanes* a, const Lanes* b, Lanes* out) {
    Lanes pair[kMostPairs];
    for (std::size_t n = 0; n < table.pairs; ++n) {
        const int j = table.j[n], k = table.k[n];
        pair[n] = a[j] * b[k];
        if (j != k) pair[n] += a[k] * b[j];
    }
    const FarTerm* term = table.rows.terms;
    for (int i = 0; i < table.size_out; ++i) {
        const FarTerm* end = table.rows.terms + table.rows.first[i + 1];
        Lanes s0 = kZeros, s1 = s0, s2 = s0, s3 = s0;
        for (; term < end; term += 4) {
            s0 += term[0].value * pair[term[0].from];
            s1 += term[1].value * pair[term[1].from];
            s2 += term[2].value * pair[term[2].from];
            s3 += term[3].value * pair[term[3].from];
        }
        out[i] = (s0 + s1) + (s2 + s3);
    }
}

// Eight points of a level around each receiver.
struct Level {
    Lanes share, part[3];
    Ints first;
    std::int32_t stride[3];
};

inline void boxLevel(const FarBox& box, const Lanes* p, Level& out) {
    out.first = (Ints)kZeros + box.first;
    Lanes depth = (kZeros + 1e30f);
    for (int axis = 0; axis < 3; ++axis) {
        const Lanes above = p[axis] - box.low[axis], below = box.high[axis] - p[axis];
        least(above, depth, depth);
        least(below, depth, depth);
        Lanes t = above * box.per_cell[axis], cell;
        clamp(t, kZeros, (kZeros + box.cells[axis]));
        least(t, (kZeros + box.cells[axis] - 1), cell);
        const Ints whole = __builtin_convertvector(cell, Ints);
        out.part[axis] = t - __builtin_convertvector(whole, Lanes);
        out.first += whole * box.stride[axis];
        out.stride[axis] = box.stride[axis];
    }
    out.share = depth * box.per_width;
    clamp(out.share, kZeros, (kZeros + 1));
}

inline void sphereLevel(const FarConstants& constants, const FarTable& table, const Lanes* offset, const Lanes& square,
                        Level& out) {
    constexpr std::int32_t kSide = 13;
    Lanes distance = square, u;
    root(distance);
    choose(distance > 0, table.radius / distance, (kZeros + 1), u);
    clamp(u, (kZeros + constants.sphere_scales[0]), (kZeros + constants.sphere_scales[kMostSpheres - 1]));
    Lanes low = (kZeros + constants.sphere_scales[0]), high = (kZeros + constants.sphere_scales[1]);
    Ints sphere = (Ints)kZeros;
    for (int s = 1; s < kMostSpheres - 1; ++s) {
        const Ints beyond = u > constants.sphere_scales[s];
        sphere -= beyond;
        choose(beyond, (kZeros + constants.sphere_scales[s]), low, low);
        choose(beyond, (kZeros + constants.sphere_scales[s + 1]), high, high);
    }
    // The octahedral map.
    Lanes magnitude[3];
    for (int axis = 0; axis < 3; ++axis) choose(offset[axis] < 0, -offset[axis], offset[axis], magnitude[axis]);
    const Lanes sum = magnitude[0] + magnitude[1] + magnitude[2];
    Lanes map[2];
    for (int axis = 0; axis < 2; ++axis) {
        Lanes there, sign;
        choose(offset[axis] >= 0, (kZeros + 1), (kZeros + -1), sign);
        choose(offset[2] >= 0, offset[axis] / sum, (1 - magnitude[1 - axis] / sum) * sign, there);
        choose(sum > 0, there, kZeros, map[axis]);
    }
    out.first = table.first_sphere + sphere * (kSide * kSide);
    const std::int32_t stride[3] = {kSide, 1, kSide * kSide};
    for (int axis = 0; axis < 3; ++axis) out.stride[axis] = stride[axis];
    for (int axis = 0; axis < 2; ++axis) {
        Lanes t = (map[axis] + 1) * (0.5f * (kSide - 1)), cell;
        clamp(t, kZeros, (kZeros + kSide - 1));
        least(t, (kZeros + kSide - 2), cell);
        const Ints whole = __builtin_convertvector(cell, Ints);
        out.part[axis] = t - __builtin_convertvector(whole, Lanes);
        out.first += whole * stride[axis];
    }
    out.part[2] = (u - low) / (high - low);
}

// Adds the share of a level to the row of one receiver.
inline void addLevel(const FarTable& table, int level, const Level& at, std::size_t lane, Lanes* row) {
    const float x = at.part[0][lane], y = at.part[1][lane], z = at.part[2][lane], share = at.share[lane];
    const std::int8_t* first = table.points + std::int64_t(at.first[lane]) * kRow;
    const float weight[8] = {(1 - x) * (1 - y) * (1 - z), x * (1 - y) * (1 - z), (1 - x) * y * (1 - z), x * y * (1 - z),
                             (1 - x) * (1 - y) * z,       x * (1 - y) * z,       (1 - x) * y * z,       x * y * z};
    Lanes sum[5] = {};
    for (int c = 0; c < 8; ++c) {
        const std::int64_t point = (c & 1 ? std::int64_t(at.stride[0]) : 0) + (c & 2 ? std::int64_t(at.stride[1]) : 0) +
                                   (c & 4 ? std::int64_t(at.stride[2]) : 0);
        const std::int8_t* bytes = first + point * kRow;
        for (int i = 0; i < 5; ++i) {
            Lanes value;
            loadBytes(bytes + 8 * i, value);
            sum[i] += weight[c] * value;
        }
    }
    for (int i = 0; i < 5; ++i) {
        Lanes scale;
        loadFloats(table.scale[level] + 8 * i, scale);
        row[i] += share * (scale * sum[i]);
    }
}

// Writes V - 1 of a part in its rest frame, for the receivers that are wanted, and 0 for others: out [40]. `inside`
// tells how dark it is inside the part, as sampleField() has it.
inline void sample(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                   const Ints& wanted, Lanes* out, Lanes& inside) {
    Lanes point[3], offset[3];
    const Lanes* p = frames.position;
    for (int axis = 0; axis < 3; ++axis) {
        const float* m = posed.to_part + 4 * axis;
        point[axis] = m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
        offset[axis] = point[axis] - table.centre[axis];
    }
    const Lanes square = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
    Level levels[3];
    boxLevel(table.boxes[0], point, levels[0]);
    boxLevel(table.boxes[1], point, levels[1]);
    levels[1].share *= 1 - levels[0].share;
    levels[2].share = 1 - levels[0].share - levels[1].share;
    sphereLevel(constants, table, offset, square, levels[2]);
    Lanes rows[kFarLanes][5];
    for (std::size_t lane = 0; lane < kFarLanes; ++lane) {
        for (int i = 0; i < 5; ++i) rows[lane][i] = kZeros;
        if (!wanted[lane]) continue;
        for (int level = 0; level < 3; ++level)
            if (levels[level].share[lane] > 0) addLevel(table, level, levels[level], lane, rows[lane]);
    }
    for (std::size_t i = 0; i < 5; ++i) transpose((const float*)rows + 8 * i, kRow, out + 8 * i);
    const Lanes fine = levels[0].share;
    inside = out[kDistance] * -table.per_fade;
    clamp(inside, kZeros, fine);
    const Lanes scale = 1 / (square + 0.25f * table.radius * table.radius);
    for (int i = 0; i < kFull; ++i) out[i] *= scale;
}

// Tells how high a part stands over the horizon of each receiver, as farVisibility() has it, and which receivers its
// sphere covers too little of.
inline void heightOf(const FarPart& posed, const Frames& frames, Lanes& height, Ints& small) {
    Lanes way[3];
    for (int axis = 0; axis < 3; ++axis) way[axis] = posed.centre[axis] - frames.position[axis];
    const Lanes* n = frames.normal;
    height = (way[0] * n[0] + way[1] * n[1] + way[2] * n[2]) / posed.radius;
    clamp(height, kZeros - 1, kZeros + 1);
    const Lanes square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
    const float radius2 = posed.radius * posed.radius;
    small = (kZeros + radius2) < 4 * kLeastBlocked * (square - radius2);
}

// What a part blocks at the receivers that are wanted: V - 1 in its rest frame [40], its share of the sphere, and the
// weight by which it counts. Returns whether it counts anywhere.
inline bool blockedBy(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                      const Ints& wanted, Lanes* blocked, Lanes& share, Lanes& weight, Lanes& inside) {
    sample(constants, table, posed, frames, wanted, blocked, inside);
    share = blocked[0] * (-1 / kRootOfSphere);
    weight = (share - kLeastBlocked) * (1 / (kFullBlocked - kLeastBlocked));
    clamp(weight, kZeros, kZeros + 1);
    return any((weight > 0) | (inside > 0));
}

// Adds block times f of one band to `out`.
template <int L>
inline void turnBand(const float* block, const Lanes* f, Lanes* out) {
    constexpr int kSize = 2 * L + 1;
    Lanes sum[kSize];
    for (int i = 0; i < kSize; ++i) sum[i] = block[i * kSize] * f[0];
    for (int j = 1; j < kSize; ++j)
        for (int i = 0; i < kSize; ++i) sum[i] += block[i * kSize + j] * f[j];
    for (int i = 0; i < kSize; ++i) out[i] = sum[i];
}

// Turns f into the model frame.
inline void toModel(const float* blocks, const Lanes* f, Lanes* out) {
    out[0] = f[0];
    turnBand<1>(blocks + 1, f + 1, out + 1);
    turnBand<2>(blocks + 10, f + 4, out + 4);
    turnBand<3>(blocks + 35, f + 9, out + 9);
    turnBand<4>(blocks + 84, f + 16, out + 16);
    turnBand<5>(blocks + 165, f + 25, out + 25);
}

// What a block of 8 receivers has seen so far.
struct Seen {
    Frames frames;
    Lanes near[kEven];  // product of the parts that block much
    // Sums of V - 1 of the others in the model frame: what is to be mirrored by its bands, and what by its height.
    Lanes rest[2][kFull];
    Lanes light;  // what being inside of parts leaves, 1 outside of all
    bool has_near, has_rest;
};

// Adds `weight` times the part to the sums. mirrorPart() has the rule: what is surely above the horizon is doubled.
inline void addToRest(const Lanes& weight, const Lanes& height, const Lanes* model, Seen& seen) {
    const Lanes sure = height * height, by_bands = weight * (1 - sure);
    Lanes by_height;
    choose(height > 0, 2 * weight * sure, kZeros, by_height);
    for (int i = 0; i < kFull; ++i) {
        seen.rest[0][i] += by_bands * model[i];
        seen.rest[1][i] += by_height * model[i];
    }
    seen.has_rest = true;
}

// Multiplies by 1 + `weight` times the part.
inline void addToProduct(const FarConstants& constants, const Lanes& weight, const Lanes& height, Lanes* model,
                         Seen& seen) {
    Lanes local[kEven], out[kEven], by_height;
    toLocal(constants, seen.frames, model);
    multiply(constants.mirror, 0, kEven, model, local);
    const Lanes sure = height * height, by_bands = weight * (1 - sure);
    choose(height > 0, 2 * weight * sure, kZeros, by_height);
    for (int l = 0, i = 0; l < kOrder; ++l)
        for (int m = 0; m <= l; ++m, ++i) local[i] = by_bands * local[i] + by_height * model[l * l + 2 * m];
    local[0] += kRootOfSphere;
    if (seen.has_near) product(constants.product, seen.near, local, out);
    for (int i = 0; i < kEven; ++i) seen.near[i] = seen.has_near ? out[i] : local[i];
    seen.has_near = true;
}

// How near a part is by the share that it blocks.
inline void nearOf(const FarConstants& constants, const Lanes& share, Lanes& near) {
    near = (share - constants.near[0]) * (1 / (constants.near[1] - constants.near[0]));
    clamp(near, kZeros, kZeros + 1);
}

// Adds a part to receivers that have no anchors.
inline void addPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, Seen& seen) {
    Lanes height, blocked[kRow], model[kFull], share, weight, near, inside;
    Ints small;
    heightOf(posed, seen.frames, height, small);
    const Ints wanted = (height > -1) & ~small;
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked, share, weight, inside)) return;
    seen.light *= 1 - inside;
    toModel(posed.to_model, blocked, model);
    nearOf(constants, share, near);
    if (any(near < 1)) addToRest(weight * (1 - near), height, model, seen);
    near *= weight;
    if (any(near > 0)) addToProduct(constants, near, height, model, seen);
}

// Adds a part to receivers whose anchors say how near it is.
inline void addNearPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Lanes& near,
                        Seen& seen) {
    Lanes height, blocked[kRow], model[kFull], share, weight, inside;
    Ints small;
    heightOf(posed, seen.frames, height, small);
    const Ints wanted = (height > -1) & ~small & (near > 0);
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked, share, weight, inside)) return;
    seen.light *= 1 - inside * near;
    toModel(posed.to_model, blocked, model);
    addToProduct(constants, near * weight, height, model, seen);
}

// exp(f) = exp(c) (1 + g/2 + g^2/8)^2, where c is the constant part of f and g is the rest of it.
inline void exponential(const FarConstants& constants, const Lanes* f, Lanes* out) {
    Lanes g[kEven], square[kEven], scale;
    for (std::size_t lane = 0; lane < kFarLanes; ++lane) scale[lane] = __builtin_expf(f[0][lane] * (1 / kRootOfSphere));
    for (int i = 0; i < kEven; ++i) g[i] = 0.5f * f[i];
    g[0] = kZeros;
    product(constants.product, g, g, square);
    for (int i = 0; i < kEven; ++i) g[i] += 0.5f * square[i];
    g[0] += kRootOfSphere;
    product(constants.product, g, g, out);
    for (int i = 0; i < kEven; ++i) out[i] *= scale;
}

inline void finish(const FarConstants& constants, Seen& seen, Lanes* out) {
    if (!seen.has_rest) {
        for (int i = 0; i < kEven; ++i) out[i] = seen.has_near ? seen.light * seen.near[i] : kZeros;
        if (!seen.has_near) out[0] = seen.light * kRootOfSphere;
        return;
    }
    Lanes local[kEven], rest[kEven];
    toLocal(constants, seen.frames, seen.rest[0]);
    toLocal(constants, seen.frames, seen.rest[1]);
    multiply(constants.mirror, 0, kEven, seen.rest[0], local);
    for (int l = 0, i = 0; l < kOrder; ++l)
        for (int m = 0; m <= l; ++m, ++i) local[i] += seen.rest[1][l * l + 2 * m];
    exponential(constants, local, seen.has_near ? rest : out);
    if (seen.has_near) product(constants.product, seen.near, rest, out);
    for (int i = 0; i < kEven; ++i) out[i] *= seen.light;
}

inline void begin(const FarReceivers& receivers, std::size_t first, Seen& seen) {
    gatherFrames(receivers, first, seen.frames);
    seen.has_near = seen.has_rest = false;
    seen.light = kZeros + 1;
    for (int i = 0; i < kFull; ++i) seen.rest[0][i] = seen.rest[1][i] = kZeros;
}

// Writes the sums, and how near each part is. That does not depend on the horizon, which is another one at each
// receiver around.
inline void anchorLanes(const FarConstants& constants, const FarScene& scene, const FarReceivers& receivers,
                        float* values) {
    const std::size_t stride = anchorStride(scene.part_count);
    for (std::size_t first = 0; first < receivers.count; first += kFarLanes) {
        Seen seen;
        begin(receivers, first, seen);
        Lanes nears[kMostAnchorParts];
        for (std::size_t p = 0; p < scene.part_count; ++p) {
            const FarPart& posed = scene.posed[scene.parts[p]];
            Lanes height, blocked[kRow], model[kFull], share, weight, inside;
            Ints small;
            nears[p] = kZeros;
            heightOf(posed, seen.frames, height, small);
            if (!any(~small)) continue;
            if (!blockedBy(constants, scene.tables[scene.parts[p]], posed, seen.frames, ~small, blocked, share, weight,
                           inside))
                continue;
            nearOf(constants, share, nears[p]);
            const Lanes rest = weight * (1 - nears[p]);
            if (!any((rest > 0) & (height > -1))) continue;
            toModel(posed.to_model, blocked, model);
            addToRest(rest, height, model, seen);
        }
        for (std::size_t lane = 0; lane < kFarLanes && first + lane < receivers.count; ++lane) {
            float* out = values + (first + lane) * stride;
            for (int i = 0; i < kFull; ++i) {
                out[i] = seen.rest[0][i][lane];
                out[kFull + i] = seen.rest[1][i][lane];
            }
            for (std::size_t p = 0; p < scene.part_count; ++p) out[kAnchorSums + p] = nears[p][lane];
        }
    }
}

// Takes the sums of a block, and how near each part is, from its anchors.
inline void interpolate(const FarAnchors& anchors, const FarReceivers& receivers, std::size_t first, Seen& seen,
                        Lanes* nears) {
    constexpr std::size_t kMostColumns = anchorStride(kMostAnchorParts) / 8;
    const std::size_t columns = anchors.stride / 8;
    Lanes rows[kFarLanes][kMostColumns];
    for (std::size_t lane = 0; lane < kFarLanes; ++lane) {
        const std::size_t r = first + lane < receivers.count ? first + lane : receivers.count - 1;
        const std::uint16_t* anchor = anchors.anchor + r * kAnchorsOfReceiver;
        const float* weight = anchors.weight + r * kAnchorsOfReceiver;
        const float* from[kAnchorsOfReceiver];
        for (std::size_t a = 0; a < kAnchorsOfReceiver; ++a) from[a] = anchors.values + anchor[a] * anchors.stride;
        for (std::size_t i = 0; i < columns; ++i) {
            Lanes value;
            loadFloats(from[0] + 8 * i, value);
            Lanes sum = weight[0] * value;
            for (std::size_t a = 1; a < kAnchorsOfReceiver; ++a) {
                loadFloats(from[a] + 8 * i, value);
                sum += weight[a] * value;
            }
            rows[lane][i] = sum;
        }
    }
    const float* numbers = (const float*)rows;
    Lanes sums[kAnchorSums];
    for (std::size_t i = 0; i < kAnchorSums / 8; ++i) transpose(numbers + 8 * i, 8 * kMostColumns, sums + 8 * i);
    for (std::size_t i = kAnchorSums / 8; i < columns; ++i)
        transpose(numbers + 8 * i, 8 * kMostColumns, nears + 8 * i - kAnchorSums);
    for (int i = 0; i < kFull; ++i) {
        seen.rest[0][i] = sums[i];
        seen.rest[1][i] = sums[kFull + i];
    }
    seen.has_rest = any((sums[0] < 0) | (sums[kFull] < 0));  // sums of V - 1
}

inline void farLanes(const FarConstants& constants, const FarScene& scene, const FarAnchors& anchors,
                     const FarReceivers& receivers, float* far) {
    constexpr std::size_t kMostBlocks = kMostReceivers / kFarLanes;
    Seen seen[kMostBlocks];
    Lanes nears[kMostBlocks][kMostAnchorParts];
    const std::size_t blocks = (receivers.count + kFarLanes - 1) / kFarLanes;
    for (std::size_t b = 0; b < blocks; ++b) {
        begin(receivers, b * kFarLanes, seen[b]);
        if (anchors.values) interpolate(anchors, receivers, b * kFarLanes, seen[b], nears[b]);
    }
    for (std::size_t p = 0; p < scene.part_count; ++p)
        for (std::size_t b = 0; b < blocks; ++b) {
            const FarTable& table = scene.tables[scene.parts[p]];
            const FarPart& posed = scene.posed[scene.parts[p]];
            if (!anchors.values)
                addPart(constants, table, posed, seen[b]);
            else if (any(nears[b][p] > 0))
                addNearPart(constants, table, posed, nears[b][p], seen[b]);
        }
    for (std::size_t b = 0; b < blocks; ++b) {
        Lanes out[kEven];
        finish(constants, seen[b], out);
        for (std::size_t lane = 0; lane < kFarLanes && b * kFarLanes + lane < receivers.count; ++lane)
            for (int i = 0; i < kEven; ++i) far[(b * kFarLanes + lane) * kEven + std::size_t(i)] = out[i][lane];
    }
}

inline void composeLanes(const FarProduct& table, const float* far, const float* mean, std::size_t vertices,
                         std::size_t stride, float* numbers) {
    for (std::size_t first = 0; first < vertices; first += kFarLanes) {
        const std::size_t lanes = vertices - first < kFarLanes ? vertices - first : kFarLanes;
        Lanes a[kMostEven] = {}, b[kMostEven] = {}, out[kMostEven];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t v = first + lane;
            for (int i = 0; i < table.size_out; ++i) a[i][lane] = numbers[v * stride + std::size_t(i)];
            for (int i = 0; i < kEven; ++i) b[i][lane] = far[v * kEven + std::size_t(i)];
        }
        product(table, a, b, out);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            float* row = numbers + (first + lane) * stride;
            for (int i = 0; i < table.size_out; ++i)
                row[i] = out[i][lane] + (mean ? mean[(first + lane) * stride + std::size_t(i)] : 0);
        }
    }
}

}  // namespace

}  // namespace penumbra
