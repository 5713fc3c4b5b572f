#pragma once
// A character as a fit at the reference of a comparison sees it.
#include <string>
#include <vector>

#include "fit/compare_options.h"
#include "fit/local_numbers.h"
#include "fit/vertex_clusters.h"

namespace penumbra {

struct CompareInput {
    const VisibilityReader& reader;
    const PoseTable& poses;
    std::string file;  // for messages
};

struct CompareCharacter {
    VertexClusters clusters;
    std::vector<Vec3> rest_tangents;
    std::vector<std::size_t> train, held_out;  // frames
};
CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options);

}  // namespace penumbra
