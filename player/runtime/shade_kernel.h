#pragma once
// The inner loop of VertexShader: plain tables and 8 vertices at a time, so that the same source (shade_lanes.h) is
// compiled once for any processor and once for AVX2.
//
// Per vertex, with Q the rotation into the local frame and o = Q (eye - p) / |eye - p|:
//   f_k = sum_e C_ke y_e(o)                          slice terms: the non-zero C only
//   t_i = sum Gamma_ijk v_j f_k                      product terms: v_j != 0 by the convention, f_k != 0 by the
//   material L   = sum_d sum_l g_dl sum_m t_lm y_lm(Q a_d)    light = sum_d sum_l g_dl sum_m y_lm(a_d) y_lm, 2n-1 fixed
//   axes a_d
// The last line is t rotated into the model frame times the light, exactly: a zonal lobe rotates by evaluating the
// basis at its rotated axis, which costs less than an SH rotation a vertex.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sh/sh_basis.h"
#include "sh/vec3.h"

namespace penumbra {

constexpr std::size_t kShadeLanes = 8;

struct SliceTerm {
    std::uint16_t k, e;  // SH indices: of the slice, of the view function
    float value;
};
// t_i += v_j * (sum of value * f_k over the row's terms).
struct ProductTerm {
    std::uint16_t k;  // slice index
    float value;
};
struct ProductRow {
    std::uint16_t i, j, terms;  // light coefficient, position among the numbers, how many of the terms are this row's
};

// Raw pointers, so that the files compiled for one processor call nothing inline of the standard library.
struct ShadeTables {
    int view_order, slice_order, light_order;
    int stride, size;      // of the numbers; the padding is not read
    std::size_t channels;  // 1 or 3
    const SliceTerm* slices[3];
    std::size_t slice_terms[3];
    const ProductRow* rows;
    std::size_t row_count;
    const ProductTerm* products;
    const Vec3* axes;  // model frame, unit
    std::size_t axis_count;
    const Vec3* lobes;  // g: [axis, light_order], RGB; with one channel the material's colour is in it
    // y(l, +-m) = q_l {Re, Im}(x + iy)^m; q_m = a, q_l = a z q_(l-1) - b q_(l-2); a, b at [l * kMaxOrder + m].
    const float *basis_a, *basis_b;
};

struct ShadeInput {
    const Vec3 *positions = nullptr, *normals = nullptr, *tangents = nullptr;
    const float* numbers = nullptr;
    Vec3 eye;
    Vec3* radiance = nullptr;
};

struct ShadePath {
    const char* name = "";
    void (*shade)(const ShadeTables& tables, const ShadeInput& input, std::size_t begin, std::size_t end) = nullptr;
};

// The paths that this processor can run, slowest first; PENUMBRA_NO_SIMD leaves only the portable one.
std::vector<ShadePath> shadePaths();

extern const ShadePath* const kShadeAvx2;  // null where the compiler has no such target
bool cpuHasAvx2();                         // with FMA and F16C

}  // namespace penumbra
