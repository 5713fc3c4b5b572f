#include "player/scene/cast_blocks.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace penumbra {

namespace {

// rms of V over the sphere: how far the middle may be from its corners' mean, and the corners from one another.
constexpr float kMiddleOff = 0.003f, kCornersApart = 0.15f;

using Row = std::span<const float, kFarCoefficients>;

std::vector<std::uint32_t> linesOf(std::uint32_t count) {
    std::vector<std::uint32_t> lines;
    for (std::uint32_t i = 0; i + 1 < count; i += kCastBlock) lines.push_back(i);
    if (lines.empty()) lines.push_back(0);
    lines.push_back(count - 1);
    return lines;
}

// How far a vertex is from the first to the second line.
float shareOf(const CastBlock& block, int axis, std::uint32_t at) {
    return float(at - block.low[axis]) / float(std::max(block.high[axis] - block.low[axis], 1u));
}

// Keeps its room from grid to grid.
class Blocks {
public:
    std::size_t run(const CastShadow& cast, const CastGrid& grid, std::span<CastBlock> blocks, int threads) {
        grid_ = grid;
        tiles_.begin(cast, grid_, threads);
        done_.assign(grid.vertices.positions.size(), 0);
        wanted_.clear();
        evaluated_ = 0;
        for (const CastBlock& block : blocks) {
            if (!block.wanted) continue;
            for (const std::uint32_t i : {block.low[0], block.high[0]})
                for (const std::uint32_t j : {block.low[1], block.high[1]}) want(i, j);
            want(block.middle(0), block.middle(1));
        }
        evaluate();
        for (CastBlock& block : blocks) {
            if (!block.wanted) continue;
            const float hidden = mostHidden(block);
            block.seen = hidden > 0;
            block.smooth = !block.seen || isSmooth(block, hidden);
            if (block.smooth) continue;
            for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
                for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) want(i, j);
        }
        evaluate();
        for (const CastBlock& block : blocks)
            if (block.wanted && block.smooth && block.seen) interpolate(block);
        return evaluated_;
    }

private:
    CastGrid grid_;
    CastTiles tiles_;
    std::vector<std::uint8_t> done_;     // a vertex is evaluated, or about to be
    std::vector<std::uint32_t> wanted_;  // vertices
    std::size_t evaluated_ = 0;

    std::uint32_t vertex(std::uint32_t i, std::uint32_t j) const { return i * grid_.columns + j; }
    Row row(std::uint32_t i, std::uint32_t j) const {
        return Row(grid_.mirrored.data() + vertex(i, j) * kFarCoefficients, kFarCoefficients);
    }
    void want(std::uint32_t i, std::uint32_t j) {
        if (done_[vertex(i, j)] != 0) return;
        done_[vertex(i, j)] = 1;
        wanted_.push_back(vertex(i, j));
    }

    void evaluate() {
        tiles_.castOn(wanted_);
        evaluated_ += wanted_.size();
        wanted_.clear();
    }

    // How far what a corner or the middle sees is from free sight, at most.
    float mostHidden(const CastBlock& block) const {
        std::array<float, kFarCoefficients> open{};
        open[0] = kOpenSight;
        float most = castRowsApart(open, row(block.middle(0), block.middle(1)));
        for (const std::uint32_t i : {block.low[0], block.high[0]})
            for (const std::uint32_t j : {block.low[1], block.high[1]})
                most = std::max(most, castRowsApart(open, row(i, j)));
        return most;
    }

    bool isSmooth(const CastBlock& block, float hidden) const {
        const Row first = row(block.low[0], block.low[1]);
        for (const Row other :
             {row(block.low[0], block.high[1]), row(block.high[0], block.low[1]), row(block.high[0], block.high[1])})
            if (castRowsApart(first, other) > kCornersApart) return false;
        const std::array<float, kFarCoefficients> expected =
            betweenCorners(grid_, block, block.middle(0), block.middle(1));
        return castRowsApart(expected, row(block.middle(0), block.middle(1))) <= kMiddleOff &&
               mostTurn(block) * hidden <= kMiddleOff;
    }

    // How far a normal is from the mean of those of the corners, at most. What is hidden turns with it.
    float mostTurn(const CastBlock& block) const {
        const std::span<const Vec3> normals = grid_.vertices.normals;
        const Vec3 a = normals[vertex(block.low[0], block.low[1])], b = normals[vertex(block.low[0], block.high[1])],
                   c = normals[vertex(block.high[0], block.low[1])], d = normals[vertex(block.high[0], block.high[1])];
        float most = 0;
        for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) {
                const float x = shareOf(block, 0, i), z = shareOf(block, 1, j);
                const Vec3 between = (a * (1 - z) + b * z) * (1 - x) + (c * (1 - z) + d * z) * x,
                           off = normals[vertex(i, j)] - between;
                most = std::max(most, dot(off, off));
            }
        return std::sqrt(most);
    }

    void interpolate(const CastBlock& block) {
        for (std::uint32_t i = block.low[0]; i <= block.high[0]; ++i)
            for (std::uint32_t j = block.low[1]; j <= block.high[1]; ++j) {
                if (done_[vertex(i, j)] != 0) continue;
                const std::array<float, kFarCoefficients> coefficients = betweenCorners(grid_, block, i, j);
                std::copy(coefficients.begin(), coefficients.end(), &grid_.mirrored[vertex(i, j) * kFarCoefficients]);
            }
    }
};

}  // namespace

std::vector<CastBlock> castBlocks(std::uint32_t rows, std::uint32_t columns) {
    const std::vector<std::uint32_t> down = linesOf(rows), right = linesOf(columns);
    std::vector<CastBlock> blocks;
    for (std::size_t i = 0; i + 1 < down.size(); ++i)
        for (std::size_t j = 0; j + 1 < right.size(); ++j)
            blocks.push_back({{down[i], right[j]}, {down[i + 1], right[j + 1]}});
    return blocks;
}

float castRowsApart(std::span<const float, kFarCoefficients> a, std::span<const float, kFarCoefficients> b) {
    float sum = 0;
    for (std::size_t n = 0; n < kFarCoefficients; ++n) sum += (a[n] - b[n]) * (a[n] - b[n]);
    return std::sqrt(sum / (4 * std::numbers::pi_v<float>));
}

std::array<float, kFarCoefficients> betweenCorners(const CastGrid& grid, const CastBlock& block, std::uint32_t row,
                                                   std::uint32_t column) {
    const float x = shareOf(block, 0, row), z = shareOf(block, 1, column);
    const auto corner = [&](std::uint32_t i, std::uint32_t j) {
        return grid.mirrored.data() + (i * grid.columns + j) * kFarCoefficients;
    };
    const float *a = corner(block.low[0], block.low[1]), *b = corner(block.low[0], block.high[1]),
                *c = corner(block.high[0], block.low[1]), *d = corner(block.high[0], block.high[1]);
    std::array<float, kFarCoefficients> out;
    for (std::size_t n = 0; n < kFarCoefficients; ++n)
        out[n] = (1 - x) * ((1 - z) * a[n] + z * b[n]) + x * ((1 - z) * c[n] + z * d[n]);
    return out;
}

std::size_t castOnBlocks(const CastShadow& cast, const CastGrid& grid, std::span<CastBlock> blocks, int threads) {
    thread_local Blocks room;  // no loop in run() comes back here: its tasks cast single tiles
    return room.run(cast, grid, blocks, threads);
}

}  // namespace penumbra
