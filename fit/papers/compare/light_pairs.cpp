#include "fit/papers/compare/light_pairs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "fit/light/light_lobes.h"
#include "fit/page/page_html.h"
#include "formats/image/image_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kColumns = 48, kRows = 24, kCell = 4, kGap = 3;  // size of a map; size of a cell, and gap between maps
constexpr int kPaperLobes = 3;

Vec3 radianceAt(const LightPair& pair, std::span<const double> sh, int column, int row) {
    const Vec3d direction = latLongDirection((column + 0.5) / kColumns, (row + 0.5) / kRows);
    std::vector<double> basis(std::size_t(coefficientCount(pair.order)));
    evalBasis(pair.order, direction, basis);
    Vec3d sum;
    for (std::size_t i = 0; i < basis.size(); ++i) sum += basis[i] * Vec3d{sh[3 * i], sh[3 * i + 1], sh[3 * i + 2]};
    return toFloat(sum);
}

Image mapOf(const LightPair& pair, std::span<const double> sh) {
    Image image{kColumns, kRows, {}, {}};
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) image.pixels.push_back(radianceAt(pair, sh, column, row));
    return image;
}

// Returns the exposure that shows the mean of the light as a middle grey.
float exposureOf(const LightPair& pair) {
    double mean = 0;
    for (std::size_t c = 0; c < 3; ++c) mean += pair.sh[c] / std::sqrt(4 * std::numbers::pi) / 3;
    return mean > 0 ? float(0.3 / mean) : 1.0f;
}

std::string cells(const Image& image, float exposure, int x) {
    const std::vector<std::uint8_t> bytes = displayedBytes(image, exposure);
    std::string out;
    for (int row = 0; row < kRows; ++row)
        for (int column = 0; column < kColumns; ++column) {
            const std::uint8_t* rgb = bytes.data() + 3 * (row * kColumns + column);
            char text[96];
            // A cell is a little wider than its place, so that no seam shows between two.
            std::snprintf(text, sizeof text, "<path fill=\"#%02x%02x%02x\" d=\"M%d %dh%d.3v%d.3h-%d.3z\"/>", rgb[0],
                          rgb[1], rgb[2], x + column * kCell, row * kCell, kCell, kCell, kCell);
            out += text;
        }
    return out;
}

}  // namespace

LightPair makeLightPair(const LightFile& light) {
    return {light.name, light.order, light.sh, fitLobes(light.order, light.sh, kPaperLobes, LobeFit::kGreedy),
            fitLobes(light.order, light.sh, kPaperLobes, LobeFit::kJoint)};
}

std::string lightPairSvg(const LightPair& pair) {
    const float exposure = exposureOf(pair);
    const int step = kColumns * kCell + kGap * kCell;
    const std::string name =
        escapeXml(pair.name) + ": SH of order " + std::to_string(pair.order) + ", 3 greedy lobes, 3 joint lobes";
    const std::string view = "viewBox=\"0 0 " + std::to_string(3 * step - kGap * kCell) + " " +
                             std::to_string(kRows * kCell) +
                             "\" shape-rendering=\"crispEdges\" role=\"img\" aria-label=\"" + name + "\"";
    return tag("figure", "",
               tag("figcaption", "", name) +
                   tag("svg", "class=\"plot\" " + view,
                       cells(mapOf(pair, pair.sh), exposure, 0) +
                           cells(mapOf(pair, lobesToSh(pair.order, pair.greedy)), exposure, step) +
                           cells(mapOf(pair, lobesToSh(pair.order, pair.joint)), exposure, 2 * step)));
}

}  // namespace penumbra
