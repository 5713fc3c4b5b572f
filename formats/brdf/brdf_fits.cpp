// Reads fits of the ABC microfacet model to measured materials (Low, Kronander, Ynnerman and Unger 2012), one
// material a row.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/number_scanner.h"
#include "formats/common/errors.h"
#include "sh/brdf/fresnel.h"

namespace penumbra {

constexpr std::string_view kHeaderLine = "material,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior";

bool looksLikeFits(std::string_view text) { return text.starts_with("material,"); }

namespace {
struct AbcFit {
    Vec3d diffuse, a;  // albedo of the diffuse part; height of the lobe
    double b = 0, c = 0, ior = 1;
};

// Evaluates f = kD / pi + D F G / (pi cos_i cos_o) with D = A / (1 + B (1 - cos theta_h))^C, G of Cook and Torrance
// 1982, and F of a dielectric.
Vec3d evalAbc(const AbcFit& fit, Vec3d wi, Vec3d wo) {
    if (wi.z <= 0 || wo.z <= 0) return {};
    const Vec3d h = normalized(wi + wo);
    const double cosine = dot(h, wi), shadowing = std::min(1.0, 2 * h.z * std::min(wi.z, wo.z) / cosine);
    const double lobe = std::pow(1 + fit.b * std::max(0.0, 1 - h.z), -fit.c);
    const double specular = lobe * shadowing * dielectricFresnel(cosine, fit.ior) / (wi.z * wo.z);
    return (fit.diffuse + fit.a * specular) / std::numbers::pi;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
    std::vector<std::string_view> parts;
    for (std::size_t end; (end = text.find(separator)) != std::string_view::npos; text.remove_prefix(end + 1))
        parts.push_back(text.substr(0, end));
    parts.push_back(text);
    return parts;
}

AbcFit parseFit(const std::vector<std::string_view>& cells, const std::string& where) {
    struct Range {
        double least, most;
    };
    constexpr std::array<Range, 3> kRanges = {{{0, 1e12}, {0, 100}, {1, 1000}}};  // B, C, ior
    const std::vector<std::string_view> columns = split(kHeaderLine, ',');
    std::array<double, 9> v{};
    for (std::size_t i = 0; i < v.size(); ++i) {
        const Range range = i < 6 ? Range{0, 1e9} : kRanges[i - 6];
        v[i] = NumberScanner(cells[i + 1], where + ": " + std::string(columns[i + 1])).number("the value");
        if (!(v[i] >= range.least && v[i] <= range.most))
            throw InvalidInput(where + ": " + std::string(columns[i + 1]) + " is " + std::string(cells[i + 1]) +
                               ", outside " + std::to_string(range.least) + ".." + std::to_string(range.most));
    }
    return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6], v[7], v[8]};
}

}  // namespace

BrdfReading decodeFits(std::string_view text, const std::string& name, const std::string& material) {
    std::string known;
    std::vector<AbcFit> found;
    std::size_t number = 0;
    for (std::string_view line : split(text, '\n')) {
        ++number;
        if (line.ends_with('\r')) line.remove_suffix(1);
        const std::string where = name + ": line " + std::to_string(number);
        if (number == 1 && line != kHeaderLine)
            throw InvalidInput(where + ": is not '" + std::string(kHeaderLine) + "'");
        if (number == 1 || line.empty()) continue;
        const std::vector<std::string_view> cells = split(line, ',');
        if (cells.size() != 10)
            throw InvalidInput(where + ": has " + std::to_string(cells.size()) + " columns instead of 10");
        const AbcFit fit = parseFit(cells, where);
        if (cells[0] == material) found.push_back(fit);
        known += (known.empty() ? "" : ", ") + std::string(cells[0]);
    }
    if (known.empty()) throw InvalidInput(name + ": has no material");
    if (material.empty()) throw BadOption("material", "must name one of the fits of " + name + ": " + known);
    if (found.empty()) throw BadOption("material", "no '" + material + "' in " + name + ": use one of " + known);
    if (found.size() > 1) throw InvalidInput(name + ": material '" + material + "' occurs twice");
    return {{name + ":" + material, BrdfSymmetry::kIsotropic,
             [fit = found[0]](Vec3d wi, Vec3d wo) { return evalAbc(fit, wi, wo); }},
            {}};
}

}  // namespace penumbra
