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

template <class T>
std::vector<T> gathered(const std::vector<T>& items, const std::vector<std::uint32_t>& chosen) {
    std::vector<T> out;
    out.reserve(chosen.size());
    for (const std::uint32_t i : chosen) out.push_back(items[i]);
    return out;
}

// All vertices of a source of which some are baked.
struct DensePose {
    std::vector<Vec3> positions, normals;
};

// Poses the vertices. Where the bake has chosen some of them, `dense` gets all.
VisibilityFrame poseAll(const BakePlan& plan, std::size_t f, DensePose& dense) {
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
    if (!plan.chosen.empty()) {
        dense = {std::move(pose.positions), std::move(pose.normals)};
        pose.positions = gathered(dense.positions, plan.chosen);
        pose.normals = gathered(dense.normals, plan.chosen);
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

}  // namespace

VisibilityFrame poseVertices(const BakePlan& plan, std::size_t f) {
    DensePose dense;
    return poseAll(plan, f, dense);
}

FrameScene frameScene(const BakePlan& plan, std::size_t f) {
    DensePose dense;
    VisibilityFrame frame = poseAll(plan, f, dense);
    const FrameList& frames = plan.header.frames;
    const Mesh& character = plan.occluder();
    std::vector<Vec3> scaled = plan.chosen.empty() ? frame.positions : dense.positions;
    scaled.resize(character.frontVertexCount());
    SceneScale scale = sceneScale(scaled, plan.rest_diagonal);
    if (!plan.far_bias.empty()) {
        const BoundingBox box = characterBox(character.frontTriangles(), scaled);
        scale = sceneScale(std::array{box.low, box.high}, plan.rest_diagonal);
    }
    for (const Occluder& occluder : plan.occluders) appendPositions(occluder, frames.clip[f], frames.time[f], scaled);
    for (Vec3& p : scaled) p = scale.apply(p);
    std::vector<BoundingBox> boxes;
    if (plan.local) boxes = plan.local->boxesOf(character.frontTriangles(), scaled);
    std::vector<Vec3> ways;
    if (!plan.places.empty()) ways = startWays(plan.places, plan.chosen.empty() ? frame.normals : dense.normals);
    return {
        std::move(frame),
        scale,
        OcclusionScene(scaled, plan.blockers.triangles,
                       plan.sheet_rules || plan.local ? Queries::kFiltered : Queries::kPlain, plan.blockers.through()),
        std::move(boxes),
        std::move(ways),
        std::move(dense.positions)};
}

MomentOutput outputOf(VisibilityFrame& frame) { return {frame.coefficients, frame.local_coefficients}; }

BakeDirections makeBakeDirections(const BakeOptions& options, double diagonal) {
    BakeDirections out{makeRayDirections(options.rays, options.seed, options.order), {}, {}};
    if (options.distance > 0) out.reach.emplace(float(options.distance / diagonal));
    if (options.local && options.local->order != options.order)
        out.local = makeRayDirections(options.rays, options.seed, options.local->order);
    return out;
}

MomentTracer tracerOf(const BakePlan& plan, const FrameScene& posed, const BakeDirections& directions) {
    MomentTracer tracer{posed.scene, directions.whole, posed.scale, plan.bias,
                        plan.header.ground_y ? Floor::kSolid : Floor::kNone};
    if (plan.sheet_rules) tracer.blockers = &plan.blockers;
    tracer.far_bias = plan.far_bias;
    tracer.mesh = &plan.occluder();
    tracer.vertices = plan.chosen.empty() ? posed.frame.positions : posed.dense;
    tracer.vertex_of_point = plan.chosen;
    tracer.start_ways = posed.start_ways;
    if (directions.reach) tracer.reach = &*directions.reach;
    if (plan.header.ground_y)
        tracer.floor_y = float((double(*plan.header.ground_y) - posed.scale.center.y) / posed.scale.diagonal);
    if (plan.local)
        tracer.local.emplace(
            LocalTracer{*plan.local, directions.local ? *directions.local : directions.whole, posed.part_boxes});
    return tracer;
}

}  // namespace penumbra
