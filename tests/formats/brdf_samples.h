#pragma once
// Files of measurements as an instrument would have made them of a known BRDF.
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <numbers>
#include <string>

#include "formats/brdf/half_difference_table.h"
#include "sh/brdf/brdf.h"

namespace penumbra::samples {

inline constexpr std::size_t kMerlCells = 90 * 90 * 180, kMerlHeader = 12;
inline constexpr std::array<double, 3> kMerlScale = {1.0 / 1500, 1.15 / 1500, 1.66 / 1500};

inline void setMerl(std::string& bytes, std::size_t channel, std::size_t cell, double value) {
    std::memcpy(bytes.data() + kMerlHeader + (channel * kMerlCells + cell) * sizeof value, &value, sizeof value);
}

// Values at the cell centers; -1 below the horizon.
inline std::string merlFile(const RgbBrdf& brdf) {
    std::string bytes(kMerlHeader + 3 * kMerlCells * sizeof(double), '\0');
    const std::array<std::int32_t, 3> size = {90, 90, 180};
    std::memcpy(bytes.data(), size.data(), sizeof size);
    const double right_angle = std::numbers::pi / 2;
    for (std::size_t cell = 0; cell < kMerlCells; ++cell) {
        const double root = (double(cell / (90 * 180)) + 0.5) / 90;
        const HalfDifference angles{right_angle * root * root, right_angle * (double(cell / 180 % 90) + 0.5) / 90,
                                    std::numbers::pi * (double(cell % 180) + 0.5) / 180};
        const auto [wi, wo] = directionsOf(angles);
        const bool above = wi.z > 0 && wo.z > 0;
        const Vec3d f = above ? brdf.eval(wi, wo) : Vec3d{};
        for (std::size_t c = 0; c < 3; ++c) setMerl(bytes, c, cell, above ? f[int(c)] / kMerlScale[c] : -1);
    }
    return bytes;
}

inline Vec3d direction(double theta, double phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// Every pair of the given polar angles and azimuth differences, at three wavelengths.
inline std::string scatteredFile(const RgbBrdf& brdf, int thetas, int phis) {
    std::string text = "# a made-up paint\n3\n450 550 650\n";
    const double right_angle = std::numbers::pi / 2;
    for (int i = 0; i < thetas; ++i)
        for (int o = 0; o < thetas; ++o)
            for (int p = 0; p < phis; ++p) {
                const double ti = right_angle * (i + 0.5) / thetas, to = right_angle * (o + 0.5) / thetas,
                             phi = std::numbers::pi * p / (phis - 1);
                const Vec3d f = brdf.eval(direction(ti, 0), direction(to, phi));
                for (double number : {ti, 0.0, to, phi, f.z, f.y, f.x}) text += std::to_string(number) + " ";
                text += "\n";
            }
    return text;
}

inline std::string rgbLine(Vec3d f) {
    return std::to_string(f.x) + " " + std::to_string(f.y) + " " + std::to_string(f.z) + "\n";
}

inline std::string isotropicTable(const RgbBrdf& brdf, int thetas, int phis) {
    const std::string n = std::to_string(thetas);
    std::string text = "penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i " + n + "\ntheta_o " + n + "\nphi " +
                       std::to_string(phis) + "\n";
    const double step = std::numbers::pi / 2 / thetas;
    for (int i = 0; i < thetas; ++i)
        for (int o = 0; o < thetas; ++o)
            for (int p = 0; p < phis; ++p)
                text += rgbLine(brdf.eval(direction(step * (i + 0.5), 0),
                                          direction(step * (o + 0.5), std::numbers::pi * p / (phis - 1))));
    return text;
}

// `symmetry` is orthotropic (phi_i over a quarter turn, both ends) or general (over the whole turn).
inline std::string anisotropicTable(const RgbBrdf& brdf, const std::string& symmetry, int thetas, int phis_i,
                                    int phis_o) {
    const std::string n = std::to_string(thetas);
    std::string text = "penumbra-brdf-table 1\nsymmetry " + symmetry + "\ntheta_i " + n + "\nphi_i " +
                       std::to_string(phis_i) + "\ntheta_o " + n + "\nphi_o " + std::to_string(phis_o) + "\n";
    const double step = std::numbers::pi / 2 / thetas, step_o = 2 * std::numbers::pi / phis_o;
    const double step_i = symmetry == "general" ? 2 * std::numbers::pi / phis_i : std::numbers::pi / 2 / (phis_i - 1);
    for (int i = 0; i < thetas; ++i)
        for (int pi = 0; pi < phis_i; ++pi)
            for (int o = 0; o < thetas; ++o)
                for (int po = 0; po < phis_o; ++po)
                    text += rgbLine(
                        brdf.eval(direction(step * (i + 0.5), step_i * pi), direction(step * (o + 0.5), step_o * po)));
    return text;
}

}  // namespace penumbra::samples
