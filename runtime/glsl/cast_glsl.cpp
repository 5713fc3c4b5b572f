// Writes the visibility past casters as GLSL. That past fields is far_glsl.cpp's; the rest of this is about spheres.
//
// Problem: a receiver adds the logarithms of the spheres and takes the exponential of the sum: 2 SH products of order 5
// for the series and up to 8 for the squarings, of some thousand operations each.
//
// Naive: one function for products and one for squares, called where they are needed. GLSL compilers write every call
// out, so the product would stand there four times and take seconds to compile.
//
// Here: one loop with one product in it. The first two rounds are the series in Horner's form, 1 + x (1 + x/2 (1 +
// x/3)), and the others square. Each pair a_j b_k + a_k b_j of the product is computed once and added to all numbers
// that it belongs to, so that no table is read and few registers are in use.
#include "runtime/glsl/cast_glsl.h"

#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "runtime/cast/cast_shadow.h"
#include "runtime/glsl/far_glsl.h"
#include "runtime/glsl/sh_glsl.h"
#include "sh/cast/cap_visibility.h"
#include "sh/cast/cast_visibility.h"
#include "sh/far/far_tables.h"
#include "sh/sh_product.h"

namespace penumbra {

namespace {

constexpr int kCastCoefficients = coefficientCount(kCastOrder);
static_assert(kCastCoefficients == 25 && kMirroredCast == 21 && kFieldOrder == 6, "the text below has these sizes");

std::string castElement(const char* array, int i) { return std::string(array) + "[" + std::to_string(i) + "]"; }

std::string vectorElement(int i) { return "numbers[" + std::to_string(i / 4) + "]." + "xyzw"[i % 4]; }

// Place of y_i among the functions with even l+m; -1 for the others.
int mirroredPlace(int i) {
    const int l = int(std::sqrt(double(i) + 0.5)), m = i - shIndex(l, 0);
    return (l + m) % 2 ? -1 : l * (l + 1) / 2 + (m + l) / 2;
}

void addProduct(std::string& sum, double value, const std::string& what) {
    sum += (sum.empty() ? "" : " + ") + glslFloat(value) + " * " + what;
}

constexpr const char* kCastHead =
    R"(// What casters hide from a point. Where they are spheres, the shader defines before:
//   #define PENUMBRA_SPHERE(i): sphere i as vec4(center, radius). One of radius 0 hides nothing.
//   #define PENUMBRA_CAP_LOG(texel): the vec4 at `texel` of penumbra_get_cap_logs()
// Where they are parts with fields:
//   #define PENUMBRA_PART(part, row): the vec4 `row` (0 to 6) of a part, penumbra_character_get_parts()
//   #define PENUMBRA_FIELD(word): the uint at `word`, a uint, of penumbra_asset_get_fields()

)";

constexpr const char* kSphereSight =
    R"(// The direction to the sphere's center, the place of its cap among the entries of the table, and its weight. Returns
// whether the sphere counts. From inside its cap shrinks, and from afar its weight falls to 0.
bool penumbra_see_sphere(vec4 sphere, vec3 position, out vec3 direction, out float entry, out float weight) {
    vec3 to_center = sphere.xyz - position;
    float distance = length(to_center);
    direction = vec3(0.0);
    entry = weight = 0.0;
    if (!(sphere.w > 0.0 && distance >= 1e-6)) return false;
    float sine = distance >= sphere.w ? sphere.w / distance : sqrt(distance / sphere.w);
    float half_ratio = 0.5 * sphere.w / distance;
)";

std::string sightGlsl() {
    const double half_sine = std::sin(kMaxCapAngle / 2);
    return std::string(kSphereSight) + "    weight = clamp((half_ratio * half_ratio - " +
           glslFloat(double(kSphereFade.least)) + ") * " +
           glslFloat(1 / (double(kSphereFade.full) - double(kSphereFade.least))) + R"(, 0.0, 1.0);
    if (!(sine > 0.0 && weight > 0.0)) return false;
    sine = min(sine, 1.0);
    direction = to_center / distance;
    entry = sine / sqrt(2.0 + 2.0 * sqrt((1.0 - sine) * (1.0 + sine))) * )" +
           glslFloat(double(kCapLogEntries - 1) / half_sine) + ";\n    return true;\n}\n\n";
}

// Writes out = a b of two functions over the whole sphere.
std::string castProductGlsl() {
    std::map<std::pair<int, int>, std::string> sums;  // what the pair (j, k), j <= k, adds
    for (const TripleProductEntry& e : tripleProduct(kCastOrder, kCastOrder, kCastOrder))
        if (e.j <= e.k) sums[{e.j, e.k}] += " " + castElement("c", e.i) + " += " + glslFloat(e.value) + " * p;";
    std::string text =
        "// Writes the SH product of a and b.\n"
        "void penumbra_cast_multiply(float a[25], float b[25], out float c[25]) {\n    float p;\n"
        "    for (int i = 0; i < 25; ++i) c[i] = 0.0;\n";
    for (const auto& [pair, sum] : sums) {
        const auto [j, k] = pair;
        text += "    p = " + castElement("a", j) + " * " + castElement("b", k);
        if (j != k) text += " + " + castElement("a", k) + " * " + castElement("b", j);
        text += ";" + sum + "\n";
    }
    return text + "}\n\n";
}

std::string exponentialGlsl() {
    const std::string root = glslFloat(2 * std::sqrt(std::numbers::pi));
    return R"(// v = exp(v).
void penumbra_cast_exponential(inout float v[25]) {
    const float one = )" +
           root + R"(;  // coefficient 0 of the function that is 1
    float norm = 0.0, scale = 1.0;
    for (int i = 1; i < 25; ++i) norm += v[i] * v[i];
    norm = sqrt(norm);
    // Where a crowd hides all, its logarithm tells by how much more than all.
    float least = min(1.0, 24.0 / max(norm, 1e-6));
    norm *= least;
    for (int i = 0; i < 25; ++i) v[i] *= least;
    int squarings = 0;
    for (; squarings < 8 && norm * scale > 0.5; ++squarings) scale *= 0.5;
    float constant = exp(v[0] * scale / one), b[25], product[25];
    v[0] = 0.0;
    for (int i = 1; i < 25; ++i) v[i] *= scale;
    for (int i = 0; i < 25; ++i) b[i] = v[i] / 3.0;
    b[0] += one;
    for (int step = 0; step < squarings + 2; ++step) {
        penumbra_cast_multiply(v, b, product);
        float factor = step == 0 ? 0.5 : step == 1 ? constant : 1.0;
        for (int i = 0; i < 25; ++i) b[i] = factor * product[i];
        if (step == 0) b[0] += one;
        if (step == 1) b[0] += constant * one;
        if (step > 0) v = b;
    }
}

)";
}

std::string addSphereGlsl() {
    std::string text =
        R"(// Adds a share of the logarithm of what sphere i leaves visible. Returns whether the sphere counts.
bool penumbra_cast_sphere(int i, float share, vec3 position, mat3 local_from_scene, inout float logarithm[25]) {
    vec3 d;
    float entry, weight;
    if (!penumbra_see_sphere(PENUMBRA_SPHERE(i), position, d, entry, weight)) return false;
    weight *= share;
    d = local_from_scene * d;
    int e = int(entry);
    vec4 z = weight * mix(PENUMBRA_CAP_LOG(2 * e), PENUMBRA_CAP_LOG(2 * e + 2), entry - float(e));
    float z4 = weight * mix(PENUMBRA_CAP_LOG(2 * e + 1).x, PENUMBRA_CAP_LOG(2 * e + 3).x, entry - float(e));
)" + basisGlsl(kCastOrder, BasisPart::kAll, "y", "d");
    for (int l = 0; l < kCastOrder; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
            text += "    " + castElement("logarithm", i) + " += " + (l < 4 ? std::string("z.") + "xyzw"[l] : "z4") +
                    " * y" + std::to_string(i) + ";\n";
    return text + "    return true;\n}\n\n";
}

std::string castVisibilityGlsl() {
    return R"(// Writes the visibility past all spheres i < sphere_count but those with left_out.x <= i < left_out.y: SH of
// order 5 over the whole sphere of directions, in the frame whose axes are the rows of local_from_scene. Returns false
// where no sphere counts and everything is visible.
bool penumbra_cast_visibility(int sphere_count, ivec2 left_out, vec3 position, mat3 local_from_scene,
                              out float visibility[25]) {
    bool seen = false;
    for (int i = 0; i < 25; ++i) visibility[i] = 0.0;
    for (int i = 0; i < sphere_count; ++i)
        if ((i < left_out.x || i >= left_out.y) && penumbra_cast_sphere(i, 1.0, position, local_from_scene, visibility))
            seen = true;
    if (seen) penumbra_cast_exponential(visibility);
    else visibility[0] = )" +
           glslFloat(2 * std::sqrt(std::numbers::pi)) + ";\n    return seen;\n}\n\n";
}

// mirrorAtHorizon() (sh/mirrored_product.h), as mirrorOrder() of sh/far/far_turns.h has it.
std::string castMirrorGlsl() {
    std::string text =
        "// Writes what is visible above the horizon, mirrored there: the 21 SH of order 6 with even l+m. "
        "`visibility`\n"
        "// is in the local frame of the receiver, whose last axis is its normal.\n"
        "void penumbra_cast_mirror(float visibility[25], out float mirrored[21]) {\n";
    for (int l = 0; l < kFieldOrder; ++l)
        for (int m = -l; m <= l; m += 2) {
            const int place = mirroredPlace(shIndex(l, m));
            std::string sum = l < kCastOrder ? castElement("visibility", shIndex(l, m)) : "";
            for (int from = std::abs(m) + 1; from < kCastOrder; from += 2)
                addProduct(sum, double(mirrorTable()[std::size_t(place)][from]),
                           castElement("visibility", shIndex(from, m)));
            text += "    " + castElement("mirrored", place) + " = " + (sum.empty() ? "0.0" : sum) + ";\n";
        }
    return text + "}\n\n";
}

}  // namespace

std::string castAmbientGlsl() {
    std::array<float, kMirroredCast> weights;
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    std::string sum;
    for (int i = 0; i < int(kMirroredCast); ++i)
        if (const double w = double(weights[std::size_t(i)]); w != 0) addProduct(sum, w, castElement("mirrored", i));
    double norm2 = 0;
    for (const float w : weights) norm2 += double(w * w);
    std::string text =
        "// Returns the cosine-weighted visibility / pi: 0 dark, 1 open.\n"
        "float penumbra_cast_ambient(float mirrored[21]) { return clamp(" +
        sum +
        ", 0.0, 1.0); }\n// Moves the numbers the shortest way to where that lies in [0, 1].\n"
        "void penumbra_cast_clamp(inout float mirrored[21]) {\n    float e = " +
        sum + ", excess = (e - clamp(e, 0.0, 1.0)) / " + glslFloat(norm2) + ";\n";
    for (int i = 0; i < int(kMirroredCast); ++i)
        if (const double w = double(weights[std::size_t(i)]); w != 0)
            text += "    " + castElement("mirrored", i) + " -= excess * " + glslFloat(w) + ";\n";
    return text + "}\n";
}

std::string castGlsl() {
    return kCastHead + castAmbientGlsl() + "\n#ifdef PENUMBRA_SPHERE\n" + sightGlsl() + castProductGlsl() +
           exponentialGlsl() + addSphereGlsl() + castVisibilityGlsl() + castMirrorGlsl() +
           "#endif\n\n#ifdef PENUMBRA_PART\n" + castFieldsGlsl() + "#endif\n";
}

// t_i = sum_j a_j s_ij with s_ij = sum_k Gamma_ijk mirrored_k, which serves (j, i) too. `a` are the numbers without
// what stands below the horizon (docs/formulas.md, section 8).
std::string castCoefficientsGlsl(const Convention& convention) {
    const bool is_mirrored = convention.below == BelowHorizon::kMirrored;
    std::vector<double> below(std::size_t(convention.size()));
    if (convention.below == BelowHorizon::kOpen) belowHorizonCoefficients(convention.order, below);
    std::map<std::pair<int, int>, std::string> sums;
    for (const TripleProductEntry& e : tripleProduct(convention.order, convention.order, kFieldOrder)) {
        const int i = is_mirrored ? mirroredPlace(e.i) : e.i, j = is_mirrored ? mirroredPlace(e.j) : e.j;
        const int k = mirroredPlace(e.k);
        if (i >= 0 && j >= i && k >= 0) addProduct(sums[{i, j}], e.value, castElement("mirrored", k));
    }
    const std::string size = std::to_string(convention.size());
    std::string text =
        "\n// Multiplies the numbers of a vertex by what others leave visible there, in the local frame of both.\n"
        "void penumbra_cast_coefficients(inout vec4 numbers[PENUMBRA_STRIDE4], float mirrored[21]) {\n    float a[" +
        size + "], t[" + size + "], s;\n    penumbra_cast_clamp(mirrored);\n";
    for (int i = 0; i < convention.size(); ++i) {
        const double open = below[std::size_t(i)];
        text += "    " + castElement("a", i) + " = " + vectorElement(i) + (open != 0 ? " - " + glslFloat(open) : "") +
                ";\n    " + castElement("t", i) + " = " + glslFloat(open) + ";\n";
    }
    for (const auto& [pair, sum] : sums) {
        const auto [i, j] = pair;
        text += "    s = " + sum + ";\n    " + castElement("t", i) + " += s * " + castElement("a", j) + ";\n";
        if (i != j) text += "    " + castElement("t", j) + " += s * " + castElement("a", i) + ";\n";
    }
    for (int i = 0; i < convention.size(); ++i) text += "    " + vectorElement(i) + " = " + castElement("t", i) + ";\n";
    return text + "    penumbra_clamp_ambient(numbers);\n}\n";
}

std::vector<float> capLogTexels() {
    std::vector<float> texels;
    for (const auto& row : capLogTable(kCastOrder).rows) texels.insert(texels.end(), row.begin(), row.end());
    return texels;
}

}  // namespace penumbra
