#include "fit/visibility/predict_indirect.h"

#include "fit/clusters/tangent_frames.h"
#include "fit/models/regressor.h"
#include "formats/common/parallel_for.h"
#include "sh/indirect_numbers.h"
#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Turns the numbers of a vertex into transfer, [3, kIndirectCoefficients] in the local frame and then in the model's.
void toTransfer(const ColorAxes& axes, std::span<const float> numbers, const Mat3& frame, std::span<float> out) {
    std::array<float, kIndirectCoefficients> local;
    for (std::size_t channel = 0; channel < 3; ++channel) {
        for (std::size_t i = 0; i < local.size(); ++i) local[i] = indirectCoefficient(axes, numbers, i)[int(channel)];
        apply(makeShRotation(kIndirectOrder, frame), std::span<const float>(local),
              out.subspan(channel * kIndirectCoefficients, kIndirectCoefficients));
    }
}

}  // namespace

std::vector<float> predictIndirect(const Model& model, std::span<const Affine> bones, std::span<const float> pose,
                                   std::span<const Vec3> normals, int threads) {
    const IndirectModel& indirect = *model.indirect;
    const FeatureRecipe recipe = recipeOf(model);
    std::vector<Mat3> rotations;
    for (const Affine& bone : bones) rotations.push_back(nearestRotation(bone.linear()));
    constexpr std::size_t kStride = 3 * kIndirectCoefficients;
    std::vector<float> out(normals.size() * kStride);
    parallelFor(indirect.clusters.size(), threads, [&](std::size_t c) {
        const ClusterModel& cluster = indirect.clusters[c];
        std::vector<double> raw(recipe.count());
        rawFeatures(recipe, cluster.joint, bones, rotations, pose, raw);
        const std::vector<float> scores = scoreCluster(model.kind, recipe, cluster, raw).scores;
        std::vector<float> numbers = cluster.mean;
        for (std::size_t k = 0; k < scores.size(); ++k)
            for (std::size_t i = 0; i < numbers.size(); ++i)
                numbers[i] += scores[k] * cluster.basis[k * numbers.size() + i];
        for (std::size_t i = 0; i < cluster.vertices.size(); ++i) {
            const std::size_t v = cluster.vertices[i];
            const Vec3 tangent =
                carriedTangent(normals[v], rotations[std::size_t(cluster.joint)], model.rest_tangents[v]);
            toTransfer(indirect.axes, std::span(numbers).subspan(i * kIndirectNumbers, kIndirectNumbers),
                       localFrame(normals[v], tangent), std::span(out).subspan(v * kStride, kStride));
        }
    });
    return out;
}

}  // namespace penumbra
