#include "fit/visibility/local_coefficients.h"

#include <algorithm>
#include <array>

#include "fit/clusters/tangent_frames.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kBlockFloats = std::size_t(1) << 23;  // moments in memory at a time
constexpr std::size_t kBlockVertices = 64;                  // vertices that a bake stores together

// A vertex of a range that was asked for, and where its numbers go.
struct Wanted {
    std::uint32_t vertex;
    std::uint32_t cluster;  // index into the request
    std::size_t column;     // column of its first number
};

std::vector<Wanted> wantedVertices(const ClusterCoefficientsRequest& request) {
    std::vector<Wanted> wanted;
    for (std::size_t c = 0; c < request.vertices_of_cluster.size(); ++c)
        for (std::size_t i = 0; i < request.vertices_of_cluster[c].size(); ++i)
            wanted.push_back({request.vertices_of_cluster[c][i], std::uint32_t(c), i * request.coefficientsOfVertex()});
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.vertex < b.vertex; });
    return wanted;
}

// The wanted vertices as a mesh of their own, so that skinVertices() computes their normals only.
struct Part {
    Mesh mesh;
    Skin skin;
    std::vector<Vec3> rest_normals;
    std::size_t inputs = 0;  // of a pose
};

Part makePart(const VisibilityHeader& header, std::span<const Wanted> wanted) {
    Part part;
    if (!header.skin) return part;
    const std::size_t k = std::size_t(header.skin->influences);
    part.skin.joint_names = header.skin->joint_names;
    part.skin.parents = header.skin->parents;
    part.skin.influences = header.skin->influences;
    std::vector<std::uint32_t> vertices;
    for (const Wanted& w : wanted) vertices.push_back(w.vertex);
    part.mesh.morphs = selectVertices(header.mesh.morphs, vertices);
    part.inputs = header.input_names.size();
    for (const Wanted& w : wanted) {
        part.mesh.rest_positions.push_back(header.mesh.rest_positions[w.vertex]);
        part.rest_normals.push_back(header.rest_normals[w.vertex]);
        for (std::size_t i = 0; i < k; ++i) {
            part.skin.joints.push_back(header.skin->joints[w.vertex * k + i]);
            part.skin.weights.push_back(header.skin->weights[w.vertex * k + i]);
        }
    }
    return part;
}

// A range of vertices in memory.
struct VertexRange {
    std::size_t begin = 0, end = 0;
    std::size_t stride = 0;      // number of moments of a vertex
    std::vector<float> moments;  // [F, end - begin, stride]
    std::span<const Wanted> wanted;
    Part part;  // the wanted vertices

    std::span<const float> momentsOf(std::size_t frame, std::uint32_t vertex, std::size_t count) const {
        const std::size_t at = (frame * (end - begin) + vertex - begin) * stride;
        return std::span(moments).subspan(at, count);
    }
};

// Returns the normals of the wanted vertices in one frame, by skinning or from the file. A back has the opposite normal
// of its front.
std::vector<Vec3> normalsOf(const PoseTable& poses, const VertexRange& range, std::size_t frame) {
    std::vector<Vec3> normals;
    if (!poses.deforming) {
        const Part& part = range.part;
        const std::vector<Affine> bones(poses.bonesOf(frame).begin(), poses.bonesOf(frame).end());
        const std::vector<float> weights =
            morphWeights(poses.input_joints, bones, part.inputs, part.mesh.morphs.count());
        RestShape vertices;
        skinMorphed(part.mesh, part.skin, part.rest_normals, {bones, weights}, vertices);
        return std::move(vertices.normals);
    }
    const std::size_t fronts = poses.normals.size() / poses.frameCount();
    for (const Wanted& wanted : range.wanted) {
        const Vec3 front = poses.normals[frame * fronts + wanted.vertex % fronts];
        normals.push_back(wanted.vertex < fronts ? front : -front);
    }
    return normals;
}

// Returns the matrix that takes directions from the local frame of a vertex, its normal and its tangent carried by the
// cluster's joint, to the model frame.
Mat3 frameOf(const PoseTable& poses, const ClusterCoefficientsRequest& request, std::uint32_t vertex, Vec3 normal,
             std::size_t frame) {
    const int joint = request.frames.joint_of_cluster[(*request.frames.cluster_of_vertex)[vertex]];
    const Mat3& rotation = poses.rotationsOf(frame)[std::size_t(joint)];
    return localFrame(normal, carriedTangent(normal, rotation, (*request.frames.rest_tangents)[vertex]));
}

// Writes the numbers of the indirect transfer of the wanted vertices in one frame.
void writeFrameIndirect(const PoseTable& poses, const ClusterCoefficientsRequest& request, const VertexRange& range,
                        std::size_t frame, std::vector<MatrixF>& out) {
    const std::vector<Vec3> normals = normalsOf(poses, range, frame);
    const std::size_t n2 = range.stride / 3;
    std::array<float, 3 * kIndirectCoefficients> local;
    for (std::size_t i = 0; i < range.wanted.size(); ++i) {
        const Wanted& wanted = range.wanted[i];
        const ShRotation to_model =
            makeShRotation(kIndirectOrder, frameOf(poses, request, wanted.vertex, normals[i], frame));
        const std::span<const float> transfer = range.momentsOf(frame, wanted.vertex, range.stride);
        for (std::size_t c = 0; c < 3; ++c)
            applyTransposed(to_model, transfer.subspan(c * n2, kIndirectCoefficients),
                            std::span(local).subspan(c * kIndirectCoefficients, kIndirectCoefficients));
        toIndirectCoefficients(*request.indirect, local,
                               out[wanted.cluster].row(frame).subspan(wanted.column, kIndirectSize));
    }
}

// Writes the numbers of the wanted vertices in one frame.
void writeFrameCoefficients(const PoseTable& poses, const ClusterCoefficientsRequest& request, const VertexRange& range,
                            std::size_t frame, std::vector<MatrixF>& out) {
    const std::vector<Vec3> normals = normalsOf(poses, range, frame);
    const int order = request.convention.order + request.form->more_bands;
    const auto count = std::size_t(coefficientCount(order)), size = std::size_t(request.convention.size());
    std::array<float, coefficientCount(kMaxOrder)> buffer;
    const std::span<float> local = std::span(buffer).first(count);
    for (std::size_t i = 0; i < range.wanted.size(); ++i) {
        const Wanted& wanted = range.wanted[i];
        const ShRotation to_model = makeShRotation(order, frameOf(poses, request, wanted.vertex, normals[i], frame));
        applyTransposed(to_model, range.momentsOf(frame, wanted.vertex, count), local);
        request.form->convert(request.convention, local, to_model,
                              out[wanted.cluster].row(frame).subspan(wanted.column, size));
    }
}

}  // namespace

constinit const NumberForm kVisibilityForm{
    [](const Convention& convention, std::span<const float> local, const ShRotation&, std::span<float> coefficients) {
        fromMoments(convention, local, coefficients);
    },
    [](const Convention& convention) {
        std::vector<float> weights(std::size_t(convention.size()));
        ambientWeights(convention, weights);
        return weights;
    }};

std::vector<MatrixF> readClusterCoefficients(const VisibilityReader& reader, const PoseTable& poses,
                                             const ClusterCoefficientsRequest& request) {
    const VisibilityHeader& header = reader.header();
    const bool local = request.occluders == Occluders::kLocalParts;
    const std::size_t frames = poses.frameCount(), stride = request.indirect ? header.indirectCount()
                                                            : local ? std::size_t(coefficientCount(header.local->order))
                                                                    : header.coefficientCount();
    std::vector<MatrixF> out;
    for (const auto& vertices : request.vertices_of_cluster)
        out.emplace_back(frames, vertices.size() * request.coefficientsOfVertex());

    const std::vector<Wanted> wanted = wantedVertices(request);
    const std::size_t step =
        std::max<std::size_t>(kBlockFloats / (frames * stride) / kBlockVertices, 1) * kBlockVertices;
    VertexRange range;
    range.stride = stride;
    for (std::size_t first = 0; first < wanted.size(); first += range.wanted.size()) {
        throwIfInterrupted();
        // 1. Take the next range of vertices that holds a wanted one.
        range.begin = wanted[first].vertex / step * step;
        range.end = std::min(range.begin + step, header.mesh.vertexCount());
        std::size_t last = first;
        while (last < wanted.size() && wanted[last].vertex < range.end) ++last;
        range.wanted = {wanted.data() + first, last - first};
        range.moments.resize(frames * (range.end - range.begin) * stride);
        // 2. Read its moments in all frames, and compute the numbers frame by frame.
        if (request.indirect)
            reader.readIndirectVertices(range.begin, range.end, range.moments);
        else if (local)
            reader.readLocalVertices(range.begin, range.end, range.moments);
        else
            reader.readVertices(range.begin, range.end, range.moments);
        range.part = makePart(header, range.wanted);
        parallelFor(frames, request.threads, [&](std::size_t f) {
            (request.indirect ? writeFrameIndirect : writeFrameCoefficients)(poses, request, range, f, out);
        });
        if (request.vertices_done) request.vertices_done(last - first);
    }
    return out;
}

}  // namespace penumbra
