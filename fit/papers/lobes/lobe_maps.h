#pragma once
// Fits zonal lobes to the visibility of some vertices and regresses them on the pose (Nowrouzezahrai 2008,
// section 3.1). The fit of a model and the comparison with other models both come here, so that their figures are of
// one thing.
#include <span>
#include <vector>

#include "fit/papers/lobes/pose_map.h"
#include "fit/papers/lobes/vertex_lobes.h"
#include "fit/visibility/local_coefficients.h"
#include "formats/stage/lobe_file.h"

namespace penumbra {

constexpr double kLobeInputVariance = 0.9;  // of the joint angles, as Nowrouzezahrai 2009 and 2007 keep

struct LobeSource {
    const VisibilityReader& reader;
    const PoseTable& poses;
    LocalFrames frames;
    std::span<const std::size_t> train;          // frames, ascending
    int order = 4;                               // bands, of convention B
    double input_variance = kLobeInputVariance;  // share of the variance of the joint angles that their components keep
    int threads = 0;
};

// Returns at most so many vertices, spread over the mesh. The ridge is chosen with kLobeSample of them.
constexpr std::size_t kLobeSample = 64;
std::vector<std::uint32_t> sampleVertices(std::size_t vertices, std::size_t most = kLobeSample);

// Reads the numbers of some vertices, [F, V order^2].
MatrixF readLobeCoefficients(const LobeSource& source, const std::vector<std::uint32_t>& vertices,
                             const NumberForm& form);

// The lobes of some vertices as functions of the pose, in the layout of LobeModel.
struct LobeMaps {
    std::vector<Vec3> axes;         // [V, C]
    std::vector<float> weights;     // [V, I + 1, C (2 + order)]
    double error = 0, squares = 0;  // sums of squares of what the lobes leave before any regression, and of all
};
// `inputs` are those of all frames, [F, I].
LobeMaps fitLobeMaps(const LobeProblem& problem, const MatrixF& visibility, const Matrix& inputs, int threads);

// Writes the visibility of one vertex. `axes` and `weights` are its own.
void evaluateLobes(int order, std::span<const Vec3> axes, std::span<const float> weights,
                   std::span<const double> inputs, std::span<double> out);
// Returns the visibility of all vertices in some frames, [frames, V order^2].
Matrix predictLobes(int order, int lobes, const LobeMaps& maps, const Matrix& inputs,
                    std::span<const std::size_t> frames, int threads);

// Returns the ridge whose models have the smallest error on folds of the training frames that they have not seen, as
// makeFolds() cuts them. A fold enters its models by nothing but the lobes of the mean, from which all fits start.
double chooseLobeRidge(const LobeSource& source, const MatrixF& visibility, int lobes);

// The error |v^ - v| / |v| of all vertices of a frame together: its mean over frames, and its deviation.
struct FrameSpread {
    double mean = 0, deviation = 0;
};
// Sums of squares of the error and of the truth, frame by frame.
struct FrameSquares {
    std::vector<double> error, truth;
};
FrameSpread spreadOver(const FrameSquares& squares, std::span<const std::size_t> frames);

}  // namespace penumbra
