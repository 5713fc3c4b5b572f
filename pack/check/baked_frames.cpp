#include "pack/check/baked_frames.h"

#include <cmath>

#include "formats/common/errors.h"

namespace penumbra {

FrameFinder::FrameFinder(const VisibilityReader* reader, std::string name) : reader_(reader), name_(std::move(name)) {
    if (!reader) return;
    const FrameList& frames = reader->header().frames;
    for (std::size_t f = 0; f < frames.frameCount(); ++f)
        frame_of_[{frames.clip_names[frames.clip[f]], frames.time[f]}] = f;
}

VisibilityFrame FrameFinder::read(const std::string& clip, double time) const {
    if (!reader_) return {};
    const auto found = frame_of_.find({clip, time});
    if (found == frame_of_.end())
        throw InvalidInput(name_ + ": no frame of clip \"" + clip + "\" at " + std::to_string(time) + " s");
    return reader_->readFrame(found->second);
}

namespace {

InvalidInput otherPose(const std::string& clip, double time) {
    return InvalidInput("second bake: the pose of clip \"" + clip + "\" at " + std::to_string(time) +
                        " s is not that of the truth");
}

}  // namespace

void checkSamePose(const VisibilityFrame& truth, const VisibilityFrame& second, const std::string& clip, double time) {
    for (std::size_t j = 0; j < truth.bones.size(); ++j)
        for (std::size_t e = 0; e < 12; ++e)
            if (!(std::abs(truth.bones[j].m[e] - second.bones[j].m[e]) <= 1e-4f)) throw otherPose(clip, time);
    if (!truth.bones.empty()) return;
    for (std::size_t v = 0; v < truth.positions.size(); ++v)
        if (!(length(truth.positions[v] - second.positions[v]) <= 1e-4f)) throw otherPose(clip, time);
}

void poseAs(Evaluator& evaluator, const VisibilityFrame& baked) {
    const AssetView& asset = evaluator.asset();
    const std::span<const float> inputs = std::span(baked.pose).last(asset.animation.input_names.size());
    if (evaluator.deformation())
        return evaluator.setPositions(std::span(baked.positions).first(evaluator.points().size()), inputs);
    std::vector<Affine> bones = baked.bones;  // the joints that stand for inputs come last
    for (const InputJointView& input : asset.model.input_joints) bones.push_back(inputBone(asset, input, inputs));
    evaluator.setPose(bones, baked.pose);
}

}  // namespace penumbra
