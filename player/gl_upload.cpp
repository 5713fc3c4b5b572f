#include "player/gl_upload.h"

#include <algorithm>
#include <array>

#include "player/frame_values.h"

namespace penumbra {

static GlObject vertexAttribute(GLuint location, std::span<const Vec3> values) {
    GlObject buffer = makeBuffer(GL_ARRAY_BUFFER, values);
    gl::VertexAttribPointer(location, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl::EnableVertexAttribArray(location);
    return buffer;
}

// One array (mean or basis) of all clusters, one after another.
struct ArrayOfClusters {
    GLenum texel_format = GL_RGBA32F;
    std::vector<std::byte> data;
    std::vector<float> scales;
    struct Place {
        std::uint32_t first_texel, first_scale, numbers_a_scale;
    };
    std::vector<Place> places;  // [cluster]
};

// A format that all clusters share and a texel fetch can read; floats for anything else.
static AssetPrecision sharedPrecision(const ModelView& model, NumbersView ClusterView::*member) {
    if (model.clusters.empty()) return AssetPrecision::kF32;
    const AssetPrecision precision = (model.clusters.front().*member).precision;
    for (const ClusterView& cluster : model.clusters) {
        const NumbersView& numbers = cluster.*member;
        const bool scale_within_texel = precision == AssetPrecision::kI8 && numbers.row_length % 4 != 0;
        if (numbers.precision != precision || scale_within_texel) return AssetPrecision::kF32;
    }
    return precision;
}

static ArrayOfClusters gather(const ModelView& model, NumbersView ClusterView::*member) {
    const AssetPrecision precision = sharedPrecision(model, member);
    ArrayOfClusters array;
    array.texel_format = precision == AssetPrecision::kI8    ? GL_RGBA8I
                         : precision == AssetPrecision::kF16 ? GL_RGBA16F
                                                             : GL_RGBA32F;
    const std::size_t number_bytes = bytesPerNumber(precision);
    for (const ClusterView& cluster : model.clusters) {
        const NumbersView& numbers = cluster.*member;
        array.places.push_back({std::uint32_t(array.data.size() / number_bytes / 4), std::uint32_t(array.scales.size()),
                                std::uint32_t(std::max<std::size_t>(numbers.row_length, 1))});
        if (numbers.precision == precision) {
            array.data.insert(array.data.end(), numbers.data, numbers.data + numbers.count * number_bytes);
            array.scales.insert(array.scales.end(), numbers.scale.begin(), numbers.scale.end());
        } else {
            std::vector<float> decoded(numbers.count);
            decode(numbers, decoded);
            const auto bytes = std::as_bytes(std::span(decoded));
            array.data.insert(array.data.end(), bytes.begin(), bytes.end());
        }
    }
    return array;
}

static ArrayFormat uploadArray(GlModel& gl_model, const std::string& name, const ArrayOfClusters& array) {
    gl_model.samplers[name + "_numbers"] =
        makeTextureBuffer(array.texel_format, std::span<const std::byte>(array.data));
    if (array.texel_format != GL_RGBA8I) return ArrayFormat::kFloat;
    gl_model.samplers[name + "_scales"] = makeTextureBuffer(GL_R32F, std::span<const float>(array.scales));
    return ArrayFormat::kScaledBytes;
}

static void uploadClusters(GlModel& gl_model, const ModelView& model) {
    const ArrayOfClusters mean = gather(model, &ClusterView::mean), basis = gather(model, &ClusterView::basis);
    gl_model.mean = uploadArray(gl_model, "mean", mean);
    gl_model.basis = uploadArray(gl_model, "basis", basis);
    std::vector<std::uint32_t> table;  // 12 a cluster, as evaluate.vert reads them
    std::uint32_t first_score = 0;
    for (std::size_t c = 0; c < model.clusters.size(); ++c) {
        const ClusterView& cluster = model.clusters[c];
        const std::uint32_t components = std::uint32_t(cluster.bias.size());
        table.insert(table.end(),
                     {cluster.first_vertex, cluster.vertex_count, components, first_score, mean.places[c].first_texel,
                      basis.places[c].first_texel, mean.places[c].first_scale, basis.places[c].first_scale,
                      mean.places[c].numbers_a_scale, basis.places[c].numbers_a_scale, 0, 0});
        first_score += components;
    }
    gl_model.samplers["clusters"] = makeTextureBuffer(GL_RGBA32UI, std::span<const std::uint32_t>(table));
}

GlModel uploadModel(const AssetView& asset) {
    const MeshView& mesh = asset.mesh;
    GlModel model;
    model.vertex_array = makeVertexArray();
    gl::BindVertexArray(model.vertex_array.id());
    model.positions = vertexAttribute(0, mesh.positions);
    model.normals = vertexAttribute(1, mesh.normals);
    model.tangents = vertexAttribute(2, mesh.tangents);
    const std::vector<std::uint32_t> cluster = clusterOfVertex(asset);
    model.cluster = makeBuffer(GL_ARRAY_BUFFER, std::span<const std::uint32_t>(cluster));
    gl::VertexAttribIPointer(3, 1, GL_UNSIGNED_INT, 0, nullptr);
    gl::EnableVertexAttribArray(3);
    if (!mesh.slot_of_vertex.empty()) {
        model.slot = makeBuffer(GL_ARRAY_BUFFER, mesh.slot_of_vertex);
        gl::VertexAttribIPointer(5, 1, GL_UNSIGNED_SHORT, 0, nullptr);
        gl::EnableVertexAttribArray(5);
    }
    model.triangles = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, mesh.triangles);
    model.index_count = GLsizei(mesh.triangles.size());

    model.samplers["skin_joints"] = makeTextureBuffer(GL_R16UI, mesh.skin_joints);
    model.samplers["skin_weights"] = makeTextureBuffer(GL_R32F, mesh.skin_weights);
    uploadClusters(model, asset.model);
    for (const char* name : {"bones", "cluster_rotations"})
        model.samplers[name] = makeTextureBuffer(GL_RGBA32F, std::span<const std::byte>{});
    model.samplers["scores"] = makeTextureBuffer(GL_R32F, std::span<const std::byte>{});
    checkGl("uploading the asset");
    return model;
}

void uploadPose(GlModel& model, const Evaluator& evaluator, std::span<const Affine> bones) {
    std::vector<std::array<float, 4>> rotations;
    std::vector<float> scores;
    for (std::size_t c = 0; c < evaluator.clusterCount(); ++c) {
        const Mat3& r = evaluator.clusterRotation(c);
        for (int row = 0; row < 3; ++row) rotations.push_back({r(row, 0), r(row, 1), r(row, 2), 0});
        const std::span<const float> y = evaluator.scores(c);
        scores.insert(scores.end(), y.begin(), y.end());
    }
    replaceTextureBuffer(model.samplers.at("bones"), std::as_bytes(bones));
    replaceTextureBuffer(model.samplers.at("cluster_rotations"), std::as_bytes(std::span(rotations)));
    replaceTextureBuffer(model.samplers.at("scores"), std::as_bytes(std::span(scores)));
}

void uploadNumbers(GlModel& model, std::span<const float> numbers) {
    model.samplers["given_numbers"] = makeTextureBuffer(GL_RGBA32F, numbers);
}

}  // namespace penumbra
