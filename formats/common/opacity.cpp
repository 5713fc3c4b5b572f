#include "formats/common/opacity.h"

#include <numeric>

namespace penumbra {

std::vector<std::uint8_t> meanOpacity(const Opacity& opacity, std::size_t triangles) {
    if (opacity.empty()) return {};
    std::vector<std::uint8_t> out(triangles, kStopsAll);
    for (std::size_t a = 0; a < opacity.triangles.size(); ++a) {
        const std::span<const std::uint8_t> values = opacity.valuesOf(a);
        const std::size_t sum = std::accumulate(values.begin(), values.end(), std::size_t(0));
        out[opacity.triangles[a]] = std::uint8_t((sum + values.size() / 2) / values.size());
    }
    return out;
}

void appendOpacity(const Opacity& more, std::size_t first_triangle, Opacity& opacity) {
    const std::size_t first_value = opacity.values.size();
    for (std::size_t a = 0; a < more.triangles.size(); ++a) {
        opacity.triangles.push_back(std::uint32_t(first_triangle + more.triangles[a]));
        opacity.pieces.push_back(more.pieces[a]);
        opacity.first.push_back(std::uint32_t(first_value + more.first[a]));
    }
    opacity.values.insert(opacity.values.end(), more.values.begin(), more.values.end());
}

Opacity opacityOf(const Opacity& opacity, std::span<const std::uint32_t> triangles) {
    Opacity out;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        const std::size_t place = opacity.find(triangles[t]);
        if (place == kUnlisted) continue;
        out.triangles.push_back(std::uint32_t(t));
        out.pieces.push_back(opacity.pieces[place]);
        out.first.push_back(opacity.first[place]);
    }
    if (!out.empty()) out.values = opacity.values;
    return out;
}

Opacity turnedOpacity(const Opacity& opacity, const std::vector<bool>& turned) {
    Opacity out = opacity;
    for (std::size_t i = 0; i < opacity.triangles.size(); ++i) {
        if (!turned[opacity.triangles[i]]) continue;
        const std::span<const std::uint8_t> values = opacity.valuesOf(i);
        const auto n = std::size_t(opacity.pieces[i]);
        const auto at = [n](std::size_t row, std::size_t column) { return n * n - (n - row) * (n - row) + 2 * column; };
        out.first[i] = std::uint32_t(out.values.size());
        for (std::size_t row = 0; row < n; ++row)
            for (std::size_t column = 0; row + column < n; ++column) {
                out.values.push_back(values[at(column, row)]);
                if (row + column + 1 < n) out.values.push_back(values[at(column, row) + 1]);
            }
    }
    return out;
}

}  // namespace penumbra
