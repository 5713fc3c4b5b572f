// Horizons of a height field and what lies above them, for 8 points at a time.
//
// Problem: a point looks along 20 azimuths at some 25 samples of a pyramid each, and every sample is bilinear. A field
// of 512 x 512 points has to be looked at 30 times a second.
//
// Naive: horizonTangents() and horizonVisibility() (tests/sh/horizon_reference.h), which this is held to.
//
// Here: points fill the lanes of vectors. All of them take the same tap at once, so that its level and its distance are
// constants. Slopes are compared, not angles, and the radial integrals are polynomials of the sine and cosine of the
// horizon and of its angle, so that an azimuth takes one root and one arc tangent.
#include "sh/height/height_kernel.h"
#include "sh/lanes.h"

namespace penumbra {

namespace {

// x - count floor(x / count), for x >= -many count.
inline void wrap(Lanes& x, float count) {
    Lanes rounds = x * (1 / count);
    roundDown(rounds);
    x -= count * rounds;
    // What rounding leaves outside.
    clamp(x, kZeros, kZeros + count);
}

// The points around a place of one axis of a level.
struct AroundLanes {
    Ints low, high;
    Lanes share;
};

template <bool Wraps>
inline void around(const Lanes& x, float last, AroundLanes& out) {
    const Ints one = Ints{} + 1, end = Ints{} + std::int32_t(last);
    Lanes low;
    toInts(Wraps ? x + 1 : x, out.low);
    if (Wraps) out.low -= one;  // x >= -1/2
    toFloats(out.low, low);
    out.share = x - low;
    if (Wraps) {
        out.high = out.low + one;
        out.low += (out.low < 0) & (end + one);
        out.high &= ~(out.high > end);
        return;
    }
    out.high = out.low + ((out.low < end) & one);
}

struct PointLanes {
    Lanes row, column, height;
};

template <bool Wraps>
inline void sampleTap(const HeightScene& scene, const HeightTap& tap, const PointLanes& at, Lanes& out) {
    Lanes row = at.row + tap.row, column = at.column + tap.column;
    if (Wraps) {
        wrap(row, scene.rows);
        wrap(column, scene.columns);
    }
    row = row * tap.scale + tap.offset;
    column = column * tap.scale + tap.offset;
    if (!Wraps) {
        clamp(row, kZeros, kZeros + tap.last_row);
        clamp(column, kZeros, kZeros + tap.last_column);
    }
    AroundLanes r, c;
    around<Wraps>(row, tap.last_row, r);
    around<Wraps>(column, tap.last_column, c);
    const float* const heights = scene.heights + tap.first;
    const Ints upper_row = r.low * tap.columns, lower_row = r.high * tap.columns;
    Lanes corner[4];
    gather(heights, upper_row + c.low, corner[0]);
    gather(heights, upper_row + c.high, corner[1]);
    gather(heights, lower_row + c.low, corner[2]);
    gather(heights, lower_row + c.high, corner[3]);
    // Equal corners give that very number, so that a level field has level horizons.
    const Lanes upper = corner[0] + c.share * (corner[1] - corner[0]),
                lower = corner[2] + c.share * (corner[3] - corner[2]);
    out = upper + r.share * (lower - upper);
}

template <bool Wraps>
inline void horizonOf(const HeightScene& scene, const HeightTap* taps, const PointLanes& at, Lanes& tangent) {
    tangent = kZeros + scene.least;
    for (std::size_t k = 0; k < scene.tap_count; ++k) {
        const HeightTap& tap = taps[k];
        const Lanes row = at.row + tap.row, column = at.column + tap.column;
        Lanes height;
        sampleTap<Wraps>(scene, tap, at, height);
        Lanes slope = (height - at.height) * tap.per_metre;
        if (scene.open)
            choose((row >= -0.5f) & (row <= scene.rows - 0.5f) & (column >= -0.5f) & (column <= scene.columns - 0.5f),
                   slope, tangent, slope);
        most(tangent, slope, tangent);
    }
}

// Arc tangent of x >= 0 (Cephes, atanf).
inline void arcTangent(const Lanes& x, Lanes& out) {
    const Ints large = x > 2.4142135623730950f, middle = x > 0.4142135623730950f;
    Lanes y, start;
    choose(middle, (x - 1) / (x + 1), x, y);
    choose(large, -1 / x, y, y);
    choose(middle, kZeros + 0.785398163397448f, kZeros, start);
    choose(large, kZeros + 1.570796326794897f, start, start);
    const Lanes z = y * y;
    out = start + y +
          y * z * (((8.05374449538e-2f * z - 1.38776856032e-1f) * z + 1.99777106478e-1f) * z - 3.33329491539e-1f);
}

// horizonThetas(), without the norms.
inline void thetas(int order, const Lanes& tangent, Lanes* out) {
    Lanes per = 1 + tangent * tangent, b;
    root(per);
    const Lanes c = 1 / per, s = tangent * c, s2 = s * s, c2 = c * c, c3 = c2 * c;
    arcTangent(c / (1 + s), b);
    b = b + b;
    const Lanes j0 = (b - s * c) * 0.5f, j2 = (b + s * c * (1 - 2 * s2)) * 0.125f;
    out[0] = 1 - s;
    out[1] = c2 * 0.5f;
    out[2] = -j0;
    out[3] = s * c2 * 0.5f;
    out[4] = -c3;
    out[5] = 2 - 3 * s + s2 * s;
    out[6] = c2 * (5 * s2 - 1) * 0.125f;
    out[7] = -1.5f * (5 * j2 - j0);
    out[8] = 3.75f * c2 * c2;
    out[9] = -1.875f * (3 * b - s * c * (5 - 2 * s2));
    if (order < 5) return;
    const Lanes c5 = c3 * c2;
    out[10] = s * c2 * (7 * s2 - 3) * 0.125f;
    out[11] = -10.0f / 3 * c3 + 3.5f * c5;
    out[12] = 2 + s * (7.5f + s2 * (-20 + 10.5f * s2));
    out[13] = -21 * c5;
    out[14] = 56 + s * (-105 + s2 * (70 - 21 * s2));
}

inline void addAzimuth(const HeightScene& scene, const float* turn, const Lanes& tangent, Lanes* sum) {
    Lanes theta[15];
    thetas(scene.order, tangent, theta);
    for (int l = 0, i = 0; l < scene.order; ++l)
        for (int m = 0; m <= l; ++m, ++i) {
            const Lanes scaled = theta[i] * scene.norms[i];
            sum[l * (l + 1) + m] += turn[2 * m] * scaled;
            if (m > 0) sum[l * (l + 1) - m] += turn[2 * m + 1] * scaled;
        }
}

inline void loadLanes(const float* from, std::size_t count, Lanes& out) {
    for (std::size_t i = 0; i < kLanes; ++i) setLane(out, i, from[i < count ? i : 0]);
}

void visibilityLanes(const HeightScene& scene, const HeightPoints& points, std::size_t stride, float* out) {
    for (std::size_t first = 0; first < points.count; first += kLanes) {
        const std::size_t count = points.count - first < kLanes ? points.count - first : kLanes;
        PointLanes at;
        loadLanes(points.rows + first, count, at.row);
        loadLanes(points.columns + first, count, at.column);
        loadLanes(points.heights + first, count, at.height);
        Lanes sum[32] = {};
        for (int a = 0; a < scene.azimuths; ++a) {
            const HeightTap* const taps = scene.taps + std::size_t(a) * scene.tap_count;
            Lanes tangent;
            if (scene.wraps)
                horizonOf<true>(scene, taps, at, tangent);
            else
                horizonOf<false>(scene, taps, at, tangent);
            addAzimuth(scene, scene.turns + 2 * scene.order * a, tangent, sum);
        }
        storeRows(sum, stride, scene.order * scene.order, count, out + first * stride);
    }
}

// The turns that bring a normal to z and a tangent to x: about z by -phi, about y by -beta, about z by psi.
struct TurnLanes {
    Lanes cos_phi, sin_phi, cos_beta, sin_beta, cos_psi, sin_psi;
};

inline void turnsOf(const HeightFrames& frames, std::size_t first, std::size_t count, TurnLanes& out) {
    Lanes n[3], t[3];
    for (std::size_t i = 0; i < kLanes; ++i) {
        setLane(n, i, frames.normals[first + (i < count ? i : 0)]);
        setLane(t, i, frames.tangents[first + (i < count ? i : 0)]);
    }
    const Lanes b0 = n[1] * t[2] - n[2] * t[1], b1 = n[2] * t[0] - n[0] * t[2];
    out.sin_beta = n[0] * n[0] + n[1] * n[1];
    root(out.sin_beta);
    out.cos_beta = n[2];
    const Ints tilted = out.sin_beta > 1e-7f, up = n[2] >= 0;
    choose(tilted, n[0] / out.sin_beta, kZeros + 1, out.cos_phi);
    choose(tilted, n[1] / out.sin_beta, kZeros, out.sin_phi);
    // psi - phi where the normal points up, psi + phi where it points down: either is well known there.
    Lanes cosine, sine, sin_phi;
    choose(up, t[0] + b1, b1 - t[0], cosine);
    choose(up, b0 - t[1], -b0 - t[1], sine);
    Lanes size = cosine * cosine + sine * sine;
    root(size);
    cosine /= size;
    sine /= size;
    choose(up, out.sin_phi, -out.sin_phi, sin_phi);
    out.cos_psi = cosine * out.cos_phi - sine * sin_phi;
    out.sin_psi = sine * out.cos_phi + cosine * sin_phi;
}

// Turns whole SH about z.
inline void turnAll(int order, const Lanes& cosine, const Lanes& sine, Lanes* v) {
    Lanes c = cosine, s = sine;
    for (int m = 1; m < order; ++m) {
        for (int l = m; l < order; ++l) {
            Lanes &plus = v[l * (l + 1) + m], &minus = v[l * (l + 1) - m];
            const Lanes turned = c * plus - s * minus;
            minus = s * plus + c * minus;
            plus = turned;
        }
        const Lanes next = c * cosine - s * sine;
        s = s * cosine + c * sine;
        c = next;
    }
}

inline void turnPairs(const HeightMirror& mirror, const Lanes& cosine, const Lanes& sine, Lanes* v) {
    Lanes c = cosine, s = sine;
    int m = 1;
    for (std::size_t p = 0; p < mirror.pair_count; ++p) {  // by ascending m
        for (; m < mirror.pairs[p].m; ++m) {
            const Lanes next = c * cosine - s * sine;
            s = s * cosine + c * sine;
            c = next;
        }
        Lanes &plus = v[mirror.pairs[p].plus], &minus = v[mirror.pairs[p].minus];
        const Lanes turned = c * plus - s * minus;
        minus = s * plus + c * minus;
        plus = turned;
    }
}

inline void clampAmbientLanes(const HeightMirror& mirror, Lanes* v) {
    Lanes e = kZeros;
    for (int i = 0; i < mirror.size; ++i)
        if (mirror.ambient[i] != 0) e += mirror.ambient[i] * v[i];
    Lanes inside = e;
    clamp(inside, kZeros, kZeros + 1);
    const Lanes excess = (e - inside) * (1 / mirror.ambient_norm2);
    for (int i = 0; i < mirror.size; ++i)
        if (mirror.ambient[i] != 0) v[i] -= mirror.ambient[i] * excess;
}

void mirrorLanes(const HeightMirror& mirror, const HeightFrames& frames, const float* rows, std::size_t row_stride,
                 std::size_t count, std::size_t stride, float* out) {
    for (std::size_t first = 0; first < count; first += kLanes) {
        const std::size_t n = count - first < kLanes ? count - first : kLanes;
        TurnLanes turns;
        turnsOf(frames, first, n, turns);
        Lanes v[40], upright[40] = {}, local[24] = {};
        loadRows(rows + first * row_stride, row_stride, mirror.order * mirror.order, n, v);
        turnAll(mirror.order, turns.cos_phi, -turns.sin_phi, v);
        for (std::size_t i = 0; i < mirror.quarter_count; ++i)
            upright[mirror.quarter[i].to] += mirror.quarter[i].value * v[mirror.quarter[i].from];
        turnAll(mirror.order, turns.cos_beta, -turns.sin_beta, upright);
        for (std::size_t i = 0; i < mirror.mirror_count; ++i)
            local[mirror.mirror[i].to] += mirror.mirror[i].value * upright[mirror.mirror[i].from];
        turnPairs(mirror, turns.cos_psi, turns.sin_psi, local);
        if (mirror.below)
            for (int i = 0; i < mirror.size; ++i) local[i] += mirror.below[i];
        clampAmbientLanes(mirror, local);
        storeRows(local, stride, mirror.size, n, out + first * stride);
    }
}

void blendLanes(const HeightBlend* blends, std::size_t count, std::size_t row_size, float* out) {
    for (std::size_t b = 0; b < count; ++b)
        for (std::size_t i = 0; i < row_size; i += kLanes) {
            Lanes sum = kZeros, corner;
            for (int k = 0; k < 4; ++k) {
                loadFloats(blends[b].corners[k] + i, corner);
                sum += blends[b].weights[k] * corner;
            }
            storeFloats(sum, out + b * row_size + i);
        }
}

}  // namespace

const HeightPath HeightPath::PENUMBRA_TARGET{PENUMBRA_TARGET_NAME, visibilityLanes, mirrorLanes, blendLanes};

}  // namespace penumbra
