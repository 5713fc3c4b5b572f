#include "formats/scene/ground_heights.h"

#include <algorithm>

#include "sh/height/field_in_scene.h"

namespace penumbra {

namespace {

std::vector<float> heightsAt(const HeightSequence& sequence, double seconds) {
    std::vector<float> heights(sequence.grid().size());
    sequence.read(seconds, heights);
    return heights;
}

}  // namespace

GroundHeights::GroundHeights(const SceneGround& ground)
    : ground_(ground),
      sequence_(ground.heights->source),
      heights_(heightsAt(sequence_, ground.heights->seconds)),
      field_(sequence_.grid(), heights_),
      seconds_(ground.heights->seconds) {}

std::span<const TexelBox> GroundHeights::pose(std::optional<double> seconds) {
    const double wanted = seconds.value_or(ground_.heights->seconds);
    if (!sequence_.moves() || wanted == seconds_) return {};
    seconds_ = wanted;
    sequence_.read(wanted, heights_);
    return field_.set(heights_);
}

Vec3 GroundHeights::point(int row, int column) const {
    const HeightGrid& grid = field_.grid();
    const float height = field_.heights()[std::size_t(row) * std::size_t(grid.columns) + std::size_t(column)];
    return toFloat({double(ground_.center.x) + (column - 0.5 * (grid.columns - 1)) * double(grid.cell_y),
                    ground_.height + double(height),
                    double(ground_.center.z) + (row - 0.5 * (grid.rows - 1)) * double(grid.cell_x)});
}

namespace {

// The points of the border, round the field.
std::vector<std::uint32_t> borderOf(const HeightGrid& grid) {
    std::vector<std::uint32_t> ring;
    const auto rows = std::uint32_t(grid.rows), columns = std::uint32_t(grid.columns);
    for (std::uint32_t c = 0; c + 1 < columns; ++c) ring.push_back(c);
    for (std::uint32_t r = 0; r + 1 < rows; ++r) ring.push_back(r * columns + columns - 1);
    for (std::uint32_t c = columns - 1; c > 0; --c) ring.push_back((rows - 1) * columns + c);
    for (std::uint32_t r = rows - 1; r > 0; --r) ring.push_back(r * columns);
    return ring;
}

}  // namespace

void GroundHeights::castingPoints(std::vector<Vec3>& points) const {
    const HeightGrid& grid = field_.grid();
    points.clear();
    for (int r = 0; r < grid.rows; ++r)
        for (int c = 0; c < grid.columns; ++c) points.push_back(point(r, c));
    const float least = std::ranges::min_element(points, {}, &Vec3::y)->y;
    for (const std::uint32_t p : borderOf(grid)) points.push_back({points[p].x, least, points[p].z});
}

Vec3 GroundHeights::normal(int row, int column) const {
    const Vec3 n = field_.normal(row, column);  // the field's x is the scene's z
    return {n.y, n.z, n.x};
}

Vec3d GroundHeights::exactCorner() const {
    const HeightGrid& grid = field_.grid();
    return {double(ground_.center.x) - 0.5 * (grid.columns - 1) * double(grid.cell_y), ground_.height,
            double(ground_.center.z) - 0.5 * (grid.rows - 1) * double(grid.cell_x)};
}

double GroundHeights::heightAt(double x, double z) const { return heightOfField(field_, exactCorner(), x, z); }

double GroundHeights::heightUnder(std::span<const Vec3> pose, const Affine& placed) const {
    return groundUnderPose(field_, exactCorner(), pose, placed);
}

std::vector<std::uint32_t> fieldTriangles(const HeightGrid& grid) {
    std::vector<std::uint32_t> out;
    const auto columns = std::uint32_t(grid.columns);
    for (std::uint32_t r = 0; r + 1 < std::uint32_t(grid.rows); ++r)
        for (std::uint32_t c = 0; c + 1 < columns; ++c) {
            const std::uint32_t a = r * columns + c, b = a + columns;
            out.insert(out.end(), {a, b, a + 1, a + 1, b, b + 1});
        }
    return out;
}

std::vector<std::uint32_t> castingTriangles(const HeightGrid& grid) {
    std::vector<std::uint32_t> out = fieldTriangles(grid);
    const std::vector<std::uint32_t> ring = borderOf(grid);
    const auto below = [&](std::size_t i) { return std::uint32_t(grid.size() + i); };
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const std::size_t next = i + 1 < ring.size() ? i + 1 : 0;
        out.insert(out.end(), {ring[i], below(i), ring[next], ring[next], below(i), below(next)});
    }
    return out;
}

float standingHeight(const SceneCharacter& one, std::span<const Vec3> pose, const Affine& placed,
                     const std::optional<SceneGround>& ground, const GroundHeights* heights) {
    if (!one.on_ground) return 0;
    return float(heights ? heights->heightUnder(pose, placed) : ground->height);
}

}  // namespace penumbra
