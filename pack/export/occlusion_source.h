#pragma once
// The source from which an export takes the share of sky that each vertex sees: a bake, or the model of an asset.
#include <cstdint>
#include <memory>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/mesh.h"
#include "formats/rig/rig_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct OcclusionFrame {
    std::vector<float> ambient;  // [V] cosine-weighted visibility / pi, 0 (dark) to 1 (open)
    // [V] unit, the mean direction of what is visible, in the space of rest positions, or the normal where nothing is.
    // It moves as normals do. Only if asked for.
    std::vector<Vec3> bent;
    // [V] ambient with what reaches a vertex by reflection under a light of radiance 1 from everywhere, linear RGB.
    // Only if asked for, and where the source knows it.
    std::vector<Vec3> bounced;
};
enum class FrameParts : std::uint8_t { kAmbient, kAll };

class OcclusionSource {
public:
    virtual ~OcclusionSource() = default;
    const Mesh& mesh() const { return mesh_; }  // V points; `source_vertex` leads to them
    const std::vector<Vec3>& restNormals() const { return rest_normals_; }
    const FrameList& frames() const { return frames_; }
    virtual bool hasBounces() const = 0;
    virtual OcclusionFrame read(std::size_t frame, FrameParts parts, int threads) const = 0;

protected:
    Mesh mesh_;
    std::vector<Vec3> rest_normals_;
    FrameList frames_;
};

// Takes the frames of a bake, those of `clips` (empty: all). `reader` outlives the result. Throws BadOption for an
// unknown clip, and InvalidInput unless the file has hemisphere_visibility or diffuse_transfer.
std::unique_ptr<OcclusionSource> bakedOcclusion(const VisibilityReader& reader, const std::vector<std::string>& clips);

// Asks the model of an asset, which outlives the result, for the clips of `rig` at `rate` frames a second; without a
// rig for the asset's own frames. Throws InvalidInput for a rig of another skeleton, and Unsupported for an asset
// without a model, and for one that needs numbers which a rig does not have.
std::unique_ptr<OcclusionSource> modelOcclusion(const AssetView& asset, const Rig* rig,
                                                const std::vector<std::string>& clips, double rate);

// Takes frames at `rate` a second from those of `source`, from the first frame of each clip on. Between two frames
// values are interpolated, as players do.
std::unique_ptr<OcclusionSource> resampledOcclusion(std::unique_ptr<OcclusionSource> source, double rate);

// Tells whether the frames of each clip are equally far apart, to a thousandth of their distance.
bool hasSteadyRate(const FrameList& frames);
// Returns how many frames a second there are in all clips together; 0 where they take no time.
double meanRate(const FrameList& frames);

}  // namespace penumbra
