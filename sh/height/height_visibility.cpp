#include "sh/height/height_visibility.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/mirrored_product.h"
#include "sh/sh_rotation.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

std::vector<int> evenIndicesOf(int order) { return Convention{BelowHorizon::kMirrored, order}.indices(); }

}  // namespace

HeightTables::HeightTables(const HeightField& field, int order, int mirrored, const HeightPath& path)
    : order_(order),
      size_(std::size_t(mirroredCount(mirrored))),
      path_(&path),
      taps_(horizonTaps(field)),
      ambient_(size_) {
    assert(order >= kMinHeightOrder && order <= kMaxHeightOrder);
    makeTaps(field);
    makeMirror(mirrored);
    ambientWeights({BelowHorizon::kMirrored, mirrored}, ambient_);
    for (const float w : ambient_) ambient_norm2_ += w * w;
}

void HeightTables::makeTaps(const HeightField& field) {
    for (const HorizonTap& tap : taps_.taps) {
        const HeightLevel& level = field.levels()[std::size_t(tap.level)];
        const float scale = std::ldexp(1.0f, -tap.level);
        tap_list_.push_back({tap.row, tap.column, tap.per_metre, scale, 0.5f * scale - 0.5f, float(level.rows - 1),
                             float(level.columns - 1), level.columns, std::int32_t(level.first)});
    }
    for (int a = 0; a < kHorizonAzimuths; ++a)
        for (int m = 0; m < order_; ++m) {
            const double phi = horizonAzimuth(a, kHorizonAzimuths), share = 2 * std::numbers::pi / kHorizonAzimuths;
            turns_.push_back(float(share * std::cos(m * phi)));
            turns_.push_back(float(share * std::sin(m * phi)));
        }
    for (int l = 0; l < order_; ++l)
        for (int m = 0; m <= l; ++m) {
            double factorials = 1;
            for (int k = l - m + 1; k <= l + m; ++k) factorials /= k;
            norms_.push_back(float((m > 0 ? std::numbers::sqrt2 : 1) *
                                   std::sqrt((2 * l + 1) / (4 * std::numbers::pi) * factorials)));
        }
}

void HeightTables::makeMirror(int mirrored) {
    const std::size_t n = std::size_t(coefficientCount(order_));
    const Mat3d quarter{{1, 0, 0, 0, 0, -1, 0, 1, 0}};  // y to z
    const ShRotationD there = makeShRotation(order_, quarter), back = makeShRotation(order_, transposed(quarter));
    const std::vector<int> even = evenIndicesOf(mirrored);
    std::vector<double> one(n), turned(n);
    std::vector<float> full(std::size_t(coefficientCount(mirrored))), coefficients(size_);
    const auto mirrorOf = [&](std::span<const double> f) {
        std::ranges::fill(full, 0.0f);
        for (std::size_t i = 0; i < std::min(f.size(), full.size()); ++i) full[i] = float(f[i]);
        mirrorAtHorizon(mirrored, full, coefficients);
    };
    for (std::size_t from = 0; from < n; ++from) {
        std::ranges::fill(one, 0.0);
        one[from] = 1;
        apply(there, one, turned);
        for (std::size_t to = 0; to < n; ++to)
            if (std::abs(turned[to]) > 1e-12)
                quarter_.push_back({std::uint16_t(to), std::uint16_t(from), float(turned[to])});
        apply(back, one, turned);
        mirrorOf(turned);
        for (std::size_t to = 0; to < size_; ++to)
            if (std::abs(coefficients[to]) > 1e-7f)
                mirror_.push_back({std::uint16_t(to), std::uint16_t(from), coefficients[to]});
    }
    belowHorizonCoefficients(order_, one);
    mirrorOf(one);
    below_ = coefficients;
    const auto by_target = [](const HeightTurn& a, const HeightTurn& b) { return a.to < b.to; };
    std::ranges::stable_sort(quarter_, by_target);
    std::ranges::stable_sort(mirror_, by_target);
    for (int m = 1; m < mirrored; ++m)
        for (int l = m; l < mirrored; l += 2) {
            const auto place = [&](int index) { return std::uint16_t(std::ranges::find(even, index) - even.begin()); };
            pairs_.push_back({std::uint16_t(m), place(shIndex(l, m)), place(shIndex(l, -m))});
        }
}

HeightScene HeightTables::sceneOf(const HeightField& field) const {
    const HeightGrid& grid = field.grid();
    return {field.allHeights(),
            float(grid.rows),
            float(grid.columns),
            grid.border == HeightBorder::kPeriodic,
            grid.border == HeightBorder::kOpen,
            leastHorizon(grid.border),
            order_,
            kHorizonAzimuths,
            tap_list_.data(),
            taps_.count,
            turns_.data(),
            norms_.data()};
}

HeightMirror HeightTables::mirrorOf(HeightReceiver receiver) const {
    return {order_,          int(size_),      quarter_.data(),
            mirror_.data(),  quarter_.size(), mirror_.size(),
            pairs_.data(),   pairs_.size(),   receiver == HeightReceiver::kOnField ? below_.data() : nullptr,
            ambient_.data(), ambient_norm2_};
}

void HeightTables::visibility(const HeightField& field, const HeightPoints& points, std::size_t stride,
                              std::span<float> out) const {
    assert(out.size() >= points.count * stride);
    path_->visibility(sceneOf(field), points, stride, out.data());
}

void HeightTables::mirror(std::span<const float> rows, std::size_t row_stride, const HeightFrames& frames,
                          HeightReceiver receiver, std::size_t stride, std::span<float> out) const {
    path_->mirror(mirrorOf(receiver), frames, rows.data(), row_stride, rows.size() / row_stride, stride, out.data());
}

HeightVisibility::HeightVisibility(const HeightField& field, int order, int step, const HeightPath& path)
    : tables_(field, order, order, path), receivers_(field.grid(), step), row_size_(order == 4 ? 16 : 32) {
    rows_.resize(receiverCount() * row_size_);
    normals_.resize(receiverCount());
}

void HeightVisibility::evaluate(const HeightField& field, std::size_t first, std::size_t end) {
    constexpr std::size_t kBatch = 64;
    std::array<float, kBatch> rows, columns, heights;
    std::array<std::size_t, kBatch> receivers;
    std::array<float, kBatch * 32> out{};  // padding stays 0
    std::size_t count = 0;
    const auto flush = [&] {
        tables_.visibility(field, {rows.data(), columns.data(), heights.data(), count}, row_size_, out);
        for (std::size_t i = 0; i < count; ++i) {
            const auto row = std::span(out).subspan(i * row_size_, row_size_);
            const auto old = std::span(rows_).subspan(receivers[i] * row_size_, row_size_);
            if (!std::ranges::equal(row, old)) receivers_.noteChange(receivers[i]);
            std::ranges::copy(row, old.begin());
        }
        count = 0;
    };
    for (std::size_t r = first; r < end; ++r)
        for (std::size_t c = 0; c < receivers_.columns(); ++c) {
            const std::size_t receiver = r * receivers_.columns() + c;
            if (!receivers_.takeAwake(receiver)) continue;
            const int row = receivers_.lines(0)[r], column = receivers_.lines(1)[c];
            normals_[receiver] = field.normal(row, column);
            rows[count] = float(row);
            columns[count] = float(column);
            heights[count] =
                field.heights()[std::size_t(row) * std::size_t(field.grid().columns) + std::size_t(column)];
            receivers[count++] = receiver;
            if (count == kBatch) flush();
        }
    if (count > 0) flush();
}

namespace {

constexpr std::size_t kMax = HeightVisibility::kMaxPoints;

// Numbers of the points of a row, which the compiler turns into vectors.
struct RowCoefficients {
    std::array<float, kMax> x, y, z;
};

// The frames of points of a row; tangents are tangentOf(normal, {1, 0, 0}).
void framesOf(const HeightField& field, int row, int first, std::span<Vec3> normals, std::span<Vec3> tangents,
              RowCoefficients& n) {
    const HeightGrid& grid = field.grid();
    const std::size_t count = normals.size();
    const bool wraps = grid.border == HeightBorder::kPeriodic;
    const auto line = [&](int r) {
        r = wraps ? (r + grid.rows) % grid.rows : std::clamp(r, 0, grid.rows - 1);
        return field.heights().data() + std::size_t(r) * std::size_t(grid.columns) + std::size_t(first);
    };
    const float *const up = line(row - 1), *const here = line(row), *const down = line(row + 1);
    const bool whole = wraps || (row > 0 && row + 1 < grid.rows);
    const float per_x = (whole ? 0.5f : 1.0f) / grid.cell_x, per_y = 0.5f / grid.cell_y;
    std::array<float, kMax> slope_x, slope_y;
    for (std::size_t i = 0; i < count; ++i) slope_x[i] = (down[i] - up[i]) * per_x;
    // Neighbours of the first and the last column lie beyond the border.
    const std::size_t begin = first == 0 ? 1 : 0, end = first + int(count) == grid.columns ? count - 1 : count;
    for (std::size_t i = begin; i < end; ++i) slope_y[i] = (here[i + 1] - *(here + i - 1)) * per_y;
    for (const std::size_t i : {std::size_t(0), count - 1}) {
        if (i >= begin && i < end) continue;
        const Vec3 normal = field.normal(row, first + int(i));
        slope_y[i] = -normal.y / normal.z;
    }
    std::array<float, kMax> across, per;
    for (std::size_t i = 0; i < count; ++i) {
        const float scale = 1 / std::sqrt(1 + slope_x[i] * slope_x[i] + slope_y[i] * slope_y[i]);
        n.x[i] = -slope_x[i] * scale;
        n.y[i] = -slope_y[i] * scale;
        n.z[i] = scale;
        across[i] = 1 - n.x[i] * n.x[i];
        per[i] = 1 / std::sqrt(std::max(across[i], 1e-4f));
    }
    for (std::size_t i = 0; i < count; ++i) {
        normals[i] = {n.x[i], n.y[i], n.z[i]};
        tangents[i] = across[i] > 1e-4f ? Vec3{across[i] * per[i], -n.x[i] * n.y[i] * per[i], -n.x[i] * n.z[i] * per[i]}
                                        : tangentOf(normals[i], {1, 0, 0});
    }
}

}  // namespace

void HeightVisibility::coefficients(const HeightField& field, int row, int first_column, std::span<Vec3> normals,
                                    std::span<Vec3> tangents, std::size_t stride, std::span<float> coefficients,
                                    const HeightRefined* refined) const {
    assert(normals.size() <= kMaxPoints && !normals.empty());
    const std::size_t count = normals.size(), columns = receivers_.columns();
    RowCoefficients n;
    framesOf(field, row, first_column, normals, tangents, n);
    std::size_t r[2];
    float down;
    receivers_.around(0, row, r[0], r[1], down);
    std::array<HeightBlend, kMaxPoints> blends;
    std::array<std::array<float, kMaxPoints>, 4> weights;
    std::array<RowCoefficients, 4> corner;
    for (std::size_t p = 0; p < count; ++p) {
        std::size_t c[2];
        float right;
        receivers_.around(1, first_column + int(p), c[0], c[1], right);
        for (std::size_t k = 0; k < 4; ++k) {
            const std::size_t receiver = r[k / 2] * columns + c[k % 2];
            const Vec3 normal = normals_[receiver];
            corner[k].x[p] = normal.x, corner[k].y[p] = normal.y, corner[k].z[p] = normal.z;
            weights[k][p] = (k / 2 ? down : 1 - down) * (k % 2 ? right : 1 - right);
            blends[p].corners[k] = &rows_[receiver * row_size_];
        }
    }
    std::array<float, kMaxPoints> sum{};
    for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t p = 0; p < count; ++p) {
            const float x = corner[k].x[p] - n.x[p], y = corner[k].y[p] - n.y[p], z = corner[k].z[p] - n.z[p];
            weights[k][p] /= 1 + kNormalsMatter * (x * x + y * y + z * z);
            sum[p] += weights[k][p];
        }
    for (std::size_t p = 0; p < count; ++p)
        for (std::size_t k = 0; k < 4; ++k) blends[p].weights[k] = weights[k][p] / sum[p];
    std::array<float, kMaxPoints * 32> rows;
    tables_.path().blend(blends.data(), count, row_size_, rows.data());
    if (refined && refined->any)
        mixFiner(field.grid(), *refined, row, first_column, normals, std::span(rows).first(count * row_size_));
    tables_.mirror(std::span(rows).first(count * row_size_), row_size_, {normals.data(), tangents.data()},
                   HeightReceiver::kOnField, stride, coefficients);
}

}  // namespace penumbra
