#include "bake/posed_frame.h"

#include <cmath>

#include "formats/errors.h"

namespace penumbra {

VisibilityFrame poseVertices(const BakePlan& plan, std::size_t f) {
    const FrameList& frames = plan.header.frames;
    const RigPose pose = evaluatePose(plan.rig, plan.rig_clip[frames.clip[f]], frames.time[f]);
    VisibilityFrame frame{{}, {}, pose.bones, pose.pose, {}};
    skinVertices(plan.rig.mesh, plan.rig.skin, plan.rig.rest_normals, pose.bones, frame.positions, frame.normals);
    for (std::size_t v = 0; v < frame.positions.size(); ++v)
        if (!std::isfinite(dot(frame.positions[v], frame.positions[v]) + dot(frame.normals[v], frame.normals[v])))
            throw InvalidInput(plan.rig.files_read.front().string() + ": frame " + std::to_string(f) + " (clip '" +
                               frames.clip_names[frames.clip[f]] + "', " + std::to_string(frames.time[f]) +
                               " s): vertex " + std::to_string(v) + " is not finite");
    frame.coefficients.resize(frame.positions.size() * plan.header.coefficientCount());
    return frame;
}

PosedFrame poseFrame(const BakePlan& plan, std::size_t f) {
    VisibilityFrame frame = poseVertices(plan, f);
    std::vector<Vec3> scaled(frame.positions);
    const SceneScale scale = sceneScale(scaled, plan.rest_diagonal);
    for (Vec3& p : scaled) p = scale.apply(p);
    return {std::move(frame), scale, OcclusionScene(scaled, plan.rig.mesh.triangles)};
}

}  // namespace penumbra
