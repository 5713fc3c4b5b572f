#include "formats/camera/tag_track.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "sh/quaternion.h"

namespace penumbra {

namespace {

CameraPose inverse(const CameraPose& pose) { return {transposed(pose.rotation), pose.place()}; }
// Maps by `inner`, then by `outer`.
CameraPose chained(const CameraPose& outer, const CameraPose& inner) {
    return {outer.rotation * inner.rotation, outer.rotation * inner.translation + outer.translation};
}
CameraPose poseAt(const Quaternion& turn, Vec3d place) {
    const Mat3d rotation = matrixOf(turn);
    return {rotation, -(rotation * place)};
}
bool isOf(const DetectedTag& tag, const TagChoice& choice) {
    return tag.family == choice.family && tag.id == choice.id;
}

std::size_t choiceOf(const DetectedTag& tag, std::span<const TagChoice> chosen) {
    return std::size_t(std::ranges::find_if(chosen, [&](const TagChoice& one) { return isOf(tag, one); }) -
                       chosen.begin());
}

// The mean of poses that say the same: of their shifts, and of their turns about the first of them.
CameraPose meanOf(std::span<const CameraPose> poses) {
    Vec3d shift, turn;
    const Quaternion first = quaternionOf(poses.front().rotation);
    for (const CameraPose& pose : poses) {
        shift += pose.translation / double(poses.size());
        turn += rotationVector(multiply(quaternionOf(pose.rotation), conjugate(first))) / double(poses.size());
    }
    return {matrixOf(multiply(rotationOf(turn), first)), shift};
}

// Where tag `k` lies by every picture that sees it and a tag whose place is known.
std::vector<CameraPose> placesSeen(const PinholeCamera& camera, std::span<const TagChoice> chosen,
                                   const TagPlaces& places, std::span<const TagFrame> frames, std::size_t k) {
    std::vector<CameraPose> out;
    for (const TagFrame& frame : frames) {
        const auto tag = std::ranges::find_if(frame.tags, [&](const DetectedTag& one) { return isOf(one, chosen[k]); });
        if (tag == frame.tags.end()) continue;
        const auto eye = poseInFrame(camera, chosen, places, frame);
        const auto own = estimatePose(camera, seenCorners(*tag, chosen[k].side));
        if (eye && own) out.push_back(chained(inverse(eye->pose), own->pose));
    }
    return out;
}

}  // namespace

TagFrame chosenTags(const std::string& file, std::span<const DetectedTag> found, std::span<const TagChoice> chosen) {
    TagFrame out{file, {}};
    for (const DetectedTag& tag : found) {
        if (choiceOf(tag, chosen) == chosen.size()) continue;
        for (const DetectedTag& other : out.tags)
            if (other.family == tag.family && other.id == tag.id)
                throw InvalidInput(file + ": tag " + nameOf(tag.family) + ":" + std::to_string(tag.id) +
                                   " occurs twice");
        out.tags.push_back(tag);
    }
    return out;
}

TagPlaces placeTags(const PinholeCamera& camera, std::span<const TagChoice> chosen, std::span<const TagFrame> frames) {
    TagPlaces places(chosen.size());
    places[0] = CameraPose{};
    for (bool grows = true; grows;) {  // each round reaches the neighbours of those whose place is known
        grows = false;
        for (std::size_t k = 1; k < chosen.size(); ++k) {
            if (places[k]) continue;
            const std::vector<CameraPose> seen = placesSeen(camera, chosen, places, frames, k);
            if (!seen.empty()) places[k] = meanOf(seen);
            grows = grows || places[k];
        }
    }
    return places;
}

std::optional<PoseEstimate> poseInFrame(const PinholeCamera& camera, std::span<const TagChoice> chosen,
                                        const TagPlaces& places, const TagFrame& frame) {
    std::optional<PoseEstimate> best;
    std::vector<SeenPoint> points;
    for (const DetectedTag& tag : frame.tags) {
        const std::size_t k = choiceOf(tag, chosen);
        if (!places[k]) continue;
        const std::vector<SeenPoint> own = seenCorners(tag, chosen[k].side);
        std::optional<PoseEstimate> found = estimatePose(camera, own);
        for (const SeenPoint& one : own)
            points.push_back({places[k]->rotation * one.point + places[k]->translation, one.pixel});
        if (!found || (best && best->margin >= found->margin)) continue;
        found->pose = chained(found->pose, inverse(*places[k]));
        best = found;
    }
    if (!best || points.size() == 4) return best;
    const double margin = best->margin;
    best = refinePose(camera, points, best->pose);
    best->margin = margin;
    return best;
}

std::size_t fillGaps(std::vector<TrackFrame>& frames) {
    std::size_t filled = 0;
    std::optional<std::size_t> last;
    for (std::size_t i = 0; i < frames.size(); ++i) {
        if (!frames[i].pose) continue;
        const CameraPose end = *frames[i].pose;
        for (std::size_t gap = last ? *last + 1 : i; gap < i; ++gap) {
            const CameraPose& begin = *frames[*last].pose;
            const double t = double(gap - *last) / double(i - *last);
            frames[gap].pose = poseAt(slerp(quaternionOf(begin.rotation), quaternionOf(end.rotation), t),
                                      (1 - t) * begin.place() + t * end.place());
            frames[gap].filled = true;
            ++filled;
        }
        last = i;
    }
    return filled;
}

void smoothTrack(std::vector<TrackFrame>& track, double frames) {
    const auto reach = std::ptrdiff_t(std::ceil(3 * frames));
    std::vector<std::optional<CameraPose>> smooth(track.size());
    for (std::ptrdiff_t i = 0; i < std::ptrdiff_t(track.size()); ++i) {
        if (!track[std::size_t(i)].pose) continue;
        const Quaternion middle = quaternionOf(track[std::size_t(i)].pose->rotation);
        Vec3d turn, place;
        double sum = 0;
        const auto add = [&](std::ptrdiff_t j) {
            const CameraPose& pose = *track[std::size_t(j)].pose;
            const double x = double(j - i) / frames, weight = std::exp(-0.5 * x * x);
            turn += weight * rotationVector(multiply(quaternionOf(pose.rotation), conjugate(middle)));
            place += weight * pose.place();
            sum += weight;
        };
        add(i);
        // The window reaches equally far on both sides, up to the first missing pose, so it is symmetric and has no
        // lag.
        for (std::ptrdiff_t d = 1; d <= reach; ++d) {
            const std::ptrdiff_t before = i - d, after = i + d;
            if (before < 0 || after >= std::ptrdiff_t(track.size())) break;
            if (!track[std::size_t(before)].pose || !track[std::size_t(after)].pose) break;
            add(before);
            add(after);
        }
        smooth[std::size_t(i)] = poseAt(multiply(rotationOf(turn / sum), middle), place / sum);
    }
    for (std::size_t i = 0; i < track.size(); ++i)
        if (smooth[i]) track[i].pose = smooth[i];
}

}  // namespace penumbra
