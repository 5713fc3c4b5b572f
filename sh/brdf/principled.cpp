#include "sh/brdf/principled.h"

#include <algorithm>
#include <array>
#include <stdexcept>

#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr double kMaxIor = 100, kMaxColor = 1e3, kMaxEmission = 1e6;

struct NumberKey {
    const char* name;
    double Principled::*member;
    double most;
};
constexpr std::array<NumberKey, 4> kNumbers = {{{"metallic", &Principled::metallic, 1},
                                                {"roughness", &Principled::roughness, 1},
                                                {"ior", &Principled::ior, kMaxIor},
                                                {"specular", &Principled::specular, 1}}};

struct ColorKey {
    const char* name;
    Vec3d Principled::*member;
    double most;
};
constexpr std::array<ColorKey, 3> kColors = {{{"color", &Principled::color, 1},
                                              {"specular-color", &Principled::specular_color, kMaxColor},
                                              {"emission", &Principled::emission, kMaxEmission}}};

BrdfSpec withRoughness(const char* model, double roughness) {
    BrdfSpec spec = parseBrdf(model);
    spec.parameters["roughness"] = std::clamp(roughness, kMinRoughness, 1.0);
    return spec;
}

double largestOf(Vec3d v) { return std::max({v.x, v.y, v.z}); }

std::string tripleText(Vec3d v) { return shortest(v.x) + "/" + shortest(v.y) + "/" + shortest(v.z); }

void setKey(const KeyValue& item, Principled& material) {
    const std::string what = std::string(kPrincipledName) + " " + std::string(item.key);
    std::string known;
    for (const ColorKey& key : kColors) {
        if (item.key == key.name) {
            material.*key.member = parseTriple(what, item.value, 0, key.most);
            return;
        }
        known += std::string(key.name) + ", ";
    }
    for (const NumberKey& key : kNumbers) {
        if (item.key == key.name) {
            material.*key.member = parseNumber(what, item.value, 0, key.most);
            return;
        }
        known += std::string(key.name) + (&key == &kNumbers.back() ? "" : ", ");
    }
    throw std::invalid_argument("BRDF principled has no '" + std::string(item.key) + "': use " + known);
}

}  // namespace

Vec3d dielectricF0(const Principled& material) {
    const double root = (1 - material.ior) / (1 + material.ior);
    Vec3d f0 = material.specular_color * (root * root);
    for (int c = 0; c < 3; ++c) f0[c] = std::min(f0[c], 1.0) * material.specular;
    return f0;
}

PrincipledSplit splitOf(const Principled& material) {
    const double m = material.metallic;
    return {material.color * (1 - m), dielectricF0(material) * (1 - m) + material.color * m,
            material.specular * (1 - m) + m};
}

BrdfSpec principledDiffuse(const Principled& material) {
    BrdfSpec spec = parseBrdf("principled-diffuse");
    spec.parameters["f0"] = largestOf(dielectricF0(material));
    spec.parameters["f90"] = material.specular;
    return spec;
}

BrdfSpec principledF0(double roughness) { return withRoughness("ggx-f0", roughness); }
BrdfSpec principledF90(double roughness) { return withRoughness("ggx-f90", roughness); }

std::vector<BrdfSpec> principledTerms(const Principled& material) {
    const PrincipledSplit split = splitOf(material);
    std::vector<BrdfSpec> terms;
    const auto add = [&](BrdfSpec part, Vec3d color) {
        part.color = color;
        if (color != Vec3d{}) terms.push_back(std::move(part));
    };
    add(principledDiffuse(material), split.diffuse);
    add(principledF0(material.roughness), split.f0);
    add(principledF90(material.roughness), {split.f90, split.f90, split.f90});
    if (terms.empty()) terms.push_back(parseBrdf("lambert:color=0"));
    return terms;
}

Principled parsePrincipled(std::string_view list) {
    Principled material;
    for (const KeyValue& item : splitKeyValues(list)) setKey(item, material);
    if (material.ior > 0 && material.ior < 1)
        throw std::invalid_argument("principled ior must be 0 or a number from 1 to " + shortest(kMaxIor) + ", not '" +
                                    shortest(material.ior) + "'");
    return material;
}

std::string toString(const Principled& material) {
    const Principled fallback;
    std::string text = std::string(kPrincipledName) + ":color=" + tripleText(material.color);
    for (const NumberKey& key : kNumbers) text += std::string(",") + key.name + "=" + shortest(material.*key.member);
    for (const ColorKey& key : kColors)
        if (key.member != &Principled::color && material.*key.member != fallback.*key.member)
            text += std::string(",") + key.name + "=" + tripleText(material.*key.member);
    return text;
}

std::string describePrincipled() {
    const Principled fallback;
    std::string text = "  " + std::string(kPrincipledName) + ":color=1/1/1 (0..1)";
    for (const NumberKey& key : kNumbers)
        text += std::string(",") + key.name + "=" + shortest(fallback.*key.member) + " (0.." + shortest(key.most) + ")";
    return text + ",specular-color=1/1/1,emission=0/0/0; glTF's material, ior 0 or from 1\n";
}

}  // namespace penumbra
