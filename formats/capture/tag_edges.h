#pragma once
// Corners of a tag from the edges of its black square in a picture of radiance.
#include <optional>
#include <vector>

#include "formats/camera/tag_pose.h"
#include "formats/capture/paper_meter.h"

namespace penumbra {

// Finds the four edges near where the pose of `shot` puts them, and returns the corners where they meet. None where an
// edge is not seen: out of the picture, too small, clipped or without contrast.
//
// A pixel integrates light, and lenses and JPEG blur it evenly to both sides, so in linear light a profile across an
// edge from black B to white W has the integral of (W - v) / (W - B) that the sharp edge has. That integral tells the
// place of the edge; lines through these places, without those that lie off, meet in the corners.
std::optional<std::vector<SeenPoint>> cornersByEdges(const PosedPicture& shot, const PaperTag& tag);

// Moves the corners of tags that a detector found in a picture to where the edges say. Tags whose edges are not seen
// keep theirs.
void refineCorners(const TexturePicture& picture, const PinholeCamera& camera, const CameraResponse& response,
                   std::span<const TagChoice> chosen, std::span<DetectedTag> tags);

}  // namespace penumbra
