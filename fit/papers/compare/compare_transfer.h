#pragma once
// Compares the linear models of transfer with one another, and with models of visibility of the same bake, in one
// measure: transfer in the model frame.
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "fit/papers/compare/compare_bounces.h"
#include "fit/papers/compare/compare_figures.h"
#include "fit/papers/transfer/fit_transfer.h"

namespace penumbra {

struct TransferCompareOptions {
    int order = 6;  // SH bands of the transfer
    // Components of the angles and of the vertices of each reduced model; the paper's two.
    std::vector<std::pair<std::size_t, std::size_t>> components{{15, 500}, {8, 22}};
    std::vector<std::string> holdout;
    // Models of visibility beside them, where the bake is of visibility.
    CompareOptions visibility;
    int threads = 0;
};

// The signed differences of predicted and baked coefficients (Nowrouzezahrai 2007, figure 2).
struct Residuals {
    static constexpr std::size_t kBins = 121;  // over [-kRange, kRange]; the outer ones have all that lies beyond
    static constexpr double kRange = 0.15;
    std::array<double, kBins> count{};
    double sum = 0, squares = 0, total = 0;

    void add(double residual);
    double mean() const { return sum / total; }
    double variance() const { return squares / total - mean() * mean(); }
    double median() const;  // the middle of its bin
};

struct TransferRun {
    std::string name;         // "L", "PCA(8,22)", "additive, D5"
    bool of_paper = true;     // else a model of visibility
    bool regularised = true;  // alpha by leave-one-out; false: alpha 0
    double alpha = 0;
    std::size_t bytes = 0;  // counted like the paper; for a model of visibility all its 32-bit numbers but the fields
    double megaops = 0;     // operations in the paper's table 1, for one coefficient; 0 for models of visibility
    double fit_seconds = 0, pca_seconds = 0;  // the second is a part of the first
    double frame_ms = 0;  // pose to shading on one thread, light first; of visibility pose to numbers
    // Relative errors in the model frame and in local frames, and E_transfer.
    TransferErrors train, held_out;
    double local_train = 0, local_held_out = 0;
    std::optional<Residuals> residuals{};  // over training frames; of the regularised L alone
    std::vector<float> pictured{};         // transfer in the pictured frame, [V, n]; of regularised ones alone
};

struct TransferComparison {
    TransferCompareOptions options;
    std::size_t vertices = 0, angles = 0, train_frames = 0, held_out_frames = 0;
    std::size_t frame_bytes = 0;  // transfer of one pose in 32-bit numbers
    std::vector<TransferRun> runs;
    EigenvalueDecay pose_decay, transfer_decay;
    // A held-out frame: the middle one.
    std::size_t pictured_frame = 0;
    std::string pictured_clip;
    std::vector<Vec3> positions, normals;
    std::vector<float> truth;  // [V, n]
    std::optional<BouncesComparison> bounces;

    std::size_t coefficients() const { return std::size_t(options.order) * std::size_t(options.order); }
};

// A bake with bounces and its name.
struct BouncesBake {
    const VisibilityReader* reader = nullptr;
    std::string file;
};

// Returns the middle one of the held-out frames.
std::size_t middleHeldOutFrame(const FrameList& frames, const std::vector<std::string>& holdout);

// Throws what checkTransferFit() throws for each of the fits, and UsageError without held-out clips. `bounces` may be
// null; else it throws what checkBounces() throws.
void checkTransferComparison(const VisibilityHeader& header, const std::string& file,
                             const TransferCompareOptions& options, const BouncesBake* bounces);
// `bounces` is the same, and adds figure 7. `phase` is told what is done next.
TransferComparison compareTransferModels(const VisibilityReader& reader, const std::string& file,
                                         const TransferCompareOptions& options, const BouncesBake* bounces,
                                         const std::function<void(const std::string&)>& phase);

// The figures 2 to 5, 7 and the tables 1 and 2 of Nowrouzezahrai 2007, in transfer_figures.cpp.
Table transferSummary(const TransferComparison& comparison);
std::string transferFinding(const TransferComparison& comparison);
std::vector<Figure> transferFigures(const TransferComparison& comparison);

}  // namespace penumbra
