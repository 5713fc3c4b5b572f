#pragma once
// Figure 7 of Nowrouzezahrai 2007: its models on the indirect transfer of a bake with bounces, with our models of light
// that bounces in the same table.
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "fit/papers/transfer/fit_transfer.h"
#include "formats/stage/model_file.h"

namespace penumbra {

// A model whose transfer can be asked for.
struct DirectModel {
    std::string name;
    std::function<std::vector<float>(const VisibilityFrame& pose)> transfer;  // [V, order^2] in the model frame
    TransferFitOptions fit{};                                                 // options of a linear model of transfer
    std::shared_ptr<Model> model{};                                           // set for a model of visibility, else
                                                                              // null
};

// Errors are rms over vertices, channels and coefficients, divided by the rms of the direct transfer.
struct BouncedRun {
    std::string name;
    bool of_paper = true;
    std::size_t bytes = 0;  // 32-bit numbers, of the paper's models as it counts them, in three channels
    double train = 0, held_out = 0;
    std::vector<float> direct, indirect;  // in the pictured frame, [V, n] and [V, 3, n]
};

struct BouncesComparison {
    std::string file;
    int bounces = 0, order = 0;
    std::size_t train_frames = 0, held_out_frames = 0;
    double without_train = 0, without_held_out = 0;  // errors if all indirect light is left out
    std::vector<BouncedRun> runs;
    // A held-out frame: the middle one.
    std::size_t pictured_frame = 0;
    std::string pictured_clip;
    std::vector<Vec3> positions;
    std::vector<float> direct, indirect;  // baked, not predicted

    std::size_t coefficients() const { return std::size_t(order) * std::size_t(order); }
};

// Throws InvalidInput where the bake has no bounces or is not one of the mesh, and what checkTransferFit() throws for
// the models of the paper.
void checkBounces(const VisibilityHeader& header, const std::string& file, const Mesh& mesh,
                  const std::vector<TransferFitOptions>& fits);
// Fits each model to the indirect transfer. Their own has `order` bands. `phase` is told what is done next.
BouncesComparison compareBounces(const VisibilityReader& reader, const std::string& file,
                                 const std::vector<DirectModel>& models, int order, int threads,
                                 const std::function<void(const std::string&)>& phase);

}  // namespace penumbra
