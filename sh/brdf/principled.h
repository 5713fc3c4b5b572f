#pragma once
// The material of glTF 2.0 (its appendix B, with KHR_materials_ior and KHR_materials_specular), and how it splits into
// three parts whose sum is exact, so that textures can change its colours after the light was integrated.
//
// With c = (1 - h.i)^5, S = D V the GGX lobe of alpha = roughness^2 without any Fresnel term, m = metallic and base =
// color:
//   dielectric: (1 - F_max) base / pi + F S,  F = f0_d + (f90_d - f0_d) c, F_max the same of the largest channel of
//   f0_d
//               f90_d = specular,  f0_d = min(((1 - ior) / (1 + ior))^2 specular_color, 1) specular
//   metal:      (base + (1 - base) c) S
//   material:   (1 - m) dielectric + m metal
// Everything that textures hold is in three coefficients, which do not depend on the directions:
//   f = k_d D + f0 A + f90 B
//   D = (1 - F_max) / pi    of the slot alone: principled-diffuse:f0=max of f0_d,f90=specular
//   A = S (1 - c)           of the roughness alone: ggx-f0:roughness=
//   B = S c                 of the roughness alone: ggx-f90:roughness=
//   k_d = (1 - m) base,  f0 = (1 - m) f0_d + m base,  f90 = (1 - m) specular + m
// f90 is 1 for every metalness where specular is 1. Radiance is linear in f, so the radiance of a material is k_d times
// that of D, plus f0 times that of A, plus f90 times that of B, per colour channel, under any light and visibility.
#include <string>
#include <string_view>
#include <vector>

#include "sh/brdf/brdf.h"

namespace penumbra {

constexpr std::string_view kPrincipledName = "principled";
// Lobes that are narrower than that of this roughness are shaded as if they had it.
constexpr double kMinRoughness = 0.1;

// The defaults are those of the command line. glTF's own are 1 for metallic and roughness.
struct Principled {
    Vec3d color{1, 1, 1};  // base colour, linear Rec.709, 0..1
    double metallic = 0, roughness = 0.5;
    double ior = 1.5;  // >= 1, or 0: all light is reflected
    double specular = 1;
    Vec3d specular_color{1, 1, 1};  // >= 0
    Vec3d emission{};               // radiance, >= 0

    bool operator==(const Principled&) const = default;
};

// The coefficients of the three parts.
struct PrincipledSplit {
    Vec3d diffuse, f0;
    double f90 = 1;
};

// Returns f0_d, the reflectance of the dielectric at normal incidence.
Vec3d dielectricF0(const Principled& material);
PrincipledSplit splitOf(const Principled& material);

// Return the three parts, with the colour 1. `roughness` is clamped to [kMinRoughness, 1].
BrdfSpec principledDiffuse(const Principled& material);
BrdfSpec principledF0(double roughness);
BrdfSpec principledF90(double roughness);

// Returns the material as a sum of these parts, which have their coefficients as colours. Black parts are left out; a
// material that is all black has one.
std::vector<BrdfSpec> principledTerms(const Principled& material);

// Parses "color=R/G/B,metallic=,roughness=,ior=,specular=,specular-color=R/G/B,emission=R/G/B", any of them. Throws
// std::invalid_argument as parseBrdf() does.
Principled parsePrincipled(std::string_view list);
std::string toString(const Principled& material);  // "principled:color=..": colours and emission only where not default
std::string describePrincipled();                  // one line for --help

}  // namespace penumbra
