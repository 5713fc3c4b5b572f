#pragma once
// Turns SH functions from part to model to local frames, 8 at a time, and mirrors them at the horizon. Part of
// far_lanes.cpp.
#include <utility>

#include "sh/far/far_kernel.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

constexpr int kOrder = 6, kFull = 36, kEven = 21, kRow = 40, kDistance = 36;
constexpr int kMaxEven = 36;                          // numbers of a mirrored function of order kMaxOrder
constexpr int kPaddedEven = 24, kPaddedMaxEven = 40;  // whole vectors of them
constexpr float kRootOfSphere = 3.5449077f;           // sqrt(4 pi): the coefficient of the function 1

// Q = Z(a) Y(b) Z(c), by multiples of its angles.
struct Turns {
    Lanes cos_a[kOrder], sin_a[kOrder], cos_b[kOrder], sin_b[kOrder], cos_c[kOrder], sin_c[kOrder];
};
struct Frames {
    Lanes position[3], tangent[3], bitangent[3], normal[3];
};

inline void gatherFrames(const FarReceivers& receivers, std::size_t first, Frames& out) {
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
        const std::size_t r = first + lane < receivers.count ? first + lane : receivers.count - 1;
        setLane(out.position, lane, receivers.positions[r]);
        setLane(out.normal, lane, receivers.normals[r]);
        setLane(out.tangent, lane, receivers.tangents[r]);
    }
    const Lanes *n = out.normal, *t = out.tangent;
    out.bitangent[0] = n[1] * t[2] - n[2] * t[1];
    out.bitangent[1] = n[2] * t[0] - n[0] * t[2];
    out.bitangent[2] = n[0] * t[1] - n[1] * t[0];
}

inline void multiples(Lanes* cosine, Lanes* sine) {
    for (int m = 2; m < kOrder; ++m) {
        cosine[m] = cosine[m - 1] * cosine[1] - sine[m - 1] * sine[1];
        sine[m] = sine[m - 1] * cosine[1] + cosine[m - 1] * sine[1];
    }
}

// The turns of Q, whose rows are tangent, bitangent and normal, as makeTurns() of shade_lanes.cpp.
inline void makeTurns(const Lanes* tangent, const Lanes* bitangent, const Lanes& normal_z, Turns& q) {
    const Lanes x = tangent[2], y = bitangent[2], square = x * x + y * y;
    const Ints upright = square <= 1e-30f;  // any angle will do
    Lanes size;
    choose(upright, kZeros + 1, square, size);
    root(size);
    choose(upright, kZeros + 1, x / size, q.cos_a[1]);
    q.sin_a[1] = y / size;
    const Lanes cos_a = q.cos_a[1], sin_a = q.sin_a[1];
    q.cos_b[1] = normal_z;
    q.sin_b[1] = cos_a * x + sin_a * y;
    q.cos_c[1] = cos_a * bitangent[1] - sin_a * tangent[1];
    q.sin_c[1] = cos_a * bitangent[0] - sin_a * tangent[0];
    multiples(q.cos_a, q.sin_a);
    multiples(q.cos_b, q.sin_b);
    multiples(q.cos_c, q.sin_c);
}

// v in the frame that the matrix turns into v's.
inline void turnBack(const float* matrix, const Lanes* v, Lanes* out) {
    for (int i = 0; i < 3; ++i) out[i] = matrix[i] * v[0] + matrix[3 + i] * v[1] + matrix[6 + i] * v[2];
}
// The turns from the part's rest frame into the local frames.
inline void makeTurnsFromPart(const FarPart& posed, const Frames& frames, Turns& q) {
    Lanes tangent[3], bitangent[3], normal[3];
    turnBack(posed.turn, frames.tangent, tangent);
    turnBack(posed.turn, frames.bitangent, bitangent);
    turnBack(posed.turn, frames.normal, normal);
    makeTurns(tangent, bitangent, normal[2], q);
}

// Numbers 0..n-1 as template arguments, so that a loop over them unrolls and its indices are constants.
template <int... I>
using Numbers = std::integer_sequence<int, I...>;
template <int N>
using Upto = std::make_integer_sequence<int, N>;

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

// Turns f [36] into the local frames, in place.
inline void toLocal(const FarConstants& constants, const Turns& q, Lanes* f) {
    Lanes turned[kFull];
    turn(q.cos_c, q.sin_c, f);
    quarterTurn<false>(constants.quarter_turn, f, turned);
    turn(q.cos_b, q.sin_b, turned);
    quarterTurn<true>(constants.quarter_turn, turned, f);
    turn(q.cos_a, q.sin_a, f);
}

// Returns the index of (l, m) if only pairs with even l + m are stored.
constexpr int evenPlace(int l, int m) { return l * (l + 1) / 2 + (m + l) / 2; }

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

}  // namespace

}  // namespace penumbra
