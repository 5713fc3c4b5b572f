#pragma once
// The inner loop of shading reads plain tables and shades 8 vertices at a time (shade_lanes.cpp). The formulas are
// those of section 3 of docs/formulas.md.
//
// Per vertex, with Q the rotation into the local frame and o = Q (eye - p) / |eye - p|, it computes
//   f_k = sum_e A_ke y_e(o)                by the view terms; A is C of the slices, or w of the operators
//   t_i = sum_j v_j (sum_k B_ijk f_k)      by the product rows; B is Gamma_ijk, or M^k_ij of the operators
//   L   = sum over the light of it with t  in one of the two ways below
// B is symmetric in i and j, so a row whose mirror is also wanted serves both. Nowrouzezahrai 2009 eq 11 has the
// operators.
//
// The light is one of
//   lobes:    sum_d sum_l g_dl sum_m t_lm y_lm(Q a_d), for light = sum_d sum_l g_dl sum_m y_lm(a_d) y_lm
//   rotation: l . (R(Q)^T t), with Q = Z(a) Y(b) Z(c) and Y(b) = X(-90) Z(b) X(90): three turns about z, two fixed ones
//
// Light that bounces (docs/formulas.md, section 15) adds E_ind / pi (a - t_u) / (1 - E), with a = 4 pi sum_k B_00k f_k
// the albedo towards the eye, t_u = sqrt(4 pi) t_0 what it is under the visible part of a white sky, and E_ind the
// light of this kernel's own indirect numbers.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sh/kernel.h"
#include "sh/sh_basis.h"
#include "sh/vec3.h"

namespace penumbra {

// An entry of A: f_k += value y_e(o).
struct ViewTerm {
    std::uint16_t k, e;  // index of f, SH index of the view function
    float value;
};
// An entry of B, whose i and j are those of its row.
struct ProductTerm {
    std::uint16_t k;
    float value;
};
// A row stands for t_i += v_j s and, if it has a mirror, t_mirror_i += v_mirror_j s. s is the sum of value * f_k over
// its terms.
struct ProductRow {
    std::uint16_t i, j;  // light coefficient, position among the numbers
    std::uint16_t mirror_i, mirror_j;
    std::uint16_t terms;
};
// An entry of a constant matrix: out_to += value in_from.
struct SparseTerm {
    std::uint16_t to, from;
    float value;
};
// An entry of the fixed rotation R(X(90)).
struct TurnTerm {
    std::uint16_t to, from;
    float value;
};

// A lobe about the mirror direction of the view, in the place of view terms and product rows (live_lobe.h). Every list
// is sorted by `to`.
struct ShadeLive {
    int order;                 // order of the moments
    const float* offset;       // [order^2] of the moments
    const SparseTerm* moment;  // numbers to moments
    std::size_t moment_terms;
    const SparseTerm* turn;  // R(X(90)) of the moments, and its transpose
    std::size_t turn_terms;
    const SparseTerm* turn_back;
    std::size_t turn_back_terms;
    const SparseTerm* matrix;  // moments to t, in the mirror frame
    std::size_t matrix_terms;
    const float* albedo;  // [order] the albedo towards the eye, as a Legendre series in the eye's cosine
};

// Raw pointers make sure that files compiled for one processor call nothing inline from the standard library.
struct ShadeMaterial {
    int view_order;
    std::size_t channels;  // 1 or 3
    const ViewTerm* views[3];
    std::size_t view_terms[3];
    const ProductRow* rows;  // rows with a mirror come first
    std::size_t mirrored_rows, row_count;
    const ProductTerm* products[3];          // for every channel; all point to the same ones for slices
    std::size_t albedo_first, albedo_terms;  // the terms of the row (0, 0) among them
    float color[3];                          // factors on the radiance: the material's colour when it has one channel
    float least_hidden;                      // lower bound of the reflected bounced light: 0, or no bound if f has
                                             // signs
    bool is_live;                            // `live` is all that counts besides channels, which are 1, and colour
    ShadeLive live;
};

// The product of light and visibility for all materials of a surface. The frame of a vertex is turned about its normal
// until the eye has azimuth 0. There an isotropic f has no k with m < 0, and
//   g_k = sum_i l_i T_ik,  T_ik = sum_j Gamma_ijk v_j,  L = sum_k f_k g_k for each material.
struct JointTerm {
    std::uint16_t j;  // SH index
    float value;
};
struct JointRow {
    std::uint16_t k, i, terms;
};
// A number of the visibility: the SH function (l, m) at `index`, and where (l, |m|) and (l, -|m|) are among the
// numbers.
struct JointCoefficient {
    std::uint16_t index, plus, minus;
    int m;
};
struct ShadeJoint {
    int order;                             // order of the coefficients
    const JointCoefficient* coefficients;  // [size]
    const JointRow* rows;                  // sorted by k
    std::size_t row_count;
    const JointTerm* products;
    const SparseTerm *turn, *turn_back;  // R(X(90)) and its transpose, for the order of the light
    std::size_t turn_terms;              // number of terms in each
};
constexpr std::size_t kMaxJointTerms = 7;  // D, then A and B at three roughnesses
struct ShadeTerm {
    const ViewTerm* views;  // sorted by k
    std::size_t view_terms;
    float color[3];
    std::size_t to;  // radiance is [terms, vertices], and this is the place among the terms
};
struct ShadeTerms {
    ShadeJoint joint;
    int view_order;
    std::size_t vertices, count;  // count: of the terms
    ShadeTerm terms[kMaxJointTerms];
    bool has_slopes;      // a vector a colour, to the places 1 to 3: those along the two axes are slopes
    ShadeTerm slopes[2];  // materials for s_x / pi and s_y / pi; their colour is 1, and views have e = 0
};

struct ShadeLight {
    int order;
    bool lobes;        // true: lobes; false: rotation
    const Vec3* axes;  // lobes: [axis_count], model frame, unit
    const Vec3* lobe;  // lobes: g [axis_count, order], RGB
    std::size_t axis_count;
    const Vec3* sh;         // rotation: [order^2], RGB
    const TurnTerm* turns;  // rotation: R(X(90)); its transpose is R(X(-90))
    std::size_t turn_count;
    // y(l, +-m) = q_l {Re, Im}(x + iy)^m; q_m = a, q_l = a z q_(l-1) - b q_(l-2); a, b at [l * kMaxOrder + m].
    const float *basis_a, *basis_b;
};

// The light as what bounces meets it, in the model frame: a constant, three numbers of band 1 as a vector, six of band
// 2 as the symmetric matrix xx, yy, zz, xy, xz, yz, each times the first colour axis, and then the constant times the
// second and the third one (makeBouncedLight()).
constexpr std::size_t kBouncedLight = 12;

struct ShadeInput {
    const Vec3 *positions = nullptr, *normals = nullptr, *tangents = nullptr;
    const float* coefficients = nullptr;
    int stride = 0, size = 0;  // layout of `coefficients`; the padding is not read
    Vec3 eye;
    Vec3* radiance = nullptr;
    const std::uint32_t* order = nullptr;  // the n-th vertex to shade; null: n itself
    Vec3* packed = nullptr;                // set: the radiance of the n-th goes to packed[n - packed_first]
    std::size_t packed_first = 0;
    // Bounced light, or null: transfer [V, kIndirectStride], the light's bands [kBouncedLight], weights of E [size].
    const float* indirect = nullptr;
    const Vec3* bounced = nullptr;
    const float* ambient = nullptr;
    // Irradiance of light that others reflect onto the vertex [V]; null: none. It needs `ambient` too.
    const Vec3* received = nullptr;
    bool bounces() const { return indirect || received; }
    bool direct = true;  // false: the light that bounces alone
};

struct ShadePath {
    static const ShadePath portable, avx2;
    const char* name = "";
    void (*shade)(const ShadeMaterial& material, const ShadeLight& light, const ShadeInput& input, std::size_t begin,
                  std::size_t end) = nullptr;
    // Shades all terms of one surface, [terms, V] at input.radiance. Null: they are shaded one by one.
    void (*shade_terms)(const ShadeTerms& terms, const ShadeLight& light, const ShadeInput& input, std::size_t begin,
                        std::size_t end) = nullptr;
};

// Returns the paths that this processor can run, slowest first. PENUMBRA_NO_SIMD leaves only the portable one.
inline std::vector<ShadePath> shadePaths() { return pathsOf<ShadePath>(); }

}  // namespace penumbra
