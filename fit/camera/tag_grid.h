#pragma once
// A printed grid of tags, which calibrates a camera (scripts/ar/make_tags grid).
#include <span>
#include <string>
#include <vector>

#include "formats/camera/tag_detector.h"
#include "formats/camera/tag_pose.h"

namespace penumbra {

// Tags with ids from 0, row by row from the upper left. The grid's frame has its origin in the middle of the grid, x to
// the right, y up on the paper.
struct TagGrid {
    TagFamily family = TagFamily::k36h11;
    int columns = 0, rows = 0;
    double side = 0, gap = 0;  // metres: a tag's black square, and the white between two of them
};

// Reads "FAMILY:COLUMNSxROWS:SIDE:GAP", as "36h11:6x8:0.024:0.006". Throws BadOption("tags").
TagGrid parseTagGrid(const std::string& text);

// The corners of the grid that a picture shows, without tags of other families or ids. Throws InvalidInput (without
// the picture's name) where a tag of the grid is there twice.
std::vector<SeenPoint> seenGridCorners(const TagGrid& grid, std::span<const DetectedTag> found);

}  // namespace penumbra
