// Compares models of indirect transfer: the paper's, which have one map for each coefficient in the model frame, and
// ours, which have one model for each cluster in local frames and colour axes. Both are measured as rms of the error of
// the indirect transfer over all vertices, channels and coefficients, divided by the rms of the direct transfer.
// Rotations and orthonormal axes keep both sums.
#include "fit/papers/compare/compare_bounces.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "fit/papers/compare/compare_transfer.h"
#include "fit/papers/transfer/predict_transfer.h"
#include "fit/papers/transfer/transfer_source.h"
#include "fit/visibility/fit_indirect.h"
#include "fit/visibility/predict.h"
#include "fit/visibility/split_frames.h"
#include "formats/common/errors.h"
#include "formats/common/write_file.h"

namespace penumbra {

namespace {

constexpr std::size_t kChannels = 3;

// Returns rows of `from` coefficients cut down to, or filled up with zeros to, `to` of them.
std::vector<float> withCoefficients(const std::vector<float>& rows, std::size_t from, std::size_t to) {
    std::vector<float> out(rows.size() / from * to);
    for (std::size_t r = 0; r < rows.size() / from; ++r)
        std::copy_n(rows.begin() + std::ptrdiff_t(r * from), std::min(from, to), out.begin() + std::ptrdiff_t(r * to));
    return out;
}

// A model of the paper for each channel.
std::vector<TransferModel> fitChannels(const VisibilityReader& reader, const std::string& file,
                                       TransferFitOptions options) {
    std::vector<TransferModel> models;
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
        options.indirect_channel = channel;
        models.push_back(fitTransfer(reader, file, options, {}).model);
    }
    return models;
}

// Returns [V, 3, n].
std::vector<float> predictChannels(const std::vector<TransferModel>& models, std::span<const float> pose, int threads) {
    const std::size_t n = models[0].coefficients(), vertices = models[0].mesh.vertexCount();
    std::vector<float> out(vertices * kChannels * n);
    for (std::size_t channel = 0; channel < kChannels; ++channel) {
        const std::vector<float> one = predictTransfer(models[channel], pose, threads);
        for (std::size_t v = 0; v < vertices; ++v)
            std::copy_n(one.begin() + std::ptrdiff_t(v * n), n,
                        out.begin() + std::ptrdiff_t((v * kChannels + channel) * n));
    }
    return out;
}

// A model whose indirect transfer can be asked for.
struct BouncedContender {
    BouncedRun run;
    std::function<std::vector<float>(const VisibilityFrame& pose)> indirect;  // [V, 3, n]
    std::array<double, 2> squared{};                                          // training, held out
};

BouncedContender fitPaper(const VisibilityReader& reader, const std::string& file, const DirectModel& direct,
                          int threads) {
    TransferFitOptions fit = direct.fit;
    fit.order = reader.header().order;
    const auto models = std::make_shared<std::vector<TransferModel>>(fitChannels(reader, file, fit));
    BouncedContender made{{direct.name, true, 0, 0, 0, {}, {}}, [models, threads](const VisibilityFrame& frame) {
                              return predictChannels(*models, frame.pose, threads);
                          }};
    for (const TransferModel& model : *models) made.run.bytes += paperBytes(model);
    return made;
}

// The model's visibility has no need of the light that bounces, so that it can be added to it.
BouncedContender fitOurs(const VisibilityReader& reader, const std::string& file, const DirectModel& direct,
                         int threads) {
    direct.model->indirect = fitIndirect(*direct.model, reader, file, {.threads = threads}, {}).model;
    BouncedContender made{
        {direct.name, false, 0, 0, 0, {}, {}},
        [model = direct.model, n = reader.header().coefficientCount(), threads](const VisibilityFrame& frame) {
            return withCoefficients(predictIndirect(*model, frame.bones, frame.pose, frame.normals, threads),
                                    kIndirectCoefficients, n);
        }};
    for (const ClusterModel& cluster : direct.model->indirect->clusters)
        made.run.bytes += sizeof(float) * cluster.numberCount();
    return made;
}

// Measures all models on all frames, which are read once.
void measure(const VisibilityReader& reader, const std::vector<std::string>& holdout,
             std::vector<BouncedContender>& contenders, BouncesComparison& comparison) {
    const FrameList& frames = reader.header().frames;
    std::array<double, 2> direct{}, indirect{};  // energies
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        throwIfInterrupted();
        const VisibilityFrame frame = reader.readFrame(f);
        const bool held_out = isHeldOut(holdout, frames, f);
        ++(held_out ? comparison.held_out_frames : comparison.train_frames);
        for (const float t : frame.coefficients) direct[held_out] += double(kChannels) * double(t) * t;
        for (const float t : frame.indirect) indirect[held_out] += double(t) * t;
        for (BouncedContender& one : contenders) {
            std::vector<float> found = one.indirect(frame);
            for (std::size_t i = 0; i < found.size(); ++i) {
                const double difference = double(found[i]) - frame.indirect[i];
                one.squared[held_out] += difference * difference;
            }
            if (f == comparison.pictured_frame) one.run.indirect = std::move(found);
        }
        if (f != comparison.pictured_frame) continue;
        comparison.positions = frame.positions;
        comparison.direct = frame.coefficients;
        comparison.indirect = frame.indirect;
    }
    const auto share = [&](const std::array<double, 2>& squares, bool held_out) {
        return direct[held_out] > 0 ? std::sqrt(squares[held_out] / direct[held_out]) : 0;
    };
    comparison.without_train = share(indirect, false);
    comparison.without_held_out = share(indirect, true);
    for (BouncedContender& one : contenders) {
        one.run.train = share(one.squared, false);
        one.run.held_out = share(one.squared, true);
    }
}

}  // namespace

void checkBounces(const VisibilityHeader& header, const std::string& file, const Mesh& mesh,
                  const std::vector<TransferFitOptions>& fits) {
    if (header.quantity != kDiffuseTransfer || !header.hasBounces())
        throw InvalidInput(file + ": has no light that bounces; bake transfer with 3 bounces");
    if (header.order < kIndirectOrder)
        throw InvalidInput(file + ": sh_order: " + std::to_string(header.order) + "; indirect light needs order " +
                           std::to_string(kIndirectOrder));
    if (header.mesh.rest_positions != mesh.rest_positions || header.mesh.triangles != mesh.triangles)
        throw InvalidInput(file + ": /mesh: the bake is of another character");
    for (TransferFitOptions fit : fits) {
        fit.order = header.order;
        checkTransferFit(header, file, fit);
    }
}

BouncesComparison compareBounces(const VisibilityReader& reader, const std::string& file,
                                 const std::vector<DirectModel>& models, int order, int threads,
                                 const std::function<void(const std::string&)>& phase) {
    const VisibilityHeader& header = reader.header();
    const std::vector<std::string>& holdout = models.front().fit.holdout;
    BouncesComparison comparison;
    comparison.file = file;
    comparison.bounces = header.bounces;
    comparison.order = header.order;
    comparison.pictured_frame = middleHeldOutFrame(header.frames, holdout);
    comparison.pictured_clip = header.frames.clip_names[header.frames.clip[comparison.pictured_frame]];
    std::vector<BouncedContender> contenders;
    for (const DirectModel& direct : models) {
        phase("bounces: " + direct.name);
        contenders.push_back(direct.model ? fitOurs(reader, file, direct, threads)
                                          : fitPaper(reader, file, direct, threads));
    }
    phase("bounces: errors");
    measure(reader, holdout, contenders, comparison);
    const VisibilityFrame pictured = reader.readFrame(comparison.pictured_frame);
    for (std::size_t i = 0; i < models.size(); ++i) {
        BouncedRun& run = comparison.runs.emplace_back(std::move(contenders[i].run));
        run.direct = withCoefficients(models[i].transfer(pictured), std::size_t(order) * std::size_t(order),
                                      comparison.coefficients());
    }
    return comparison;
}

}  // namespace penumbra
