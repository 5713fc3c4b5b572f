#include "fit/visibility/fit_batches.h"

#include <algorithm>
#include <functional>
#include <mutex>
#include <numbers>

#include "fit/visibility/compose_fields.h"
#include "formats/common/parallel_for.h"
#include "formats/common/part_table.h"
#include "formats/common/write_file.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

// Tells the observer from whichever thread makes progress. The share never goes down.
class SharedProgress {
public:
    SharedProgress(const FitObserver& observer, double total) : observer_(observer), total_(total) {}
    void add(double amount) {
        const std::scoped_lock lock(mutex_);
        done_ += amount;
        if (observer_.progress) observer_.progress(done_ / total_);
    }

private:
    const FitObserver& observer_;
    double total_, done_ = 0;
    std::mutex mutex_;
};

// The weights that give the luminance of E_ind / pi under a light of radiance 1 from everywhere.
std::vector<float> indirectWeights(const ColorAxes& axes) {
    std::vector<float> weights(kIndirectSize);
    const std::array<std::size_t, 3> places{0, kIndirectCoefficients, kIndirectCoefficients + 1};
    for (int k = 0; k < 3; ++k)
        weights[places[std::size_t(k)]] =
            float(2 * std::numbers::inv_sqrtpi) * luminance(Vec3{axes(k, 0), axes(k, 1), axes(k, 2)});
    return weights;
}

// Reads the numbers of the clusters [begin, end).
using ReadCoefficients = std::function<std::vector<MatrixF>(std::size_t begin, std::size_t end, Occluders occluders)>;
// Fits the cluster c, which is number i of its batch.
using FitBatch = std::function<void(std::size_t begin, std::size_t end, const ReadCoefficients& read)>;

std::vector<MatrixF> readCoefficients(const FitJob& job, const Model& model,
                                      std::span<const std::vector<std::uint32_t>> vertices_of_cluster,
                                      Occluders occluders, std::function<void(std::size_t)> vertices_done) {
    ClusterCoefficientsRequest request;
    request.convention = model.convention;
    request.frames = {&model.rest_tangents, &model.cluster_of_vertex, job.clusters.joint};
    request.vertices_of_cluster = vertices_of_cluster;
    request.form = job.options.form;
    request.indirect = job.indirect;
    request.occluders = occluders;
    request.threads = job.options.threads;
    request.vertices_done = std::move(vertices_done);
    return readClusterCoefficients(job.reader, job.poses, request);
}

// Calls `fit` for one batch of clusters after the other. Each takes about `copies` times its numbers in memory.
void forBatches(const FitJob& job, const Model& model, std::size_t copies, const FitBatch& fit) {
    const std::size_t size = job.indirect ? kIndirectSize : std::size_t(model.convention.size()),
                      bytes_per_vertex = job.poses.frameCount() * size * sizeof(float) * copies;
    const std::size_t batch_bytes = job.options.batch_bytes
                                        ? job.options.batch_bytes
                                        : std::clamp(bytes_per_vertex * model.mesh.vertexCount() / 5,
                                                     std::size_t(32) << 20, std::size_t(256) << 20);
    // Reading and rotating a vertex' numbers takes about as long as fitting them, so each counts half.
    SharedProgress progress(job.observer, 2.0 * double(copies) * double(model.mesh.vertexCount()));
    const ReadCoefficients read = [&](std::size_t begin, std::size_t end, Occluders occluders) {
        return readCoefficients(job, model, std::span(job.clusters.vertices).subspan(begin, end - begin), occluders,
                                [&](std::size_t n) { progress.add(double(n)); });
    };
    for (auto [begin, end] : makeBatches(job.clusters.vertices, bytes_per_vertex, batch_bytes)) {
        fit(begin, end, read);
        for (std::size_t c = begin; c < end; ++c) progress.add(double(copies * job.clusters.vertices[c].size()));
    }
}

ClusterProblem problemOf(const FitJob& job, const Model& model, const FeatureRecipe& recipe, std::size_t cluster) {
    return {job.options.model, &recipe, &job.poses, job.split.train, &job.folds,
            job.indirect ? indirectWeights(*job.indirect) : job.options.form->ambient_weights(model.convention),
            !job.indirect && job.options.form->clamp,
            // The angles went through one PCA together, so none is dropped here.
            model.features == FeatureKind::kDihedrals ? 1.0 : inputVariance(job.options), job.options.output_variance,
            job.clusters.joint[cluster], centerOf(model.mesh, job.clusters.vertices[cluster]), job.options.prior};
}

}  // namespace

std::vector<std::pair<std::size_t, std::size_t>> makeBatches(
    const std::vector<std::vector<std::uint32_t>>& vertices_of_cluster, std::size_t bytes_per_vertex,
    std::size_t batch_bytes) {
    std::vector<std::pair<std::size_t, std::size_t>> batches;
    std::size_t bytes = 0;
    for (std::size_t c = 0; c < vertices_of_cluster.size(); ++c) {
        const std::size_t size = vertices_of_cluster[c].size() * bytes_per_vertex;
        if (batches.empty() || bytes + size > batch_bytes) {
            batches.emplace_back(c, c);
            bytes = 0;
        }
        bytes += size;
        batches.back().second = c + 1;
    }
    return batches;
}

Vec3 centerOf(const Mesh& mesh, const std::vector<std::uint32_t>& vertices) {
    Vec3d sum;
    for (std::uint32_t v : vertices) sum += toDouble(mesh.rest_positions[v]);
    return toFloat(sum / double(vertices.size()));
}

std::vector<ClusterFit> fitClusters(const FitJob& job, const Model& model) {
    const FeatureRecipe recipe = recipeOf(model);
    std::vector<ClusterFit> fits(job.clusters.vertices.size());
    forBatches(job, model, 1, [&](std::size_t begin, std::size_t end, const ReadCoefficients& read) {
        std::vector<MatrixF> coefficients = read(begin, end, Occluders::kAll);
        parallelFor(coefficients.size(), job.options.threads, [&](std::size_t i) {
            throwIfInterrupted();
            fits[begin + i] = fitCluster(problemOf(job, model, recipe, begin + i), coefficients[i]);
            fits[begin + i].model.vertices = job.clusters.vertices[begin + i];
            coefficients[i] = {};
        });
    });
    return fits;
}

namespace {

// Poses all parts in all frames, [F, P].
std::vector<PosedPart> posedParts(const FitJob& job, const FarFields& fields) {
    const std::size_t parts = fields.tables.size();
    std::vector<PosedPart> posed(job.poses.frameCount() * parts);
    parallelFor(job.poses.frameCount(), job.options.threads, [&](std::size_t f) {
        poseParts(fields, job.poses.bonesOf(f), std::span(posed).subspan(f * parts, parts));
    });
    return posed;
}

// Tells whether an input is the weight of a morph target that moves something of a part which is local to part `own`.
bool movesNearParts(const Model& model, const PartTable& table, const InputJoint& input, std::size_t own) {
    const MorphTargets& morphs = model.mesh.morphs;
    const std::size_t inputs = model.input_names.size();
    if (input.columns != 1 || input.column + morphs.count() < inputs) return false;
    const MorphRows rows = morphs.rowsOf(input.column + morphs.count() - inputs);
    return std::any_of(rows.vertices.begin(), rows.vertices.end(), [&](std::uint32_t v) {
        return int(table.stepsBetween(own, table.part_of_vertex[v])) <= model.composition->local_steps;
    });
}

// Returns a recipe that sees the joints whose parts are local to the joint's, morph targets that move such parts, and
// joints that stand for inputs of a deforming mesh, unless a part is known to move with them. A joint that moves
// nothing is not seen: it repeats what others say. All parts of a deforming mesh are local.
FeatureRecipe localRecipe(const Model& model, const PartTable& table, const FeatureRecipe& recipe, int joint) {
    FeatureRecipe local = recipe;
    const std::vector<bool> composed = composedInputs(model);
    if (model.deforming) {
        local.seen = composed;
        local.seen.flip();
        return local;
    }
    const int steps = model.composition->local_steps;
    const std::size_t own = table.part_of_joint[std::size_t(joint)];
    local.seen.assign(recipe.joint_centers.size(), true);
    for (std::size_t j = 0; j < table.part_of_joint.size(); ++j) {
        const std::array<float, 9>& spread = recipe.joint_spreads[j].m;
        const bool moves = std::any_of(spread.begin(), spread.end(), [](float x) { return x != 0; });
        local.seen[j] = moves && !composed[j] && int(table.stepsBetween(own, table.part_of_joint[j])) <= steps;
    }
    for (const InputJoint& input : model.input_joints)
        if (movesNearParts(model, table, input, own)) local.seen[input.joint] = true;
    return local;
}

}  // namespace

ComposedClusters::ComposedClusters(const FitJob& job, const Model& composed)
    : model(composed),
      recipe(recipeOf(composed)),
      table(composed.deforming ? PartTable{} : partsOf(composed.mesh, composed.skin, composed.drawn)),
      far(makeFarTables(*composed.composition, composed.convention)),
      posed(posedParts(job, far.fields())) {}

std::vector<ClusterCoefficients> readComposedCoefficients(const FitJob& job, const Model& model,
                                                          std::span<const std::size_t> clusters) {
    std::vector<std::vector<std::uint32_t>> vertices;
    for (const std::size_t c : clusters) vertices.push_back(job.clusters.vertices[c]);
    std::vector<MatrixF> local = readCoefficients(job, model, vertices, Occluders::kLocalParts, {}),
                         whole = readCoefficients(job, model, vertices, Occluders::kAll, {});
    std::vector<ClusterCoefficients> coefficients;
    for (std::size_t i = 0; i < clusters.size(); ++i)
        coefficients.push_back({std::move(local[i]), std::move(whole[i])});
    return coefficients;
}

ComposedFit fitComposedCluster(const FitJob& job, const ComposedClusters& shared, std::size_t c,
                               ClusterCoefficients coefficients) {
    throwIfInterrupted();
    const FeatureRecipe near = localRecipe(shared.model, shared.table, shared.recipe, job.clusters.joint[c]);
    const VertexSet vertices = vertexSet(shared.model, job.clusters.vertices[c], job.clusters.joint);
    ComposedProblem problem{problemOf(job, shared.model, near, c), problemOf(job, shared.model, shared.recipe, c),
                            &shared.far, &vertices, shared.posed};
    problem.local.clamp = problem.residual.clamp = false;  // only the whole is
    problem.residual.ambient_weights.clear();
    const NearProblem near_problem{&shared.far,        &shared.model,   &job.poses,   shared.posed,
                                   job.clusters.joint, job.split.train, shared.hidden};
    if (shared.model.composition->near_count > 0) problem.near = &near_problem;
    ComposedFit fit = fitComposed(problem, coefficients.local, coefficients.whole);
    for (ClusterFit* part : {&fit.local, &fit.residual}) part->model.vertices = job.clusters.vertices[c];
    return fit;
}

std::vector<ComposedFit> fitComposedClusters(const FitJob& job, const Model& model, HiddenVertices hidden) {
    ComposedClusters shared(job, model);
    shared.hidden = hidden;
    std::vector<ComposedFit> fits(job.clusters.vertices.size());
    forBatches(job, model, 2, [&](std::size_t begin, std::size_t end, const ReadCoefficients& read) {
        std::vector<MatrixF> local = read(begin, end, Occluders::kLocalParts),
                             whole = read(begin, end, Occluders::kAll);
        parallelFor(whole.size(), job.options.threads, [&](std::size_t i) {
            fits[begin + i] = fitComposedCluster(job, shared, begin + i, {std::move(local[i]), std::move(whole[i])});
        });
    });
    return fits;
}

}  // namespace penumbra
