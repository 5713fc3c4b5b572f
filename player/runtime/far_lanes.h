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
// - Products are taken at 64 directions above the horizon. There and back take a third of what the product of SH
//   coefficients takes, and several products in a row, and the exponential, need no way back in between.
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
#ifdef __AVX2__
    out = (Lanes)_mm256_blendv_ps((__m256)no, (__m256)yes, (__m256)mask);
#else
    out = (Lanes)((mask & (Ints)yes) | (~mask & (Ints)no));
#endif
}
// The smaller and the larger of the two; b where a is not a number.
inline void least(const Lanes& a, const Lanes& b, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_min_ps((__m256)a, (__m256)b);
#else
    choose(a < b, a, b, out);
#endif
}
inline void most(const Lanes& a, const Lanes& b, Lanes& out) {
#ifdef __AVX2__
    out = (Lanes)_mm256_max_ps((__m256)a, (__m256)b);
#else
    choose(a > b, a, b, out);
#endif
}
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

// Lists numbers 0..n-1 as template arguments, so that a loop over them unrolls and its indices are constants.
template <int... I>
struct Numbers {};
template <int N, int... I>
struct Count : Count<N - 1, N - 1, I...> {};
template <int... I>
struct Count<0, I...> {
    using List = Numbers<I...>;
};
template <int N>
using Upto = typename Count<N>::List;

// Sets f to R(Z(angle)) f.
template <int L, int... M>
inline void turnBandAboutZ(const Lanes* cosine, const Lanes* sine, Lanes* f, Numbers<M...>) {
    const auto turnPair = [&](int m) __attribute__((always_inline)) {
        Lanes &plus = f[L * L + L + m], &minus = f[L * L + L - m];
        const Lanes turned = cosine[m] * plus - sine[m] * minus;
        minus = cosine[m] * minus + sine[m] * plus;
        plus = turned;
    };
    (turnPair(M + 1), ...);
}
inline void turn(const Lanes* cosine, const Lanes* sine, Lanes* f) {
    turnBandAboutZ<1>(cosine, sine, f, Upto<1>());
    turnBandAboutZ<2>(cosine, sine, f, Upto<2>());
    turnBandAboutZ<3>(cosine, sine, f, Upto<3>());
    turnBandAboutZ<4>(cosine, sine, f, Upto<4>());
    turnBandAboutZ<5>(cosine, sine, f, Upto<5>());
}

// Tells whether R(X(90)) takes coefficient (l, from) to (l, to). It keeps what is odd in x odd in x, and turns what is
// odd in z into what is odd in y, and the other way round. y_lm is odd in y for m < 0, odd in z for odd l + m.
constexpr bool oddInY(int m) { return m < 0; }
constexpr bool oddInZ(int l, int m) { return (l + m) % 2 != 0; }
constexpr bool oddInX(int m) { return (m % 2 != 0) != (m < 0); }
constexpr bool turnsInto(int l, int from, int to) {
    return oddInX(from) == oddInX(to) && oddInZ(l, from) == oddInY(to) && oddInY(from) == oddInZ(l, to);
}

// Computes a row of R(X(90)) f, or of its transpose, for a band; `block` is that of R(X(90)).
template <int L, int To, bool kBack, int... I>
inline void quarterTurnRow(const float* block, const Lanes* f, Lanes& out, Numbers<I...>) {
    constexpr int kSize = 2 * L + 1;
    Lanes sum = kZeros;
    const auto add = [&]<int From>(Numbers<From>) __attribute__((always_inline)) {
        if constexpr (kBack ? turnsInto(L, To - L, From - L) : turnsInto(L, From - L, To - L))
            sum += block[kBack ? From * kSize + To : To * kSize + From] * f[From];
    };
    (add(Numbers<I>()), ...);
    out = sum;
}
template <int L, bool kBack, int... To>
inline void quarterTurnBand(const float* block, const Lanes* f, Lanes* out, Numbers<To...>) {
    (quarterTurnRow<L, To, kBack>(block, f, out[To], Upto<2 * L + 1>()), ...);
}
template <bool kBack>
inline void quarterTurn(const float* blocks, const Lanes* f, Lanes* out) {
    out[0] = f[0];
    quarterTurnBand<1, kBack>(blocks + 1, f + 1, out + 1, Upto<3>());
    quarterTurnBand<2, kBack>(blocks + 10, f + 4, out + 4, Upto<5>());
    quarterTurnBand<3, kBack>(blocks + 35, f + 9, out + 9, Upto<7>());
    quarterTurnBand<4, kBack>(blocks + 84, f + 16, out + 16, Upto<9>());
    quarterTurnBand<5, kBack>(blocks + 165, f + 25, out + 25, Upto<11>());
}

// Turns f [36] of the model frame into the local frames, in place.
inline void toLocal(const FarConstants& constants, Frames& frames, Lanes* f) {
    if (!frames.turned) makeTurns(frames);
    Lanes turned[kFull];
    turn(frames.cos_c, frames.sin_c, f);
    quarterTurn<false>(constants.quarter_turn, f, turned);
    turn(frames.cos_b, frames.sin_b, turned);
    quarterTurn<true>(constants.quarter_turn, turned, f);
    turn(frames.cos_a, frames.sin_a, f);
}

constexpr int evenPlace(int l, int m) { return l * (l + 1) / 2 + (m + l) / 2; }  // of (l, m) with even l + m

// Mirrors at the horizon: the even coefficients stay, and odd ones of the same m come in. `by_bands` is the weight of
// this, `by_height` that of the even coefficients alone.
template <int M>
inline void mirrorOrder(const float (*mirror)[kOrder], const Lanes* f, const Lanes& by_bands, const Lanes& by_height,
                        Lanes* out) {
    constexpr int kFirst = M < 0 ? -M : M;
    for (int l = kFirst; l < kOrder; l += 2) {
        const int e = evenPlace(l, M);
        Lanes sum = f[l * l + l + M];
        const Lanes alone = by_height * sum;
        for (int odd = kFirst + 1; odd < kOrder; odd += 2) sum += mirror[e][odd] * f[odd * odd + odd + M];
        out[e] = by_bands * sum + alone;
    }
}
template <int... I>
inline void mirror(const FarConstants& constants, const Lanes* f, const Lanes& by_bands, const Lanes& by_height,
                   Lanes* out, Numbers<I...>) {
    (mirrorOrder<I - kOrder + 1>(constants.mirror, f, by_bands, by_height, out), ...);
}

inline void product(const FarProduct& table, const Lanes* a, const Lanes* b, Lanes* out) {
    Lanes pair[kMostPairs];
    for (std::size_t n = 0; n < table.pairs; ++n) {
        const int j = table.j[n], k = table.k[n];
        pair[n] = a[j] * b[k];
        if (j != k) pair[n] += a[k] * b[j];
    }
    for (int i = 0; i < table.size_out; ++i) {
        Lanes sum = kZeros;
        for (const FarTerm* term = table.rows.terms + table.rows.first[i];
             term < table.rows.terms + table.rows.first[i + 1]; ++term)
            sum += term->value * pair[term->from];
        out[i] = sum;
    }
}

constexpr int kRings = 4, kAround = 16, kDirections = kRings * kAround;
// cos(pi n / 8) and sin(pi n / 8).
constexpr float kCos1 = 0.92387953f, kCos2 = 0.70710678f, kCos3 = 0.38268343f;

// Sums ring times f over the bands of order m.
template <int kN, int M>
inline void sumBands(const float* ring, const Lanes* f, Lanes& out) {
    constexpr int kFirst = M < 0 ? -M : M;
    if constexpr (kFirst >= kN) {
        out = kZeros;
    } else {
        out = ring[evenPlace(kFirst, M)] * f[evenPlace(kFirst, M)];
        if constexpr (kFirst + 2 < kN) out += ring[evenPlace(kFirst + 2, M)] * f[evenPlace(kFirst + 2, M)];
        if constexpr (kFirst + 4 < kN) out += ring[evenPlace(kFirst + 4, M)] * f[evenPlace(kFirst + 4, M)];
    }
}
// Adds ring times x to the bands of order m of f, or begins them.
template <int kN, int M>
inline void addToBands(const float* ring, const Lanes& x, bool begins, Lanes* f) {
    constexpr int kFirst = M < 0 ? -M : M;
    const auto add = [&](int l) __attribute__((always_inline)) {
        const int i = evenPlace(l, M);
        f[i] = begins ? ring[i] * x : f[i] + ring[i] * x;
    };
    if constexpr (kFirst < kN) add(kFirst);
    if constexpr (kFirst + 2 < kN) add(kFirst + 2);
    if constexpr (kFirst + 4 < kN) add(kFirst + 4);
}

// Writes the values of f [count of order kN] at the directions. Around a ring f is sum of c_m cos(m phi) + s_m sin(m
// phi), phi = pi q / 8. Even and odd m repeat or turn over after half a round, so that half of each is computed.
template <int kN>
inline void toGrid(const FarGrid& grid, const Lanes* f, Lanes* values) {
    for (int k = 0; k < kRings; ++k, values += kAround) {
        const float* ring = grid.ring[k];
        Lanes c[kOrder], s[kOrder];
        sumBands<kN, 0>(ring, f, c[0]);
        sumBands<kN, 1>(ring, f, c[1]);
        sumBands<kN, 2>(ring, f, c[2]);
        sumBands<kN, 3>(ring, f, c[3]);
        sumBands<kN, 4>(ring, f, c[4]);
        sumBands<kN, 5>(ring, f, c[5]);
        sumBands<kN, -1>(ring, f, s[1]);
        sumBands<kN, -2>(ring, f, s[2]);
        sumBands<kN, -3>(ring, f, s[3]);
        sumBands<kN, -4>(ring, f, s[4]);
        sumBands<kN, -5>(ring, f, s[5]);
        // 1. Even m: 4 values that repeat, and 4 that turn over.
        const Lanes same[4] = {c[0] + c[4], c[0] + s[4], c[0] - c[4], c[0] - s[4]};
        const Lanes over[4] = {c[2], kCos2 * (c[2] + s[2]), s[2], kCos2 * (s[2] - c[2])};
        Lanes even[8], odd[8];
        for (int q = 0; q < 4; ++q) {
            even[q] = same[q] + over[q];
            even[q + 4] = same[q] - over[q];
        }
        // 2. Odd m: cosines are odd about a quarter of a round, sines are even.
        const Lanes cosine[4] = {c[1] + c[3] + c[5], kCos1 * c[1] + kCos3 * c[3] - kCos3 * c[5],
                                 kCos2 * (c[1] - c[3] - c[5]), kCos3 * c[1] - kCos1 * c[3] + kCos1 * c[5]};
        const Lanes sine[5] = {kZeros, kCos3 * s[1] + kCos1 * s[3] + kCos1 * s[5], kCos2 * (s[1] + s[3] - s[5]),
                               kCos1 * s[1] - kCos3 * s[3] - kCos3 * s[5], s[1] - s[3] + s[5]};
        odd[0] = cosine[0];
        odd[4] = sine[4];
        for (int q = 1; q < 4; ++q) {
            odd[q] = sine[q] + cosine[q];
            odd[8 - q] = sine[q] - cosine[q];
        }
        for (int q = 0; q < 8; ++q) {
            values[q] = even[q] + odd[q];
            values[q + 8] = even[q] - odd[q];
        }
    }
}

// The transpose of toGrid(), with the weights of the directions: f_i = integral of the values times y_i.
template <int kN>
inline void fromGrid(const FarGrid& grid, const Lanes* values, Lanes* f) {
    for (int k = 0; k < kRings; ++k, values += kAround) {
        const float* ring = grid.ring_back[k];
        Lanes even[8], odd[8], same[4], over[4], c[kOrder], s[kOrder];
        for (int q = 0; q < 8; ++q) {
            even[q] = values[q] + values[q + 8];
            odd[q] = values[q] - values[q + 8];
        }
        for (int q = 0; q < 4; ++q) {
            same[q] = even[q] + even[q + 4];
            over[q] = even[q] - even[q + 4];
        }
        c[0] = (same[0] + same[2]) + (same[1] + same[3]);
        c[4] = same[0] - same[2];
        s[4] = same[1] - same[3];
        c[2] = over[0] + kCos2 * (over[1] - over[3]);
        s[2] = over[2] + kCos2 * (over[1] + over[3]);
        Lanes cosine[4], sine[4];
        for (int q = 1; q < 4; ++q) {
            cosine[q] = odd[q] - odd[8 - q];
            sine[q] = odd[q] + odd[8 - q];
        }
        const Lanes c2 = kCos2 * cosine[2], s2 = kCos2 * sine[2];
        c[1] = odd[0] + kCos1 * cosine[1] + c2 + kCos3 * cosine[3];
        c[3] = odd[0] + kCos3 * cosine[1] - c2 - kCos1 * cosine[3];
        c[5] = odd[0] - kCos3 * cosine[1] - c2 + kCos1 * cosine[3];
        s[1] = odd[4] + kCos3 * sine[1] + s2 + kCos1 * sine[3];
        s[3] = kCos1 * sine[1] + s2 - kCos3 * sine[3] - odd[4];
        s[5] = kCos1 * sine[1] - s2 - kCos3 * sine[3] + odd[4];
        const bool begins = k == 0;
        addToBands<kN, 0>(ring, c[0], begins, f);
        addToBands<kN, 1>(ring, c[1], begins, f);
        addToBands<kN, 2>(ring, c[2], begins, f);
        addToBands<kN, 3>(ring, c[3], begins, f);
        addToBands<kN, 4>(ring, c[4], begins, f);
        addToBands<kN, 5>(ring, c[5], begins, f);
        addToBands<kN, -1>(ring, s[1], begins, f);
        addToBands<kN, -2>(ring, s[2], begins, f);
        addToBands<kN, -3>(ring, s[3], begins, f);
        addToBands<kN, -4>(ring, s[4], begins, f);
        addToBands<kN, -5>(ring, s[5], begins, f);
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
    const std::int64_t dx = at.stride[0] * kRow, dy = at.stride[1] * kRow, dz = at.stride[2] * std::int64_t(kRow);
    const std::int8_t* const corner[8] = {first,      first + dx,      first + dy,      first + dx + dy,
                                          first + dz, first + dx + dz, first + dy + dz, first + dx + dy + dz};
    Lanes s0, s1, s2, s3, s4;
    const auto add = [&](int c, bool begins) __attribute__((always_inline)) {
        Lanes v0, v1, v2, v3, v4;
        loadBytes(corner[c], v0);
        loadBytes(corner[c] + 8, v1);
        loadBytes(corner[c] + 16, v2);
        loadBytes(corner[c] + 24, v3);
        loadBytes(corner[c] + 32, v4);
        const float w = weight[c];
        s0 = begins ? w * v0 : s0 + w * v0;
        s1 = begins ? w * v1 : s1 + w * v1;
        s2 = begins ? w * v2 : s2 + w * v2;
        s3 = begins ? w * v3 : s3 + w * v3;
        s4 = begins ? w * v4 : s4 + w * v4;
    };
    add(0, true);
    add(1, false);
    add(2, false);
    add(3, false);
    add(4, false);
    add(5, false);
    add(6, false);
    add(7, false);
    const Lanes sum[5] = {s0, s1, s2, s3, s4};
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
    Level levels[3] = {};
    boxLevel(table.boxes[0], point, levels[0]);
    boxLevel(table.boxes[1], point, levels[1]);
    levels[1].share *= 1 - levels[0].share;
    levels[2].share = 1 - levels[0].share - levels[1].share;
    if (any(levels[2].share > 0)) sphereLevel(constants, table, offset, square, levels[2]);
    // The corners of all receivers are on their way while the first of them are read.
    for (std::size_t lane = 0; lane < kFarLanes; ++lane)
        for (int level = 0; level < 3; ++level) {
            if (!wanted[lane] || !(levels[level].share[lane] > 0)) continue;
            const std::int8_t* first = table.points + std::int64_t(levels[level].first[lane]) * kRow;
            const std::int64_t dy = levels[level].stride[1] * kRow, dz = levels[level].stride[2] * std::int64_t(kRow);
            __builtin_prefetch(first);
            __builtin_prefetch(first + dy);
            __builtin_prefetch(first + dz);
            __builtin_prefetch(first + dy + dz);
        }
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

// What a part blocks at the receivers that are wanted.
struct Blocked {
    Lanes numbers[kRow];  // V - 1 in its rest frame
    Lanes share;          // of the sphere
    Lanes weight;         // by which it counts
    Lanes inside;         // how dark it is inside of it
};

// Returns whether the part counts anywhere.
inline bool blockedBy(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Frames& frames,
                      const Ints& wanted, Blocked& out) {
    sample(constants, table, posed, frames, wanted, out.numbers, out.inside);
    out.share = out.numbers[0] * (-1 / kRootOfSphere);
    out.weight = (out.share - kLeastBlocked) * (1 / (kFullBlocked - kLeastBlocked));
    clamp(out.weight, kZeros, kZeros + 1);
    return any((out.weight > 0) | (out.inside > 0));
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
    Lanes near[kDirections];  // product of the parts that block much
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
    Lanes local[kEven], values[kDirections], by_height;
    toLocal(constants, seen.frames, model);
    const Lanes sure = height * height, by_bands = weight * (1 - sure);
    choose(height > 0, 2 * weight * sure, kZeros, by_height);
    mirror(constants, model, by_bands, by_height, local, Upto<2 * kOrder - 1>());
    local[0] += kRootOfSphere;
    toGrid<kOrder>(constants.grid, local, values);
    for (int d = 0; d < kDirections; ++d) seen.near[d] = seen.has_near ? seen.near[d] * values[d] : values[d];
    seen.has_near = true;
}

// How near a part is by the share that it blocks.
inline void nearOf(const FarConstants& constants, const Lanes& share, Lanes& near) {
    near = (share - constants.near[0]) * (1 / (constants.near[1] - constants.near[0]));
    clamp(near, kZeros, kZeros + 1);
}

// Adds a part to receivers that have no anchors.
inline void addPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, Seen& seen) {
    Lanes height, model[kFull], near;
    Blocked blocked;
    Ints small;
    heightOf(posed, seen.frames, height, small);
    const Ints wanted = (height > -1) & ~small;
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked)) return;
    seen.light *= 1 - blocked.inside;
    toModel(posed.to_model, blocked.numbers, model);
    nearOf(constants, blocked.share, near);
    if (any(near < 1)) addToRest(blocked.weight * (1 - near), height, model, seen);
    near *= blocked.weight;
    if (any(near > 0)) addToProduct(constants, near, height, model, seen);
}

// Adds a part to receivers whose anchors say how near it is.
inline void addNearPart(const FarConstants& constants, const FarTable& table, const FarPart& posed, const Lanes& near,
                        Seen& seen) {
    Lanes height, model[kFull];
    Blocked blocked;
    Ints small;
    heightOf(posed, seen.frames, height, small);
    const Ints wanted = (height > -1) & ~small & (near > 0);
    if (!any(wanted)) return;
    if (!blockedBy(constants, table, posed, seen.frames, wanted, blocked)) return;
    seen.light *= 1 - blocked.inside * near;
    toModel(posed.to_model, blocked.numbers, model);
    addToProduct(constants, near * blocked.weight, height, model, seen);
}

// Sets x to exp(x) = exp(x / 8)^8, for x in [-6, 2].
inline void exponential(Lanes& x) {
    clamp(x, kZeros - 6, kZeros + 2);
    x *= 0.125f;
    x = 1 + x * (1 + x * (0.5f + x * (1.0f / 6 + x * (1.0f / 24))));
    x *= x;
    x *= x;
    x *= x;
}

inline void finish(const FarConstants& constants, Seen& seen, Lanes* out) {
    if (seen.has_rest) {
        Lanes local[kEven], values[kDirections];
        toLocal(constants, seen.frames, seen.rest[0]);
        toLocal(constants, seen.frames, seen.rest[1]);
        mirror(constants, seen.rest[0], kZeros + 1, kZeros, local, Upto<2 * kOrder - 1>());
        for (int l = 0, i = 0; l < kOrder; ++l)
            for (int m = 0; m <= l; ++m, ++i) local[i] += seen.rest[1][l * l + 2 * m];
        toGrid<kOrder>(constants.grid, local, values);
        for (int d = 0; d < kDirections; ++d) {
            exponential(values[d]);
            seen.near[d] = seen.has_near ? seen.near[d] * values[d] : values[d];
        }
    }
    if (seen.has_rest || seen.has_near) {
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
            Lanes height, model[kFull];
            Blocked blocked;
            Ints small;
            nears[p] = kZeros;
            heightOf(posed, seen.frames, height, small);
            if (!any(~small)) continue;
            if (!blockedBy(constants, scene.tables[scene.parts[p]], posed, seen.frames, ~small, blocked)) continue;
            nearOf(constants, blocked.share, nears[p]);
            const Lanes rest = blocked.weight * (1 - nears[p]);
            if (!any((rest > 0) & (height > -1))) continue;
            toModel(posed.to_model, blocked.numbers, model);
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

// Multiplies on the grid, which is exact up to order 6.
template <int kN>
inline void multiplyOnGrid(const FarConstants& constants, const Lanes* a, const Lanes* b, Lanes* out) {
    Lanes local[kDirections], far[kDirections];
    toGrid<kN>(constants.grid, a, local);
    toGrid<kOrder>(constants.grid, b, far);
    for (int d = 0; d < kDirections; ++d) far[d] *= local[d];
    fromGrid<kN>(constants.grid, far, out);
}

inline void composeLanes(const FarConstants& constants, const float* far, const float* mean, std::size_t vertices,
                         std::size_t stride, float* numbers) {
    const int size = constants.compose.size_out;
    for (std::size_t first = 0; first < vertices; first += kFarLanes) {
        const std::size_t lanes = vertices - first < kFarLanes ? vertices - first : kFarLanes;
        Lanes a[kMostEven] = {}, b[kMostEven] = {}, out[kMostEven];
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            const std::size_t v = first + lane;
            for (int i = 0; i < size; ++i) a[i][lane] = numbers[v * stride + std::size_t(i)];
            for (int i = 0; i < kEven; ++i) b[i][lane] = far[v * kEven + std::size_t(i)];
        }
        if (constants.order == 5)
            multiplyOnGrid<5>(constants, a, b, out);
        else if (constants.order <= kOrder)
            multiplyOnGrid<kOrder>(constants, a, b, out);
        else
            product(constants.compose, a, b, out);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            float* row = numbers + (first + lane) * stride;
            for (int i = 0; i < size; ++i)
                row[i] = out[i][lane] + (mean ? mean[(first + lane) * stride + std::size_t(i)] : 0);
        }
    }
}

}  // namespace

}  // namespace penumbra
