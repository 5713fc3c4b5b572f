#include "fit/compare/compare_character.h"

#include <algorithm>

#include "fit/clusters/tangent_frames.h"

namespace penumbra {

CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options) {
    const VisibilityHeader& header = input.reader.header();
    CompareCharacter character;
    character.clusters =
        clustersOf(header.mesh, input.poses, std::size_t(options.referenceClusters()), options.threads);
    character.rest_tangents = restTangents(header.mesh, header.rest_normals, character.clusters, options.threads);
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        const std::string& clip = header.frames.clip_names[header.frames.clip[f]];
        const bool held = std::find(options.holdout.begin(), options.holdout.end(), clip) != options.holdout.end();
        (held ? character.held_out : character.train).push_back(f);
    }
    return character;
}

std::vector<std::size_t> batchStarts(const VertexClusters& clusters, std::size_t bytes_per_vertex) {
    constexpr std::size_t kBatchBytes = std::size_t(128) << 20;  // of numbers in memory at a time
    std::vector<std::size_t> starts{0};
    std::size_t bytes = 0;
    for (std::size_t c = 0; c < clusters.vertices.size(); ++c) {
        const std::size_t of_cluster = clusters.vertices[c].size() * bytes_per_vertex;
        if (c > starts.back() && bytes + of_cluster > kBatchBytes) {
            starts.push_back(c);
            bytes = 0;
        }
        bytes += of_cluster;
    }
    starts.push_back(clusters.vertices.size());
    return starts;
}

Vec3 centerOfVertices(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
    Vec3d sum;
    for (std::uint32_t v : vertices) sum += toDouble(mesh.rest_positions[v]);
    return toFloat(sum / double(vertices.size()));
}

}  // namespace penumbra
