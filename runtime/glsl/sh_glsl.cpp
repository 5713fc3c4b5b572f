#include "runtime/glsl/sh_glsl.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "sh/sh_basis.h"

namespace penumbra {

std::string glslFloat(double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.9g", value);
    std::string literal = text.data();
    if (literal.find_first_of(".e") == std::string::npos) literal += ".0";
    return value < 0 ? "(" + literal + ")" : literal;
}

namespace {

// Returns N(l,m) of y_lm = N P_l^|m|: sqrt((2l+1)/4pi (l-m)!/(l+m)!), times sqrt 2 for m > 0.
double normalization(int band, int m) {
    double ratio = 1;
    for (int i = band - m + 1; i <= band + m; ++i) ratio /= i;
    return std::sqrt((2 * band + 1) / (4 * std::numbers::pi) * ratio * (m > 0 ? 2 : 1));
}

}  // namespace

std::string basisGlsl(int order, BasisPart part, std::string_view prefix, std::string_view direction) {
    const std::string p(prefix), d(direction);
    std::string text;
    // Computes P_l^m / sin^m with the Condon-Shortley sign by the recurrence in l, and C_m + i S_m = (x + iy)^m.
    for (int m = 0; m < order; ++m) {
        const std::string c = p + "C" + std::to_string(m), s = p + "S" + std::to_string(m);
        if (m > 0) {
            const std::string c1 = p + "C" + std::to_string(m - 1), s1 = p + "S" + std::to_string(m - 1);
            text += "    float " + c + " = " + d + ".x * " + c1 + " - " + d + ".y * " + s1 + ", " + s + " = " + d +
                    ".y * " + c1 + " + " + d + ".x * " + s1 + ";\n";
        } else {
            text += "    float " + c + " = 1.0, " + s + " = 0.0;\n";
        }
        double diagonal = m % 2 ? -1 : 1;  // (-1)^m (2m-1)!!
        for (int i = 2 * m - 1; i > 1; i -= 2) diagonal *= i;
        const auto legendre = [&](int band) { return p + "P" + std::to_string(band) + "_" + std::to_string(m); };
        for (int band = m; band < order; ++band) {
            text += "    float " + legendre(band) + " = ";
            if (band == m)
                text += glslFloat(diagonal);
            else if (band == m + 1)
                text += glslFloat(2 * m + 1) + " * " + d + ".z * " + legendre(m);
            else
                text += glslFloat(double(2 * band - 1) / (band - m)) + " * " + d + ".z * " + legendre(band - 1) +
                        " - " + glslFloat(double(band + m - 1) / (band - m)) + " * " + legendre(band - 2);
            text += ";\n";
            if (part == BasisPart::kEven && (band + m) % 2) continue;
            const std::string scaled = glslFloat(normalization(band, m)) + " * " + legendre(band) + " * ";
            text += "    float " + p + std::to_string(shIndex(band, m)) + " = " + scaled + c + ";\n";
            if (m > 0) text += "    float " + p + std::to_string(shIndex(band, -m)) + " = " + scaled + s + ";\n";
        }
    }
    return text;
}

}  // namespace penumbra
