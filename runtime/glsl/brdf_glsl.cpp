// Evaluates BRDF lobes in single precision.
//
// Problem: a lobe of exponent 1e5 or width 0.01 hangs on 1 - cos^2 of an angle near zero, where cos^2 has no digits
// left.
//
// Naive: the formulas of sh/brdf/brdf.cpp as they are. Near its peak a narrow lobe then is off by some percent.
//
// Here: the squared sine comes from the horizontal parts of wi + wo, which have all their digits where they are small.
// Powers of a cosine go through log(1 - sin^2) by its series. docs/formulas.md section 3 has the formulas.

#include "runtime/glsl/brdf_glsl.h"

namespace penumbra {

namespace {

constexpr char kTerms[] = R"(
const float PENUMBRA_PI = 3.14159265358979;

// (1 - x)^(s / 2), given also 1 - x itself: a cosine to the power s where x is its squared sine.
float penumbra_cosine_power(float x, float one_minus_x, float s) {
    if (one_minus_x <= 0.0) return s > 0.0 ? 0.0 : 1.0;
    float logarithm = x < 0.02 ? -x * (1.0 + x * (0.5 + x * (1.0 / 3.0 + x * 0.25))) : log(one_minus_x);
    return exp(0.5 * s * logarithm);
}

float penumbra_schlick_between(float cosine, float f0, float f90) {
    float c = clamp(1.0 - cosine, 0.0, 1.0);
    return f0 + (f90 - f0) * (c * c * c * c * c);
}

float penumbra_schlick(float cosine, float f0) {
    return penumbra_schlick_between(cosine, f0, 1.0);
}

float penumbra_dielectric(float cosine, float ior) {
    float g = sqrt(max(ior * ior - 1.0 + cosine * cosine, 0.0));
    if (g + cosine <= 0.0) return 1.0;
    float s = (g - cosine) / (g + cosine), p = (cosine * (g + cosine) - 1.0) / (cosine * (g - cosine) + 1.0);
    return 0.5 * s * s * (1.0 + p * p);
}

float penumbra_ggx_lambda(float a2, float cosine) {
    return 0.5 * (sqrt(1.0 + a2 * (1.0 / (cosine * cosine) - 1.0)) - 1.0);
}

float penumbra_ward_lobe(vec3 h, vec2 widths) {
    vec2 slope = h.xy / (widths * h.z);
    return exp(-dot(slope, slope));
}

float penumbra_ashikhmin_diffuse(float cosine) {
    float c = 1.0 - 0.5 * cosine;
    return 1.0 - c * c * c * c * c;
}
)";

// h is wi + wo, n is h of unit length, and x the squared sine of n. The cosine between n and wi is half the length of
// h. The dot product of n and wi would lose it at grazing angles.
constexpr char kModels[] = R"(
float penumbra_oren_nayar(float sigma, vec3 wi, vec3 wo) {
    float s2 = sigma * sigma, a = 1.0 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
    return (a + b * max(0.0, dot(wi.xy, wo.xy)) / max(wi.z, wo.z)) / PENUMBRA_PI;
}

float penumbra_phong(float s, vec3 wi, vec3 wo) {
    vec3 away = wi - vec3(-wo.xy, wo.z);
    float x = 0.5 * dot(away, away), cosine = max(1.0 - x, 0.0);
    return (s + 2.0) / (2.0 * PENUMBRA_PI) * penumbra_cosine_power(x, cosine, 2.0 * s);
}

float penumbra_phong_live(float s, vec3 wi, vec3 wo) {
    vec3 away = wi - vec3(-wo.xy, wo.z);
    float x = 0.5 * dot(away, away), cosine = 1.0 - x;
    if (cosine <= 0.0) return 0.0;
    return (s + 1.0) / (2.0 * PENUMBRA_PI) * penumbra_cosine_power(x, cosine, 2.0 * s) / wi.z;
}

float penumbra_ggx_live(float alpha, vec3 wi, vec3 wo) {
    vec3 away = wi - vec3(-wo.xy, wo.z);
    float x = 0.25 * dot(away, away), a2 = alpha * alpha, base = x + a2 * (1.0 - x);
    return x < 0.5 ? a2 / (4.0 * PENUMBRA_PI * base * base) / wi.z : 0.0;
}

float penumbra_blinn_phong(float s, float x, vec3 n) {
    return (s + 2.0) * (s + 4.0) / (8.0 * PENUMBRA_PI * (s + exp2(-0.5 * s))) * penumbra_cosine_power(x, n.z * n.z, s);
}

float penumbra_ward(vec2 widths, vec3 h, vec3 wi, vec3 wo) {
    return penumbra_ward_lobe(h, widths) / (4.0 * PENUMBRA_PI * widths.x * widths.y * sqrt(wi.z * wo.z));
}

float penumbra_ward_gmd(vec2 widths, vec3 h) {
    float z2 = h.z * h.z;
    return penumbra_ward_lobe(h, widths) / (PENUMBRA_PI * widths.x * widths.y) * (dot(h, h) / z2 / z2);
}

float penumbra_ashikhmin_shirley(vec4 p, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    float exponent = (p.x * n.x * n.x + p.y * n.y * n.y) / max(x, 1e-12);
    float specular = sqrt((p.x + 1.0) * (p.y + 1.0)) / (8.0 * PENUMBRA_PI) *
                     penumbra_cosine_power(x, n.z * n.z, exponent) / (cosine * max(wi.z, wo.z)) *
                     penumbra_schlick(cosine, p.z);
    return specular + 28.0 * p.w / (23.0 * PENUMBRA_PI) * (1.0 - p.z) * penumbra_ashikhmin_diffuse(wi.z) *
                          penumbra_ashikhmin_diffuse(wo.z);
}

float penumbra_ggx_between(vec3 p, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    float a2 = p.x * p.x, base = a2 * n.z * n.z + x;
    float shadowing = 1.0 / (1.0 + penumbra_ggx_lambda(a2, wi.z) + penumbra_ggx_lambda(a2, wo.z));
    return a2 / (PENUMBRA_PI * base * base) * (shadowing / (4.0 * wi.z * wo.z)) *
           penumbra_schlick_between(cosine, p.y, p.z);
}

float penumbra_ggx(vec2 p, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    return penumbra_ggx_between(vec3(p, 1.0), x, cosine, n, wi, wo);
}

float penumbra_principled_diffuse(vec2 p, float cosine) {
    return (1.0 - penumbra_schlick_between(cosine, p.x, p.y)) / PENUMBRA_PI;
}

float penumbra_ggx_f0(float roughness, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    return penumbra_ggx_between(vec3(roughness * roughness, 1.0, 0.0), x, cosine, n, wi, wo);
}

float penumbra_ggx_f90(float roughness, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    return penumbra_ggx_between(vec3(roughness * roughness, 0.0, 1.0), x, cosine, n, wi, wo);
}

float penumbra_cook_torrance(vec2 p, float x, float cosine, vec3 n, vec3 wi, vec3 wo) {
    float m2 = p.x * p.x, h2 = n.z * n.z;
    float lobe = exp(-x / (h2 * m2));
    if (lobe == 0.0) return 0.0;
    float shadowing = min(1.0, 2.0 * n.z * min(wi.z, wo.z) / cosine);
    return lobe / (PENUMBRA_PI * m2 * h2 * h2) * (shadowing / (4.0 * wi.z * wo.z)) * penumbra_dielectric(cosine, p.y);
}
)";

constexpr char kLobe[] = R"(
vec3 penumbra_brdf_lobe(int model, vec4 parameters, vec3 color, vec3 wi, vec3 wo) {
    if (!(wi.z > 0.0 && wo.z > 0.0)) return vec3(0.0);
    // So low above the horizon the cosine leaves nothing to see, and its inverse square would overflow.
    wi.z = max(wi.z, 1e-9);
    wo.z = max(wo.z, 1e-9);
    vec3 h = wi + wo, n = h * inversesqrt(dot(h, h));
    float x = dot(n.xy, n.xy), cosine = 0.5 * length(h), f = 0.0;
    switch (model) {
        case PENUMBRA_LAMBERT: f = 1.0 / PENUMBRA_PI; break;
        case PENUMBRA_OREN_NAYAR: f = penumbra_oren_nayar(parameters.x, wi, wo); break;
        case PENUMBRA_PHONG: f = penumbra_phong(parameters.x, wi, wo); break;
        case PENUMBRA_BLINN_PHONG: f = penumbra_blinn_phong(parameters.x, x, n); break;
        case PENUMBRA_WARD: f = penumbra_ward(parameters.xy, h, wi, wo); break;
        case PENUMBRA_WARD_GMD: f = penumbra_ward_gmd(parameters.xy, h); break;
        case PENUMBRA_ASHIKHMIN_SHIRLEY: f = penumbra_ashikhmin_shirley(parameters, x, cosine, n, wi, wo); break;
        case PENUMBRA_GGX: f = penumbra_ggx(parameters.xy, x, cosine, n, wi, wo); break;
        case PENUMBRA_COOK_TORRANCE: f = penumbra_cook_torrance(parameters.xy, x, cosine, n, wi, wo); break;
        case PENUMBRA_PHONG_LIVE: f = penumbra_phong_live(parameters.x, wi, wo); break;
        case PENUMBRA_GGX_LIVE: f = penumbra_ggx_live(parameters.x, wi, wo); break;
        case PENUMBRA_PRINCIPLED_DIFFUSE: f = penumbra_principled_diffuse(parameters.xy, cosine); break;
        case PENUMBRA_GGX_F0: f = penumbra_ggx_f0(parameters.x, x, cosine, n, wi, wo); break;
        case PENUMBRA_GGX_F90: f = penumbra_ggx_f90(parameters.x, x, cosine, n, wi, wo); break;
        default: break;
    }
    return color * f;
}

vec3 penumbra_mirror_reflectance(int model, vec4 parameters, vec3 color, vec3 wo) {
    if (model != PENUMBRA_MIRROR || !(wo.z > 0.0)) return vec3(0.0);
    return color * penumbra_schlick(wo.z, parameters.x);
}
)";

// PENUMBRA_OREN_NAYAR from oren-nayar.
std::string constantOf(const char* name) {
    std::string text = "PENUMBRA_";
    for (const char* c = name; *c; ++c) text += *c == '-' ? '_' : *c < 'a' ? *c : char(*c - 'a' + 'A');
    return text;
}

}  // namespace

std::string brdfGlsl(BrdfModels models) {
    std::string text, lobe = kLobe;
    for (int model = 0; model < kBrdfModels; ++model) {
        const std::string name = constantOf(nameOf(BrdfModel(model)));
        text += "const int " + name + " = " + std::to_string(model) + ";\n";
        const std::size_t line = lobe.find("        case " + name + ":");
        if (!(models >> model & 1) && line != std::string::npos) lobe.erase(line, lobe.find('\n', line) + 1 - line);
    }
    return text + kTerms + kModels + lobe;
}

}  // namespace penumbra
