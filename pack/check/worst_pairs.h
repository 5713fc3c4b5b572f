#pragma once
// Finds the places where E of an asset is most wrong, over bakes that are larger than memory.
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/mesh.h"

namespace penumbra {

// E of one vertex in one frame of a bake.
struct PlaceError {
    std::size_t frame = 0;     // index in the bake
    std::uint32_t vertex = 0;  // index in the asset
    float e_model = 0, e_truth = 0;

    float size() const { return std::abs(e_model - e_truth); }
};

// One fault shows in many vertices and many frames. So of the pairs that lie within a neighbourhood of one another at
// rest, and in a run of frames of one clip, only the worst counts, and few count of a neighbourhood in all.
struct PlaceSpread {
    std::size_t count = 100;            // pairs that are wanted
    float distance = 0.03f;             // size of a neighbourhood, in diagonals of the rest positions
    double seconds = 0.25;              // half the length of a run of frames
    std::size_t per_neighbourhood = 3;  // in all clips
};

// Collects pairs while a check goes through the frames. It keeps 1,024 times as many as are wanted at most, the worst
// ones; so it may find fewer than are wanted where nearly all errors lie in few neighbourhoods.
class WorstPairs {
public:
    // `frames` are those of the bake and must outlive this.
    WorstPairs(const AssetView& asset, const FrameList& frames, const PlaceSpread& spread);

    // E of the first vertices of the asset in one frame, as many as the bake has.
    void addFrame(std::size_t frame, std::span<const float> e_model, std::span<const float> e_truth);
    // Returns the chosen pairs, the worst one first.
    std::vector<PlaceError> chosen() const;

private:
    const FrameList& frames_;
    PlaceSpread spread_;
    std::span<const Vec3> rest_;
    float distance_ = 0;                            // radius of a neighbourhood, in the space of the rest positions
    std::vector<std::uint32_t> cell_of_vertex_;     // cubes as large as a neighbourhood
    std::vector<PlaceError> candidates_, of_cell_;  // of_cell_: the worst pair of each cell in one frame

    bool nearby(const PlaceError& a, const PlaceError& b) const;
};

}  // namespace penumbra
