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

}  // namespace penumbra
