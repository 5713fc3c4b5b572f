#pragma once
// The height field of a scene's ground at a time, and where it lies in the scene: its columns go along x, its rows
// along z.
#include "formats/height/height_file.h"
#include "formats/scene/scene_file.h"

namespace penumbra {

class GroundHeights {
public:
    // The ground has heights; the field is that of its own time. Throws what HeightSequence throws.
    explicit GroundHeights(const SceneGround& ground);

    // Takes the field to a time, by default its own. Returns for each level what changed (HeightField::set).
    std::span<const TexelBox> pose(std::optional<double> seconds);
    // Changes the heights of a box by hand, metres above SceneGround::height. A later pose() of a field that moves
    // undoes that.
    std::span<const TexelBox> set(const TexelBox& box, std::span<const float> heights) {
        return field_.set(box, heights);
    }

    const HeightField& field() const { return field_; }
    bool moves() const { return sequence_.moves(); }
    // A point of the field in the scene, its normal, and where height 0 of row 0 and column 0 stands.
    Vec3 point(int row, int column) const;
    // All points, then those of the border again at the least height of the field: what casts a sun's shadow, so that
    // no light comes in under the ground at its sides.
    void castingPoints(std::vector<Vec3>& points) const;
    Vec3 normal(int row, int column) const;
    Vec3d exactCorner() const;
    Vec3 corner() const { return toFloat(exactCorner()); }
    // y of the ground, on the triangles of fieldTriangles(), and of the ground under a pose (groundUnderPose()).
    double heightAt(double x, double z) const;
    double heightUnder(std::span<const Vec3> pose, const Affine& placed) const;

private:
    SceneGround ground_;
    HeightSequence sequence_;
    std::vector<float> heights_;
    HeightField field_;
    double seconds_;
};

// The mesh of a field: two triangles a square, which face up.
std::vector<std::uint32_t> fieldTriangles(const HeightGrid& grid);
// Returns the same triangles and those of the walls of GroundHeights::castingPoints().
std::vector<std::uint32_t> castingTriangles(const HeightGrid& grid);

// Returns what "on_ground" adds to the y of someone who stands at `placed`: y of the ground under the pose, whose
// points are in the frame of the asset (groundUnderPose()). 0 for who is not on the ground. `heights` is null where it
// is level.
float standingHeight(const SceneCharacter& one, std::span<const Vec3> pose, const Affine& placed,
                     const std::optional<SceneGround>& ground, const GroundHeights* heights);

}  // namespace penumbra
