#include "player/composite/sun_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr int kBlock = 4;                           // pixels
constexpr float kMiddleOff = 0.01f, kEdge = 0.25f;  // shares of the sun

class SunPixels {
public:
    SunPixels(const PixelPoints& points, const SunMaps& maps)
        : points_(points),
          maps_(maps),
          rows_((points.height - 1) / kBlock + 1),
          columns_((points.width - 1) / kBlock + 1),
          corners_(std::size_t(rows_ + 1) * std::size_t(columns_ + 1)),
          fine_(std::size_t(rows_) * std::size_t(columns_)) {}

    void look(int threads) {
        parallelFor(std::size_t(rows_ + 1), threads, [&](std::size_t i) {
            for (int j = 0; j <= columns_; ++j) corners_[cornerOf(int(i), j)] = share(int(i) * kBlock, j * kBlock);
        });
        parallelFor(std::size_t(rows_), threads, [&](std::size_t i) {
            for (int j = 0; j < columns_; ++j) fine_[blockOf(int(i), j)] = isRough(int(i), j);
        });
    }

    void add(Vec3 full, int threads, std::span<Vec3> light) const {
        parallelFor(std::size_t(rows_), threads, [&](std::size_t i) {
            for (int j = 0; j < columns_; ++j) addBlock(int(i), j, full, light);
        });
    }

private:
    const PixelPoints& points_;
    const SunMaps& maps_;
    int rows_, columns_;  // numbers of blocks
    std::vector<float> corners_;
    std::vector<char> fine_;

    std::size_t cornerOf(int i, int j) const { return std::size_t(i) * std::size_t(columns_ + 1) + std::size_t(j); }
    std::size_t blockOf(int i, int j) const { return std::size_t(i) * std::size_t(columns_) + std::size_t(j); }
    // A pixel past the border has the share of the last one.
    float share(int y, int x) const {
        const std::size_t at =
            std::size_t(std::min(y, points_.height - 1)) * points_.stride + std::size_t(std::min(x, points_.width - 1));
        return points_.sees[at] ? maps_.visibility(points_.points[at], {0, 1, 0}) : 1.0f;
    }
    std::array<float, 4> cornersOf(int i, int j) const {
        return {corners_[cornerOf(i, j)], corners_[cornerOf(i, j + 1)], corners_[cornerOf(i + 1, j)],
                corners_[cornerOf(i + 1, j + 1)]};
    }
    bool isRough(int i, int j) const {
        const std::array<float, 4> c = cornersOf(i, j);
        const auto [low, high] = std::ranges::minmax(c);
        const float middle = share(i * kBlock + kBlock / 2, j * kBlock + kBlock / 2);
        return high - low > kEdge || std::abs(middle - 0.25f * (c[0] + c[1] + c[2] + c[3])) > kMiddleOff;
    }
    bool isFine(int i, int j) const {
        for (int a = std::max(i - 1, 0); a <= std::min(i + 1, rows_ - 1); ++a)
            for (int b = std::max(j - 1, 0); b <= std::min(j + 1, columns_ - 1); ++b)
                if (fine_[blockOf(a, b)]) return true;
        return false;
    }
    void addBlock(int i, int j, Vec3 full, std::span<Vec3> light) const {
        const bool fine = isFine(i, j);
        const std::array<float, 4> c = cornersOf(i, j);
        for (int y = i * kBlock; y < std::min((i + 1) * kBlock, points_.height); ++y)
            for (int x = j * kBlock; x < std::min((j + 1) * kBlock, points_.width); ++x) {
                const float down = float(y - i * kBlock) / kBlock, right = float(x - j * kBlock) / kBlock;
                const float between =
                    (c[0] * (1 - right) + c[1] * right) * (1 - down) + (c[2] * (1 - right) + c[3] * right) * down;
                light[std::size_t(y) * std::size_t(points_.width) + std::size_t(x)] +=
                    full * (fine ? share(y, x) : between);
            }
    }
};

}  // namespace

void addSun(const PixelPoints& points, const SunMaps& maps, Vec3 full, int threads, std::span<Vec3> light) {
    SunPixels pixels(points, maps);
    pixels.look(threads);
    pixels.add(full, threads, light);
}

}  // namespace penumbra
