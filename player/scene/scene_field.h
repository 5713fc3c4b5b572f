#pragma once
// A ground with heights: what its points see past itself and past casters, what it hides from characters, and how it
// looks. It is to a scene what the level ground of scene_ground.h is.
#include <memory>
#include <optional>

#include "formats/scene/ground_heights.h"
#include "player/frame/frame_values.h"
#include "runtime/cast/cast_product.h"
#include "runtime/cast/cast_shadow.h"
#include "runtime/cast/field_shadow.h"
#include "runtime/shade/lambert_material.h"
#include "runtime/shade/shading_set.h"
#include "sh/height/height_brush.h"
#include "sh/height/height_visibility.h"

namespace penumbra {

constexpr int kFieldStride = 16;  // stride of a point's numbers

enum class FieldPoints { kNew, kKept };

class SceneField {
public:
    // `heights` are the ground's.
    SceneField(const SceneGround& ground, GroundHeights heights);
    SceneField(const SceneField&) = delete;  // `coefficients` of others may point here

    // Takes the field to a time, by default its own, or changes a box of it by hand. Only what changed is looked at
    // again.
    void pose(std::optional<double> seconds) { wake(heights_.pose(seconds)); }
    void set(const TexelBox& box, std::span<const float> heights) { wake(heights_.set(box, heights)); }

    // Raises a hill at a place of the scene, or digs a pit where `rise` is below 0 (metres, strokeHeights()).
    void brush(Vec3 at, float radius, float rise);

    // The next evaluate() looks at everything again.
    void lookAgain() { visibility_.wakeAll(); }

    const GroundHeights& heights() const { return heights_; }
    Convention convention() const { return visibility_.convention(); }
    std::size_t receiverCount() const { return visibility_.receiverCount(); }
    float tolerance() const { return visibility_.tolerance(); }
    std::size_t awake() const { return visibility_.awake(); }  // receivers that will look again
    // Grows with every change of the field.
    std::uint64_t version() const { return version_; }
    // Gives for each level what has changed since the last call, for who keeps a copy of the field (GlHeights).
    std::vector<TexelBox> takeChanged();

    // Computes all points, in the scene: where they are, and what they see past the field alone, numbers of
    // convention() with kFieldStride. Sizes `points`.
    void evaluate(int threads, FrameVertices& points) { update(CastShadow({}), FieldPoints::kNew, threads, points); }
    // The same past all casters as well. With kKept, `points` are those of the last call, nobody who casts has moved
    // since, and only points that a change of the heights has reached are computed. Returns how many points were.
    std::size_t update(const CastShadow& cast, FieldPoints old, int threads, FrameVertices& points);
    // Multiplies numbers of evaluate() by what all casters leave visible.
    void castOn(const CastShadow& cast, int threads, FrameVertices& points);
    // Multiplies numbers of a model's convention by what the field leaves visible to points on it or above it, which
    // stand in the scene. Light that bounces, `indirect` [V, kIndirectStride] or empty, is multiplied by the share of a
    // white sky that is left.
    void shadow(const CastReceivers& receivers, const ModelView& model, int threads, std::span<float> coefficients,
                std::span<float> indirect = {}) const;
    // Computes the visibility that the field leaves there, mirrored at each horizon: [receivers, kFarCoefficients].
    void visibleFrom(const CastReceivers& receivers, std::span<float> mirrored) const;

private:
    GroundHeights heights_;
    HeightVisibility visibility_;
    HeightTables above_;  // tables for points above the field
    CastProduct product_;
    std::uint64_t version_ = 1;
    std::vector<TexelBox> changed_;  // changed box of each level, since takeChanged()

    std::vector<float> brushed_;
    // Squares of cells and blocks, row by row: 2 where the points are computed in this update, 1 where that depends on
    // what finer receivers see.
    std::vector<std::uint8_t> stale_;
    std::vector<std::uint64_t> finer_;  // HeightVisibility::finerKey() of every cell, as of its last update

    void wake(std::span<const TexelBox> changed);
    void findStale(FieldPoints old, int first_row);
    void updateBand(int first_row, FrameVertices& points);
    void updateTile(const HeightRefined& refined, int first, int end, FrameVertices& points) const;
    bool isStale(int row, int column) const;
    void castOnStale(const CastShadow& cast, int threads, FrameVertices& points) const;
    void castOnRow(const CastShadow& cast, int row, FrameVertices& points) const;
    void castOnBand(const CastShadow& cast, int first_row, FrameVertices& points) const;
};

// How a ground with heights looks: its material is one of `asset`, or Lambertian. Throws InvalidInput for a material
// that is not there.
class FieldLook {
public:
    FieldLook(const SceneGround& ground, const Convention& convention, const AssetView& asset, const LightView& light);

    void turnLight(const Mat3& rotation) { shader_->setLightRotation(rotation); }
    // The radiance of all points towards `eye`, with negative values as 0. Sizes `radiance`.
    void shade(const FrameVertices& points, Vec3 eye, int threads, std::vector<Vec3>& radiance) const;

private:
    std::optional<VertexShader> shader_;
};

// The same look for shaders: a set with the one material and one light.
class FieldShading {
public:
    // The light may be replaced by others of at most its order.
    FieldShading(const SceneGround& ground, const Convention& convention, const AssetView& asset,
                 const LightView& light);
    FieldShading(const FieldShading&) = delete;  // the set points to the view

    ShadingSet& set() { return *set_; }
    const ShadingSet& set() const { return *set_; }

private:
    LambertMaterial lambert_;
    AssetView view_;
    std::optional<ShadingSet> set_;
};

// The lobes of the same material, which suns need.
std::vector<BrdfLobe> fieldLobes(const SceneGround& ground, const AssetView& asset);

// E of all points.
std::vector<float> fieldAmbient(const Convention& convention, const FrameVertices& points);

}  // namespace penumbra
