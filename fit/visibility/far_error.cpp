#include "fit/visibility/far_error.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/clusters/tangent_frames.h"
#include "fit/numerics/pca.h"
#include "fit/visibility/far_factors.h"
#include "fit/visibility/local_coefficients.h"
#include "formats/common/drawn_mesh.h"
#include "formats/common/parallel_for.h"
#include "formats/common/spread_evenly.h"
#include "formats/common/write_file.h"
#include "sh/far/floor_factor.h"

namespace penumbra {

namespace {

// A frame of the comparison reads all this.
struct Comparison {
    const FarErrorJob& job;
    const Model& model;
    const FarTables& tables;
    const PartRays& rays;
    const VertexSet& set;
    const MatrixF &local, &whole;  // [F, vertices n]
    std::span<const double> mean;  // of the truth over training frames
};

// The sums that one frame adds.
struct FrameSums {
    double by_fields = 0, by_rays = 0, variance = 0;  // squares
    std::vector<double> part;                         // [P] squares
    std::vector<std::size_t> receivers;               // [P]
};

FrameSums compareFrame(const Comparison& c, std::size_t frame) {
    const std::span<const Affine> bones = c.job.poses.bonesOf(frame);
    const FarFields& fields = c.tables.fields();
    std::vector<PosedPart> posed(fields.tables.size());
    poseParts(fields, bones, posed);
    const PosedVertices vertices = skinned(c.set, bones);
    const std::size_t n = std::size_t(c.model.convention.size());
    FrameSums sums;
    sums.part.resize(posed.size());
    sums.receivers.resize(posed.size());
    for (std::size_t v = 0; v < c.set.part.size(); ++v) {
        const Vec3 normal = vertices.normals[v],
                   tangent =
                       carriedTangent(normal, nearestRotation(bones[c.set.joint[v]].linear()), c.set.rest_tangents[v]);
        const std::span<const std::uint16_t> parts = c.tables.partsSeenBy(c.set.part[v]);
        FarComparison far = compareFar({fields, c.rays, posed}, parts, {vertices.positions[v], normal, tangent});
        for (const std::uint16_t p : parts) {
            sums.part[p] += far.squares[p];
            ++sums.receivers[p];
        }
        if (fields.floor)
            for (std::array<float, kFarCoefficients>* product : {&far.by_fields, &far.by_rays})
                multiplyByFloor(fastestFarPath(), {&normal, 1}, {&tangent, 1}, *product);
        const auto coefficientsIn = [&](const MatrixF& all) { return all.row(frame).subspan(v * n, n); };
        const std::span<const float> local = coefficientsIn(c.local), truth = coefficientsIn(c.whole);
        sums.by_fields += composedError(c.model.convention, local, far.by_fields, truth);
        sums.by_rays += composedError(c.model.convention, local, far.by_rays, truth);
        for (std::size_t i = 0; i < n; ++i) {
            const double d = truth[i] - c.mean[v * n + i];
            sums.variance += d * d;
        }
    }
    return sums;
}

}  // namespace

FarError measureFar(const FarErrorJob& job, const Model& model, const FarSample& sample) {
    // 1. The vertices and frames, and their true numbers.
    std::vector<std::uint32_t> chosen;
    for (const std::size_t v : spreadEvenly(model.mesh.vertexCount(), sample.vertices))
        chosen.push_back(std::uint32_t(v));
    const std::vector<std::size_t> train = evenSample(job.split.train, sample.frames),
                                   held_out = evenSample(job.split.held_out, sample.frames);
    ClusterCoefficientsRequest request;
    request.convention = model.convention;
    request.frames = {&model.rest_tangents, &model.cluster_of_vertex, job.clusters.joint};
    request.vertices_of_cluster = {&chosen, 1};
    request.threads = job.threads;
    const MatrixF whole = readClusterCoefficients(job.reader, job.poses, request)[0];
    request.occluders = Occluders::kLocalParts;
    const MatrixF local = readClusterCoefficients(job.reader, job.poses, request)[0];
    // 2. The parts, in both ways.
    const FarTables tables = makeFarTables(*model.composition, model.convention);
    const Mesh& mesh = model.drawn ? model.drawn->mesh : model.mesh;
    const Skin& skin = model.drawn ? model.drawn->skin : model.skin;
    const PartRays rays(mesh, skin, makePartTable(mesh, skin));
    const VertexSet set = vertexSet(model, chosen, job.clusters.joint);
    const std::vector<double> mean = meanOfRows(whole, job.split.train);
    const Comparison comparison{job, model, tables, rays, set, local, whole, mean};
    // 3. Frame by frame.
    std::vector<std::size_t> frames = train;
    frames.insert(frames.end(), held_out.begin(), held_out.end());
    std::vector<FrameSums> sums(frames.size());
    parallelFor(frames.size(), job.threads, [&](std::size_t f) {
        throwIfInterrupted();
        sums[f] = compareFrame(comparison, frames[f]);
    });
    FrameErrors by_fields(whole.rows), by_rays(whole.rows);
    std::vector<double> squares(rays.partCount()), receivers(rays.partCount());
    for (std::size_t f = 0; f < frames.size(); ++f) {
        by_fields.squared[frames[f]] = sums[f].by_fields;
        by_rays.squared[frames[f]] = sums[f].by_rays;
        by_fields.variance[frames[f]] = by_rays.variance[frames[f]] = sums[f].variance;
        for (std::size_t p = 0; p < squares.size(); ++p) {
            squares[p] += sums[f].part[p];
            receivers[p] += double(sums[f].receivers[p]);
        }
    }
    FarError error{chosen.size(),
                   train.size(),
                   held_out.size(),
                   figuresOf(by_fields, train, chosen.size()),
                   figuresOf(by_fields, held_out, chosen.size()),
                   figuresOf(by_rays, train, chosen.size()),
                   figuresOf(by_rays, held_out, chosen.size()),
                   {}};
    for (std::size_t p = 0; p < squares.size(); ++p)
        error.part_rms.push_back(receivers[p] > 0 ? std::sqrt(squares[p] / receivers[p]) : 0);
    return error;
}

}  // namespace penumbra
