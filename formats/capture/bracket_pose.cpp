#include "formats/capture/bracket_pose.h"

#include <algorithm>
#include <stdexcept>

#include "formats/capture/tag_edges.h"
#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr float kDarkPaper = 40;  // code

// Returns the tag in one picture, as a list of none or one.
std::vector<DetectedTag> findTag(const TexturePicture& picture, const CameraResponse& response, const TagChoice& tag) {
    if (float(*std::ranges::max_element(picture.rgb)) < kDarkPaper) return {};
    TagDetector detector(std::span(&tag.family, 1));
    std::vector<DetectedTag> found = detector.detect(picture, response);
    std::erase_if(found, [&](const DetectedTag& one) { return one.id != tag.id; });
    return found;
}

std::string nameOfTag(const TagChoice& tag) { return std::string(nameOf(tag.family)) + ":" + std::to_string(tag.id); }

}  // namespace

BracketPose poseOfBracket(std::span<const TexturePicture> pictures, const PinholeCamera& camera,
                          const CameraResponse& response, const TagChoice& tag, int threads) {
    std::vector<std::vector<DetectedTag>> found(pictures.size());
    parallelFor(pictures.size(), threads, [&](std::size_t i) { found[i] = findTag(pictures[i], response, tag); });
    std::vector<SeenPoint> good, clipped;
    for (const std::vector<DetectedTag>& tags : found) {
        if (tags.empty()) continue;
        if (tags.size() > 1) throw std::invalid_argument("a picture shows two tags " + nameOfTag(tag));
        const float code = tags[0].paper_code;
        std::vector<SeenPoint>& list = code > float(kMaxCode) ? clipped : good;
        if (code < kDarkPaper) continue;
        const std::vector<SeenPoint> corners = seenCorners(tags[0], tag.side);
        list.insert(list.end(), corners.begin(), corners.end());
    }
    const std::vector<SeenPoint>& taken = good.empty() ? clipped : good;
    if (taken.empty()) throw std::invalid_argument("no picture shows the tag " + nameOfTag(tag));
    const std::optional<PoseEstimate> estimate = estimatePose(camera, taken);
    if (!estimate) throw std::invalid_argument("the corners of the tag " + nameOfTag(tag) + " fit no pose");
    return {*estimate, int(taken.size() / 4), good.empty()};
}

BracketPose refineByEdges(const RadiancePicture& picture, const PinholeCamera& camera, const TagChoice& tag,
                          const BracketPose& first) {
    BracketPose best = first;
    for (int pass = 0; pass < 2; ++pass) {
        const std::optional<std::vector<SeenPoint>> corners =
            cornersByEdges({picture, camera, best.estimate.pose}, paperOf(tag));
        if (!corners) return best;
        const std::optional<PoseEstimate> estimate = estimatePose(camera, *corners);
        if (!estimate) return best;
        best.estimate = *estimate;
    }
    return best;
}

PaperTag paperOf(const TagChoice& tag) {
    const int modules = tag.family == TagFamily::k36h11 ? 8 : tag.family == TagFamily::k25h9 ? 7 : 6;
    return {tag.side, modules};
}

}  // namespace penumbra
