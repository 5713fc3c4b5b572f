#include "fit/lobes/predict_lobe_file.h"

#include <algorithm>

#include "fit/lobes/lobe_maps.h"
#include "fit/visibility/predict.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/stage/same_character.h"

namespace penumbra {

std::vector<float> predictLobeNumbers(const LobeModel& model, std::span<const float> pose, int threads) {
    const std::size_t n = std::size_t(model.order) * std::size_t(model.order), vertices = model.mesh.vertexCount(),
                      size = (model.inputs() + 1) * model.numbersOfVertex();
    const std::vector<double> inputs = PoseComponents{model.pose_mean, model.pose_basis}.of(pose);
    std::vector<float> numbers(vertices * n);
    constexpr std::size_t kBlock = 256;
    parallelFor((vertices + kBlock - 1) / kBlock, threads, [&](std::size_t block) {
        std::vector<double> one(n);
        for (std::size_t v = block * kBlock; v < std::min((block + 1) * kBlock, vertices); ++v) {
            evaluateLobes(model.order, std::span(model.axes).subspan(v * model.lobes, model.lobes),
                          std::span(model.weights).subspan(v * size, size), inputs, one);
            for (std::size_t i = 0; i < n; ++i) numbers[v * n + i] = float(one[i]);
        }
    });
    return numbers;
}

void checkCharacter(const LobeModel& model, const VisibilityHeader& header, const std::string& file) {
    checkSameCharacter({model.mesh, model.skin, model.input_names, model.pose_mean.size()}, header, file);
}

void predictLobeFile(const LobeModel& model, const VisibilityReader& poses, const LobePrediction& to,
                     const std::function<void(double)>& progress) {
    const Convention convention{BelowHorizon::kBlocked, model.order};
    const LocalFrames frames{&model.rest_tangents, &model.cluster_of_vertex, model.joint_of_cluster};
    VisibilityWriter writer(to.output, predictionHeader(convention, poses.header(), to.provenance),
                            Precision::kFloat32);
    for (std::size_t f = 0; f < poses.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        VisibilityFrame frame = poses.readPose(f);
        frame.coefficients = toModelFrame(convention, frames, frame.bones, frame.normals,
                                          predictLobeNumbers(model, frame.pose, to.threads), to.threads);
        writer.writeFrame(frame);
        if (progress) progress(double(f + 1));
    }
    writer.finish();
}

}  // namespace penumbra
