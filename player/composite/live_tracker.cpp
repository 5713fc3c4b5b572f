#include "player/composite/live_tracker.h"

#include <algorithm>
#include <chrono>

#include "formats/camera/tag_track.h"

namespace penumbra {

namespace {

std::vector<TagFamily> familiesOf(const std::vector<TagChoice>& tags) {
    std::vector<TagFamily> out;
    for (const TagChoice& tag : tags) out.push_back(tag.family);
    return out;
}

}  // namespace

LiveTracker::LiveTracker(const PinholeCamera& camera, std::vector<TagChoice> tags, const CameraResponse& response,
                         int threads)
    : camera_(camera),
      tags_(std::move(tags)),
      places_(tags_.size()),
      response_(response),
      detector_(familiesOf(tags_), std::max(1, threads)) {
    places_[0] = CameraPose{};
}

const TrackedPose& LiveTracker::track(const TexturePicture& picture) {
    const auto start = std::chrono::steady_clock::now();
    const TagFrame frame = chosenTags("the picture", detector_.detect(picture, response_), tags_);
    const TagPlaces found = placeTags(camera_, tags_, {&frame, 1});
    for (std::size_t k = 0; k < tags_.size(); ++k)
        if (!places_[k]) places_[k] = found[k];
    const std::optional<PoseEstimate> pose = poseInFrame(camera_, tags_, places_, frame);
    last_.seen = pose.has_value();
    last_.clipped =
        std::ranges::any_of(frame.tags, [](const DetectedTag& tag) { return tag.paper_code >= float(kMaxCode); });
    if (pose) {
        last_.pose = pose->pose;
        last_.margin = pose->margin;
        last_.residual = pose->residual;
    }
    last_.milliseconds = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    return last_;
}

}  // namespace penumbra
