#pragma once
// The picture of a light, as those need it who project it and look for its suns. A large lat-long picture is read in
// bands: it is projected as it is, and kept as the means of boxes, which are fine enough for suns.
#include <functional>
#include <optional>

#include "formats/image/environment_map.h"
#include "formats/image/project_map.h"

namespace penumbra {

// From how many pixels on a picture is large (8192 x 4096 is), and how many boxes it becomes across. Several suns keep
// a list of all bright pixels, so that their picture has half as many.
struct LargePictures {
    std::int64_t from = std::int64_t(1) << 24;
    int boxes = 4096;
};

struct PictureLightChoice {
    int order = 4;                         // order of the SH that will be asked for
    int suns = 1;                          // largest number of suns that will be looked for
    std::function<void(double)> progress;  // called with the share that is read, or none
    LargePictures large = {};
};

struct PictureLight {
    EnvironmentMap map;  // the picture, or the means of its boxes
    MapShape shape;      // shape of the picture in the file
    // The projection of the file's own pixels where map has boxes or was mended (negative_radiance.h): of kFactorOrder
    // or more.
    std::optional<MapProjection> whole;

    // Returns the projection of the picture; 1 <= order, and at most the one that was chosen where `whole` is set.
    MapProjection project(int order, int threads) const;
};

// Reads one picture, or six that are the faces of a cube. Large pictures are lat-long with rows from the top, without
// negative radiance or pixels to repair; others of this size take 16 bytes a pixel. Throws what readEnvironmentMap()
// throws.
PictureLight readPictureLight(std::span<const std::filesystem::path> paths, const PictureOptions& options,
                              const PictureLightChoice& choice);

}  // namespace penumbra
