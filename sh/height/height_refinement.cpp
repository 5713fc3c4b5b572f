#include "sh/height/height_refinement.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "sh/height/height_visibility.h"

namespace penumbra {

float cellError(float apart, float rough) { return 0.5f * std::sqrt((apart + 0.1f * rough) * (rough + 0.1f * apart)); }

float refinementOf(float error, float tolerance) {
    return std::clamp((error - tolerance) / (0.5f * tolerance), 0.0f, 1.0f);
}

namespace {

constexpr std::size_t kBatch = 64;

// What four corners say of a place between them.
struct Corners {
    const float* rows[4];
    Vec3 normals[4];
};

// rms over the sphere around the mean; `count` is a multiple of 8.
float apartOf(const Corners& corners, std::size_t count) {
    float sums[8] = {};
    for (std::size_t i = 0; i < count; i += 8)
        for (std::size_t k = 0; k < 8; ++k) {
            const float a = corners.rows[0][i + k], b = corners.rows[1][i + k], c = corners.rows[2][i + k],
                        d = corners.rows[3][i + k], mean = 0.25f * (a + b + c + d);
            sums[k] +=
                (a - mean) * (a - mean) + (b - mean) * (b - mean) + (c - mean) * (c - mean) + (d - mean) * (d - mean);
        }
    float sum = 0;
    for (const float s : sums) sum += s;
    return std::sqrt(sum / (16 * std::numbers::pi_v<float>));
}

}  // namespace

// A cell: its corners are the points of two rows and two columns. Beyond a periodic border stands `count` for 0.
struct HeightVisibility::Cell {
    int row[2], column[2];

    int gap(int axis) const { return axis == 0 ? row[1] - row[0] : column[1] - column[0]; }
};

HeightVisibility::Cell HeightVisibility::cellAt(const HeightGrid& grid, int row, int column, int step) const {
    const int more = grid.border == HeightBorder::kPeriodic ? 0 : 1;
    return {{row, std::min(row + step, grid.rows - more)}, {column, std::min(column + step, grid.columns - more)}};
}

HeightVisibility::Seen HeightVisibility::seenAt(const HeightGrid& grid, const HeightRefined* refined, int row,
                                                int column) const {
    // A periodic field goes on with its first line.
    const int r = row < grid.rows ? row : 0, c = column < grid.columns ? column : 0;
    const std::size_t line = receivers_.lineAt(0, r), across = receivers_.lineAt(1, c);
    if (line != HeightReceivers::kNone && across != HeightReceivers::kNone) {
        const std::size_t receiver = line * receivers_.columns() + across;
        return {&rows_[receiver * row_size_], normals_[receiver]};
    }
    const auto slot = std::size_t(refined->slot[refined->place(row, column)]);
    return {&refined->rows[slot * row_size_], refined->normals[slot]};
}

float HeightVisibility::shareOf(const HeightField& field, const HeightRefined* refined, const Cell& cell,
                                int step) const {
    const HeightGrid& grid = field.grid();
    Corners corners;
    for (std::size_t k = 0; k < 4; ++k) {
        const Seen seen = seenAt(grid, refined, cell.row[k / 2], cell.column[k % 2]);
        corners.rows[k] = seen.row;
        corners.normals[k] = seen.normal;
    }
    // The points half-way. A narrow cell at the border has fewer, or stands for a smaller one.
    int half = step / 2;
    while (half > 0 && half >= std::max(cell.gap(0), cell.gap(1))) half /= 2;
    const int middle_row = cell.row[0] + half, middle_column = cell.column[0] + half;
    const bool has_row = middle_row < cell.row[1], has_column = middle_column < cell.column[1];
    if (half == 0) return 0;
    const float down = float(half) / float(std::max(cell.gap(0), 1)),
                right = float(half) / float(std::max(cell.gap(1), 1));
    float sum = 0, count = 0;
    const auto add = [&](int row, int column, float r, float c) {
        const Vec3 upper = corners.normals[0] * (1 - c) + corners.normals[1] * c,
                   lower = corners.normals[2] * (1 - c) + corners.normals[3] * c;
        const Vec3 off =
            field.normal(row < grid.rows ? row : 0, column < grid.columns ? column : 0) - (upper * (1 - r) + lower * r);
        sum += dot(off, off);
        count += 1;
    };
    if (has_row && has_column) add(middle_row, middle_column, down, right);
    for (int side = 0; side < 2; ++side) {
        if (has_column) add(cell.row[side], middle_column, float(side), right);
        if (has_row) add(middle_row, cell.column[side], down, float(side));
    }
    return refinementOf(cellError(apartOf(corners, row_size_), std::sqrt(sum / count)), tolerance_);
}

// Lets the chosen points of a tile look for their horizons.
struct HeightVisibility::Looker {
    const HeightVisibility& visibility;
    const HeightField& field;
    HeightRefined& out;
    std::array<float, kBatch> rows, columns, heights;
    std::size_t waiting = 0;

    void want(int row, int column) {
        std::int16_t& slot = out.slot[out.place(row, column)];
        const HeightGrid& grid = field.grid();
        const int r = row < grid.rows ? row : 0, c = column < grid.columns ? column : 0;
        const HeightReceivers& receivers = visibility.receivers_;
        if (slot >= 0 ||
            (receivers.lineAt(0, r) != HeightReceivers::kNone && receivers.lineAt(1, c) != HeightReceivers::kNone))
            return;
        slot = std::int16_t(out.count);
        out.normals[out.count++] = field.normal(r, c);
        rows[waiting] = float(r);
        columns[waiting] = float(c);
        heights[waiting] = field.heights()[std::size_t(r) * std::size_t(grid.columns) + std::size_t(c)];
        if (++waiting == kBatch) look();
    }
    void look() {
        const std::size_t size = visibility.row_size_, first = (out.count - waiting) * size;
        const std::span<float> found = std::span(out.rows).subspan(first, waiting * size);
        std::ranges::fill(found, 0.0f);
        if (waiting > 0)
            visibility.tables_.visibility(field, {rows.data(), columns.data(), heights.data(), waiting}, size, found);
        waiting = 0;
    }
};

void HeightVisibility::refine(const HeightField& field, int first_row, int first_column, int end_column,
                              HeightRefined& out) const {
    const HeightGrid& grid = field.grid();
    out.any = false;
    out.count = 0;
    out.first_row = first_row, out.first_column = first_column;
    out.end_row = std::min(first_row + step(), grid.rows), out.end_column = end_column;
    if (tolerance_ <= 0) return;
    for (int c = first_column; c < end_column; c += step()) {
        const float share = shareOf(field, nullptr, cellAt(grid, first_row, c, step()), step());
        out.sharesOf(step())[out.place(first_row, c)] = share;
        out.any = out.any || share > 0;
    }
    if (!out.any) return;
    out.slot.fill(-1);
    for (int size = step(); size > 1; size /= 2) {
        lookHalfWay(field, size, out);
        if (size > 2) shareHalves(field, size, out);
    }
}

// Lets the points half-way of cells look that show something finer. The last ones are the tile's points themselves, of
// which the far edges belong to other cells.
void HeightVisibility::lookHalfWay(const HeightField& field, int size, HeightRefined& out) const {
    Looker looker{*this, field, out, {}, {}, {}};
    const int half = size / 2;
    const std::array<float, HeightRefined::kPlaces>& shares = out.sharesOf(size);
    for (int row = out.first_row; row < out.end_row; row += size)
        for (int column = out.first_column; column < out.end_column; column += size) {
            if (shares[out.place(row, column)] <= 0) continue;
            Cell cell = cellAt(field.grid(), row, column, size);
            if (half == 1)
                cell = {{row, std::min(row + 1, out.end_row - 1)}, {column, std::min(column + 1, out.end_column - 1)}};
            for (int r = row; r <= cell.row[1]; r = r < cell.row[1] ? std::min(r + half, cell.row[1]) : r + 1)
                for (int c = column; c <= cell.column[1];
                     c = c < cell.column[1] ? std::min(c + half, cell.column[1]) : c + 1)
                    looker.want(r, c);
        }
    looker.look();
}

void HeightVisibility::shareHalves(const HeightField& field, int size, HeightRefined& out) const {
    const int half = size / 2;
    const std::array<float, HeightRefined::kPlaces>& whole = out.sharesOf(size);
    std::array<float, HeightRefined::kPlaces>& shares = out.sharesOf(half);
    for (int row = out.first_row; row < out.end_row; row += half)
        for (int column = out.first_column; column < out.end_column; column += half) {
            const int parent_row = row - (row - out.first_row) % size,
                      parent_column = column - (column - out.first_column) % size;
            const bool finer = whole[out.place(parent_row, parent_column)] > 0;
            shares[out.place(row, column)] =
                finer ? shareOf(field, &out, cellAt(field.grid(), row, column, half), half) : 0;
        }
}

// Takes what finer receivers see into the rows [normals, row_size] of a part of a row of the tile.
void HeightVisibility::mixFiner(const HeightGrid& grid, const HeightRefined& refined, int row, int first_column,
                                std::span<const Vec3> normals, std::span<float> rows) const {
    for (std::size_t p = 0; p < normals.size(); ++p) {
        const int column = first_column + int(p);
        const auto startOf = [](int at, int first, int size) { return at - (at - first) % size; };
        const auto cellShare = [&](int size) {
            return refined.sharesOf(size)[refined.place(startOf(row, refined.first_row, size),
                                                        startOf(column, refined.first_column, size))];
        };
        float left = cellShare(step());  // of the sum, for what is finer
        if (left <= 0) continue;
        const std::span<float> sum = rows.subspan(p * row_size_, row_size_);
        for (float& x : sum) x *= 1 - left;
        const auto add = [&](const float* from, float weight) {
            for (std::size_t i = 0; i < row_size_; ++i) sum[i] += weight * from[i];
        };
        for (int size = step() / 2; left > 0; size /= 2) {
            if (size == 1) {
                add(seenAt(grid, &refined, row, column).row, left);
                break;
            }
            const float finer = left * cellShare(size), here = left - finer;
            left = finer;
            if (here <= 0) continue;
            const Cell cell =
                cellAt(grid, startOf(row, refined.first_row, size), startOf(column, refined.first_column, size), size);
            const float down = float(row - cell.row[0]) / float(std::max(cell.gap(0), 1)),
                        right = float(column - cell.column[0]) / float(std::max(cell.gap(1), 1));
            Seen corners[4];
            float weights[4], all = 0;
            for (int k = 0; k < 4; ++k) {
                corners[k] = seenAt(grid, &refined, cell.row[k / 2], cell.column[k % 2]);
                const Vec3 off = corners[k].normal - normals[p];
                weights[k] =
                    (k / 2 ? down : 1 - down) * (k % 2 ? right : 1 - right) / (1 + kNormalsMatter * dot(off, off));
                all += weights[k];
            }
            for (int k = 0; k < 4; ++k) add(corners[k].row, here * weights[k] / all);
        }
    }
}

std::uint64_t HeightVisibility::finerKey(const HeightRefined& refined, int row, int column) const {
    if (!refined.any || refined.sharesOf(step())[refined.place(row, column)] <= 0) return 0;
    std::uint64_t key = 14695981039346656037u;  // FNV-1a, by words
    for (int r = 0; r <= step() && row + r <= refined.end_row; ++r)
        for (int c = 0; c <= step() && column + c <= refined.end_column; ++c) {
            // At the far edges the cell looks through every second point alone. The others are of its neighbours.
            if ((r == step() || c == step()) && (r % 2 || c % 2)) continue;
            const std::int16_t slot = refined.slot[refined.place(row + r, column + c)];
            if (slot < 0) continue;
            const float* const coefficients = &refined.rows[std::size_t(slot) * row_size_];
            for (std::size_t i = 0; i < row_size_; ++i)
                key = (key ^ std::bit_cast<std::uint32_t>(coefficients[i])) * 1099511628211u;
        }
    return key;
}

bool HeightVisibility::isStale(const HeightField& field, std::size_t row, std::size_t column) const {
    if (receivers_.isStale(row, column)) return true;
    if (tolerance_ <= 0 || !receivers_.looks(row, column)) return false;
    const int r = int(row) * step(), c = int(column) * step();
    return shareOf(field, nullptr, cellAt(field.grid(), r, c, step()), step()) > 0;
}

}  // namespace penumbra
