#include "bake/visibility/frame_scene.h"

#include <cmath>

#include "bake/trace/start_ways.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

void checkFinite(const BakePlan& plan, std::size_t f, const SourcePose& pose) {
    const FrameList& frames = plan.header.frames;
    for (std::size_t v = 0; v < pose.positions.size(); ++v)
        if (!std::isfinite(dot(pose.positions[v], pose.positions[v]) + dot(pose.normals[v], pose.normals[v])))
            throw InvalidInput(plan.source.filesRead().front().string() + ": frame " + std::to_string(f) + " (clip '" +
                               frames.clip_names[frames.clip[f]] + "', " + std::to_string(frames.time[f]) +
                               " s): vertex " + std::to_string(v) + " is not finite");
}

std::vector<float> inputsOf(const BakePlan& plan, std::size_t f) {
    if (plan.inputs.names.empty()) return {};
    const FrameList& frames = plan.header.frames;
    return inputsAt(plan.inputs, plan.source_clip[frames.clip[f]], frames.time[f]);
}

}  // namespace

VisibilityFrame poseVertices(const BakePlan& plan, std::size_t f) {
    const FrameList& frames = plan.header.frames;
    SourcePose pose = poseSource(plan.source, plan.source_clip[frames.clip[f]], frames.time[f]);
    checkFinite(plan, f, pose);
    if (plan.source.cache) pose.pose = continuousAngles(plan.header.edges, pose.positions, plan.turns[f]);
    const std::vector<float> inputs = inputsOf(plan, f);
    pose.pose.insert(pose.pose.end(), inputs.begin(), inputs.end());
    pose.pose.insert(pose.pose.end(), pose.morph_weights.begin(), pose.morph_weights.end());
    if (plan.header.mesh.two_sided) {
        appendBackPositions(pose.positions);
        appendBackNormals(pose.normals);
    }
    VisibilityFrame frame{
        std::move(pose.positions), std::move(pose.normals), std::move(pose.bones), std::move(pose.pose), {}};
    frame.coefficients.resize(frame.positions.size() * plan.header.coefficientCount());
    if (plan.header.local)
        frame.local_coefficients.resize(frame.positions.size() * plan.header.local->coefficientCount());
    frame.indirect.resize(frame.positions.size() * plan.header.indirectCount());
    if (plan.header.hasBounces()) frame.hit_shares.resize(2);
    return frame;
}

FrameScene frameScene(const BakePlan& plan, std::size_t f) {
    VisibilityFrame frame = poseVertices(plan, f);
    const FrameList& frames = plan.header.frames;
    std::vector<Vec3> scaled(frame.positions.begin(),
                             frame.positions.begin() + std::ptrdiff_t(plan.header.mesh.frontVertexCount()));
    SceneScale scale = sceneScale(scaled, plan.rest_diagonal);
    if (!plan.far_bias.empty()) {
        const BoundingBox box = characterBox(plan.header.mesh.frontTriangles(), scaled);
        scale = sceneScale(std::array{box.low, box.high}, plan.rest_diagonal);
    }
    for (const Occluder& occluder : plan.occluders) appendPositions(occluder, frames.clip[f], frames.time[f], scaled);
    for (Vec3& p : scaled) p = scale.apply(p);
    std::vector<BoundingBox> boxes;
    if (plan.local) boxes = plan.local->boxesOf(plan.header.mesh.frontTriangles(), scaled);
    std::vector<Vec3> ways;
    if (!plan.places.empty()) ways = startWays(plan.places, frame.normals);
    return {
        std::move(frame), scale,
        OcclusionScene(scaled, plan.blockers.triangles,
                       plan.sheet_rules || plan.local ? Queries::kFiltered : Queries::kPlain, plan.blockers.through()),
        std::move(boxes), std::move(ways)};
}

MomentOutput outputOf(VisibilityFrame& frame) { return {frame.coefficients, frame.local_coefficients}; }

BakeDirections makeBakeDirections(const BakeOptions& options) {
    BakeDirections out{makeRayDirections(options.rays, options.seed, options.order), {}};
    if (options.local && options.local->order != options.order)
        out.local = makeRayDirections(options.rays, options.seed, options.local->order);
    return out;
}

MomentTracer tracerOf(const BakePlan& plan, const FrameScene& posed, const BakeDirections& directions) {
    MomentTracer tracer{posed.scene, directions.whole, posed.scale, plan.bias,
                        plan.header.ground_y ? Floor::kSolid : Floor::kNone};
    if (plan.sheet_rules) tracer.blockers = &plan.blockers;
    tracer.far_bias = plan.far_bias;
    tracer.mesh = &plan.header.mesh;
    tracer.vertices = posed.frame.positions;
    tracer.start_ways = posed.start_ways;
    if (plan.local)
        tracer.local.emplace(
            LocalTracer{*plan.local, directions.local ? *directions.local : directions.whole, posed.part_boxes});
    return tracer;
}

}  // namespace penumbra
