#pragma once
// Measures what a composed model loses to its far parts: the true local visibility times the far parts, once by their
// fields and once by rays, on a sample of vertices and frames.
#include <vector>

#include "fit/clusters/vertex_clusters.h"
#include "fit/visibility/error_figures.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/far_by_rays.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

struct FarSample {
    std::size_t vertices = kComparedVertices, frames = kComparedFrames;  // frames of training, and as many held out
};

struct FarError {
    std::size_t vertices = 0, train_frames = 0, held_out_frames = 0;        // size of the sample
    ErrorFigures fields_train, fields_held_out, rays_train, rays_held_out;  // without their ambient errors
    // [own parts] rms V between field and rays, over those of the sample's receivers of which the part is a far one
    std::vector<double> part_rms;
};

struct FarErrorJob {
    const VisibilityReader& reader;
    const PoseTable& poses;
    const VertexClusters& clusters;
    const Split& split;
    int threads = 0;
};

// `model` is composed; its clusters need not be fitted yet. It has a skeleton. The figures are the same for any number
// of threads.
FarError measureFar(const FarErrorJob& job, const Model& model, const FarSample& sample = {});

}  // namespace penumbra
