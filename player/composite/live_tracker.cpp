#include "player/composite/live_tracker.h"

#include <algorithm>
#include <chrono>

#include "formats/camera/tag_track.h"
#include "formats/capture/tag_edges.h"

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

// Finds the chosen tags. Those that are there twice are left out, since nobody knows which is which; a window goes on.
TagFrame LiveTracker::tagsIn(const TexturePicture& picture) {
    std::vector<DetectedTag> found = detector_.detect(picture, response_);
    const auto isTwice = [&](const DetectedTag& tag) {
        return std::ranges::count_if(found, [&](const DetectedTag& other) {
                   return other.family == tag.family && other.id == tag.id;
               }) > 1;
    };
    std::vector<DetectedTag> once;
    std::ranges::copy_if(found, std::back_inserter(once), [&](const DetectedTag& tag) { return !isTwice(tag); });
    const auto isChosen = [&](const DetectedTag& tag) {
        return std::ranges::any_of(tags_,
                                   [&](const TagChoice& one) { return one.family == tag.family && one.id == tag.id; });
    };
    last_.twice = std::ranges::any_of(found, [&](const DetectedTag& tag) { return isChosen(tag) && isTwice(tag); });
    refineCorners(picture, camera_, response_, tags_, once);
    return chosenTags("the picture", once, tags_);
}

void LiveTracker::learnPlaces(const TagFrame& frame) {
    constexpr std::size_t kPictures = 15;
    constexpr double kMinMargin = 0.2;
    if (frame.tags.size() < 2 || together_.size() >= kPictures) return;
    for (const DetectedTag& tag : frame.tags) {
        const auto choice = std::ranges::find_if(
            tags_, [&](const TagChoice& one) { return one.family == tag.family && one.id == tag.id; });
        const auto pose = estimatePose(camera_, seenCorners(tag, choice->side));
        if (!pose || pose->margin < kMinMargin) return;
    }
    together_.push_back(frame);
    places_ = placeTags(camera_, tags_, together_);
}

const TrackedPose& LiveTracker::track(const TexturePicture& picture) {
    const auto start = std::chrono::steady_clock::now();
    const TagFrame frame = tagsIn(picture);
    learnPlaces(frame);
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
