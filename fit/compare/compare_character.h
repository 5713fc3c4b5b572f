#pragma once
// Prepares a character as a fit at the reference of a comparison sees it.
#include <string>
#include <vector>

#include "fit/clusters/vertex_clusters.h"
#include "fit/compare/compare_options.h"
#include "fit/visibility/local_numbers.h"

namespace penumbra {

struct CompareInput {
    const VisibilityReader& reader;
    const PoseTable& poses;
    std::string file;  // names the reader's file in messages
};

struct CompareCharacter {
    VertexClusters clusters;
    std::vector<Vec3> rest_tangents;
    std::vector<std::size_t> train, held_out;  // frames
};
CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options);

// Cuts the clusters into batches whose numbers go into memory together. Batch b has those from starts[b] to
// starts[b + 1].
std::vector<std::size_t> batchStarts(const VertexClusters& clusters, std::size_t bytes_per_vertex);

// Returns the mean rest position of some vertices.
Vec3 centerOfVertices(const Mesh& mesh, const std::vector<std::uint32_t>& vertices);

}  // namespace penumbra
