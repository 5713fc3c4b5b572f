// Draws meshes without a graphics library: triangles seen along -z, nearest first by a depth for each pixel.
#include "fit/papers/compare/transfer_picture.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sh/hemisphere_norm.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr int kPanelHeight = 480, kMargin = 8;

// The window of a panel: pixel = (x - left) scale, (top - y) scale.
struct Window {
    float left = 0, top = 0, scale = 1;
    int width = 0, height = kPanelHeight;
};

Window windowOf(std::span<const Vec3> positions) {
    Vec3 low = positions[0], high = positions[0];
    for (const Vec3 p : positions)
        for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
    Window window;
    window.scale = float(kPanelHeight - 2 * kMargin) / std::max(high.y - low.y, 1e-6f);
    window.width = std::clamp(int((high.x - low.x) * window.scale) + 2 * kMargin, 2 * kMargin + 1, 2 * kPanelHeight);
    window.left = low.x - float(kMargin) / window.scale;
    window.top = high.y + float(kMargin) / window.scale;
    return window;
}

float edge(Vec3 a, Vec3 b, float x, float y) { return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x); }

// Draws one value a vertex into the image from column `first` on.
void drawPanel(const Mesh& mesh, std::span<const Vec3> positions, std::span<const Vec3> colors, const Window& window,
               int first, int row, Image& image) {
    std::vector<float> depth(std::size_t(window.width) * std::size_t(window.height),
                             -std::numeric_limits<float>::infinity());
    const auto place = [&](Vec3 p) {
        return Vec3{(p.x - window.left) * window.scale, (window.top - p.y) * window.scale, p.z};
    };
    for (const Triangle& t : mesh.triangles) {
        const Vec3 a = place(positions[t[0]]), b = place(positions[t[1]]), c = place(positions[t[2]]);
        const float area = edge(a, b, c.x, c.y);
        if (area == 0) continue;
        const int x0 = std::max(0, int(std::min({a.x, b.x, c.x}))),
                  x1 = std::min(window.width - 1, int(std::max({a.x, b.x, c.x}))),
                  y0 = std::max(0, int(std::min({a.y, b.y, c.y}))),
                  y1 = std::min(window.height - 1, int(std::max({a.y, b.y, c.y})));
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const float px = float(x) + 0.5f, py = float(y) + 0.5f;
                const float u = edge(b, c, px, py) / area, v = edge(c, a, px, py) / area, w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                float& nearest = depth[std::size_t(y * window.width + x)];
                const float z = u * a.z + v * b.z + w * c.z;
                if (z <= nearest) continue;
                nearest = z;
                image.pixels[std::size_t((row + y) * image.width + first + x)] =
                    colors[t[0]] * u + colors[t[1]] * v + colors[t[2]] * w;
            }
    }
}

// A light from the upper left in front, as wide as its bands allow, and a dim sky from everywhere: E is 1 facing it.
std::vector<float> lightOf(int order) {
    const Vec3d direction = normalized(Vec3d{-0.6, 0.7, 0.5});
    std::vector<double> y(std::size_t(coefficientCount(order)));
    evalBasis(order, direction, std::span(y));
    std::vector<float> light;
    for (int l = 0, i = 0; l < order; ++l)
        for (int m = -l; m <= l; ++m, ++i) {
            const double window = std::pow(std::cos(std::numbers::pi / 2 * l / order), 2);
            light.push_back(float(0.9 * std::numbers::pi * window * y[std::size_t(i)]));
        }
    light[0] += float(0.1 * std::sqrt(4 * std::numbers::pi));
    return light;
}

// Shades transfer [V, channels, n] of one channel, which is grey, or of three.
std::vector<Vec3> shaded(std::span<const float> transfer, std::span<const float> light, std::size_t channels = 1) {
    std::vector<Vec3> colors(transfer.size() / (channels * light.size()));
    for (std::size_t v = 0; v < colors.size(); ++v)
        for (std::size_t channel = 0; channel < 3; ++channel) {
            float sum = 0;
            for (std::size_t c = 0; c < light.size(); ++c)
                sum += light[c] * transfer[(channels * v + channel % channels) * light.size() + c];
            colors[v][int(channel)] = std::max(sum, 0.0f) * float(std::numbers::inv_pi);
        }
    return colors;
}

std::vector<Vec3> errors(const TransferComparison& comparison, std::span<const float> transfer) {
    const HemisphereNorm norm(comparison.options.order);
    const std::size_t n = comparison.coefficients();
    std::vector<Vec3> colors(comparison.normals.size());
    std::vector<double> difference(n);
    for (std::size_t v = 0; v < colors.size(); ++v) {
        for (std::size_t c = 0; c < n; ++c) difference[c] = double(transfer[v * n + c]) - comparison.truth[v * n + c];
        const double error = norm.squared(difference, difference, comparison.normals[v])[0];
        const float grey = std::max(0.0f, 1 - 4 * float(std::sqrt(std::max(error, 0.0)) / std::numbers::pi));
        colors[v] = {grey, grey, grey};
    }
    return colors;
}

Image whiteImage(std::size_t panels, const Window& window) {
    Image image{int(panels) * window.width, 2 * window.height, {}, {}};
    image.pixels.assign(std::size_t(image.width) * std::size_t(image.height), {1, 1, 1});
    return image;
}

}  // namespace

Image bouncesPicture(const TransferComparison& comparison, const Mesh& mesh) {
    constexpr float kGain = 3;
    const BouncesComparison& bounces = *comparison.bounces;
    const Window window = windowOf(bounces.positions);
    const std::vector<float> light = lightOf(bounces.order);
    Image image = whiteImage(bounces.runs.size() + 1, window);
    const auto draw = [&](std::size_t panel, std::span<const float> direct, std::span<const float> indirect) {
        const std::vector<Vec3> first = shaded(direct, light);
        std::vector<Vec3> second = shaded(indirect, light, 3), both;
        for (std::size_t v = 0; v < first.size(); ++v) both.push_back(first[v] + second[v]);
        for (Vec3& color : second) color = color * kGain;
        drawPanel(mesh, bounces.positions, both, window, int(panel) * window.width, 0, image);
        drawPanel(mesh, bounces.positions, second, window, int(panel) * window.width, window.height, image);
    };
    draw(0, bounces.direct, bounces.indirect);
    for (std::size_t i = 0; i < bounces.runs.size(); ++i) draw(i + 1, bounces.runs[i].direct, bounces.runs[i].indirect);
    return image;
}

Image transferPicture(const TransferComparison& comparison, const Mesh& mesh) {
    const Window window = windowOf(comparison.positions);
    const std::vector<float> light = lightOf(comparison.options.order);
    std::vector<const TransferRun*> shown;
    for (const TransferRun& run : comparison.runs)
        if (!run.pictured.empty()) shown.push_back(&run);
    Image image = whiteImage(shown.size() + 1, window);
    drawPanel(mesh, comparison.positions, shaded(comparison.truth, light), window, 0, 0, image);
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const int first = int(i + 1) * window.width;
        drawPanel(mesh, comparison.positions, shaded(shown[i]->pictured, light), window, first, 0, image);
        drawPanel(mesh, comparison.positions, errors(comparison, shown[i]->pictured), window, first, window.height,
                  image);
    }
    return image;
}

}  // namespace penumbra
