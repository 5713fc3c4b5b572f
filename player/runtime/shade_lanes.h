// The source of every shading path: included by shade_portable.cpp and shade_avx2.cpp, which differ in the processor
// they are compiled for. Everything has internal linkage and nothing inline of the standard library is called, so that
// no copy made for one processor can end up in the other's path. Vectors go by reference: passing 32-byte vectors by
// value has no fixed ABI without AVX.
#include "player/runtime/shade_kernel.h"

namespace penumbra {

namespace {

typedef float Lanes __attribute__((vector_size(4 * kShadeLanes)));

struct LaneVec3 {
    Lanes x, y, z;
};

// The SH basis of 8 unit directions; recurrences: shade_kernel.h.
inline void laneBasis(const ShadeTables& tables, int order, const LaneVec3& d, Lanes* out) {
    Lanes re = d.x * 0.0f + 1.0f, im = d.x * 0.0f;
    for (int m = 0; m < order; ++m) {
        Lanes q = d.x * 0.0f + tables.basis_a[m * kMaxOrder + m], before = d.x * 0.0f;
        for (int l = m; l < order; ++l) {
            if (l > m) {
                const float a = tables.basis_a[l * kMaxOrder + m], b = tables.basis_b[l * kMaxOrder + m];
                const Lanes next = a * (d.z * q) - b * before;
                before = q;
                q = next;
            }
            if (m > 0) out[l * l + l - m] = q * im;
            out[l * l + l + m] = q * re;
        }
        const Lanes turned = re * d.x - im * d.y;
        im = re * d.y + im * d.x;
        re = turned;
    }
}

struct LaneFrames {
    LaneVec3 tangent, bitangent, normal;
    LaneVec3 view;  // local frame, unit
};

// Vertices first..first+7, or the last one again beyond `end`.
inline void gather(const ShadeInput& in, std::size_t first, std::size_t end, LaneFrames& out) {
    for (std::size_t lane = 0; lane < kShadeLanes; ++lane) {
        const std::size_t v = first + lane < end ? first + lane : end - 1;
        const Vec3 n = in.normals[v], t = in.tangents[v], p = in.positions[v];
        const float bx = n.y * t.z - n.z * t.y, by = n.z * t.x - n.x * t.z, bz = n.x * t.y - n.y * t.x;
        float ox = in.eye.x - p.x, oy = in.eye.y - p.y, oz = in.eye.z - p.z;
        const float square = ox * ox + oy * oy + oz * oz;
        const float scale = square > 0 ? 1 / __builtin_sqrtf(square) : 0;
        ox *= scale, oy *= scale, oz *= scale;
        out.tangent.x[lane] = t.x, out.tangent.y[lane] = t.y, out.tangent.z[lane] = t.z;
        out.bitangent.x[lane] = bx, out.bitangent.y[lane] = by, out.bitangent.z[lane] = bz;
        out.normal.x[lane] = n.x, out.normal.y[lane] = n.y, out.normal.z[lane] = n.z;
        out.view.x[lane] = ox * t.x + oy * t.y + oz * t.z;
        out.view.y[lane] = ox * bx + oy * by + oz * bz;
        out.view.z[lane] = square > 0 ? ox * n.x + oy * n.y + oz * n.z : 1;
    }
}

inline void gatherNumbers(const ShadeTables& tables, const ShadeInput& in, std::size_t first, std::size_t end,
                          Lanes* v) {
    for (std::size_t lane = 0; lane < kShadeLanes; ++lane) {
        const std::size_t vertex = first + lane < end ? first + lane : end - 1;
        const float* numbers = in.numbers + vertex * std::size_t(tables.stride);
        for (int j = 0; j < tables.size; ++j) v[j][lane] = numbers[j];
    }
}

// t = f x v with f = C y_even(view) of one channel.
inline void transfer(const ShadeTables& tables, std::size_t channel, const Lanes* view_basis, const Lanes* v,
                     Lanes* t) {
    Lanes f[kMaxOrder * kMaxOrder] = {};
    for (std::size_t s = 0; s < tables.slice_terms[channel]; ++s) {
        const SliceTerm& term = tables.slices[channel][s];
        f[term.k] += term.value * view_basis[term.e];
    }
    for (int i = 0; i < tables.light_order * tables.light_order; ++i) t[i] = v[0] * 0.0f;
    const ProductTerm* term = tables.products;
    for (std::size_t r = 0; r < tables.row_count; ++r) {
        const ProductRow row = tables.rows[r];
        Lanes sum = term->value * f[term->k];
        for (const ProductTerm* last = term++ + row.terms; term < last; ++term) sum += term->value * f[term->k];
        t[row.i] += v[row.j] * sum;
    }
}

// radiance_c += g_c * (sum over m of t y(axis in the local frame)) for every axis and band.
inline void light(const ShadeTables& tables, const LaneFrames& frames, const Lanes (*t)[kMaxOrder * kMaxOrder],
                  Lanes* radiance) {
    Lanes basis[kMaxOrder * kMaxOrder];
    const Vec3* g = tables.lobes;
    for (std::size_t d = 0; d < tables.axis_count; ++d) {
        const Vec3 a = tables.axes[d];
        const LaneVec3 local{frames.tangent.x * a.x + frames.tangent.y * a.y + frames.tangent.z * a.z,
                             frames.bitangent.x * a.x + frames.bitangent.y * a.y + frames.bitangent.z * a.z,
                             frames.normal.x * a.x + frames.normal.y * a.y + frames.normal.z * a.z};
        laneBasis(tables, tables.light_order, local, basis);
        for (int l = 0; l < tables.light_order; ++l, ++g) {
            const float weight[3] = {g->x, g->y, g->z};
            Lanes sum = {};
            for (std::size_t c = 0; c < 3; ++c) {
                if (c < tables.channels) {
                    sum = t[c][l * l] * basis[l * l];
                    for (int i = l * l + 1; i < (l + 1) * (l + 1); ++i) sum += t[c][i] * basis[i];
                }
                radiance[c] += weight[c] * sum;
            }
        }
    }
}

inline void shadeLanes(const ShadeTables& tables, const ShadeInput& in, std::size_t begin, std::size_t end) {
    for (std::size_t first = begin; first < end; first += kShadeLanes) {
        LaneFrames frames;
        gather(in, first, end, frames);
        Lanes v[kMaxOrder * kMaxOrder], view_basis[kMaxOrder * kMaxOrder], t[3][kMaxOrder * kMaxOrder];
        gatherNumbers(tables, in, first, end, v);
        laneBasis(tables, tables.view_order, frames.view, view_basis);
        for (std::size_t c = 0; c < tables.channels; ++c) transfer(tables, c, view_basis, v, t[c]);
        Lanes radiance[3] = {};
        light(tables, frames, t, radiance);
        for (std::size_t lane = 0; lane < kShadeLanes && first + lane < end; ++lane) {
            Vec3& out = in.radiance[first + lane];
            out.x = radiance[0][lane];
            out.y = radiance[1][lane];
            out.z = radiance[2][lane];
        }
    }
}

}  // namespace

}  // namespace penumbra
