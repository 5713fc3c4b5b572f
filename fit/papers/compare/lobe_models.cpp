#include "fit/papers/compare/lobe_models.h"

#include <algorithm>
#include <cmath>

#include "fit/papers/compare/paper_forms.h"
#include "sh/brdf/phong_matrix.h"

namespace penumbra {

namespace {

// Numbers of the sampled vertices in all frames, [F, V order^2].
struct ChosenVertices {
    MatrixF visibility, cosine;
};

// The errors over held-out frames. `predicted` has a row for each of them.
FrameSpread heldOutErrors(const Matrix& predicted, const MatrixF& truth, std::span<const std::size_t> held_out) {
    FrameSquares squares{std::vector<double>(truth.rows), std::vector<double>(truth.rows)};
    for (std::size_t r = 0; r < held_out.size(); ++r)
        for (std::size_t c = 0; c < truth.columns; ++c) {
            const double number = double(truth(held_out[r], c)), difference = predicted(r, c) - number;
            squares.error[held_out[r]] += difference * difference;
            squares.truth[held_out[r]] += number * number;
        }
    return spreadOver(squares, held_out);
}

// Trains a linear map of SH on the training frames, and returns its predictions of the held-out ones.
Matrix regress(const Matrix& inputs, const MatrixF& coefficients, const CompareCharacter& character) {
    Matrix outputs(coefficients.rows, coefficients.columns);
    std::ranges::copy(coefficients.values, outputs.values.begin());
    const std::vector<float> map = fitPoseMap(inputs, outputs, character.train);
    Matrix predicted(character.held_out.size(), coefficients.columns);
    for (std::size_t r = 0; r < predicted.rows; ++r)
        applyPoseMap(map, inputs.row(character.held_out[r]), predicted.row(r));
    return predicted;
}

// Multiplies visibility by the cosine: M^1 of Nowrouzezahrai 2008 for every vertex.
Matrix withCosine(const Matrix& visibility, int order) {
    const std::size_t n = std::size_t(coefficientCount(order));
    const std::vector<double> m = phongMatrix(1, order);
    Matrix out(visibility.rows, visibility.columns);
    for (std::size_t f = 0; f < out.rows; ++f)
        for (std::size_t first = 0; first < out.columns; first += n)
            for (std::size_t i = 0; i < n; ++i)
                for (std::size_t j = 0; j < n; ++j) out(f, first + i) += m[i * n + j] * visibility(f, first + j);
    return out;
}

}  // namespace

LobeComparison compareLobes(const CompareInput& input, const CompareCharacter& character, const CompareOptions& options,
                            const std::function<void(double)>& progress) {
    const VisibilityHeader& header = input.reader.header();
    const LobeSource source{input.reader,
                            input.poses,
                            character.frames(),
                            character.train,
                            std::min(4, header.order - 1),  // the cosine takes one band more
                            kLobeInputVariance,
                            options.threads};
    const std::vector<std::uint32_t> vertices = sampleVertices(header.mesh.vertexCount());
    const ChosenVertices sample{readLobeCoefficients(source, vertices, kVisibilityForm),
                                readLobeCoefficients(source, vertices, kCosineForm)};
    const Matrix inputs =
        componentsOfFrames(poseComponents(input.poses, character.train, source.input_variance), input.poses);
    LobeComparison comparison{vertices.size(), inputs.columns, source.order, {}};
    const auto add = [&](std::string name, double fitted, double ridge, const Matrix& predicted) {
        comparison.models.push_back(
            {std::move(name), fitted, ridge, heldOutErrors(predicted, sample.visibility, character.held_out),
             heldOutErrors(withCosine(predicted, source.order), sample.cosine, character.held_out)});
    };
    add("SH", 0, 0, regress(inputs, sample.visibility, character));
    comparison.models.push_back(
        {"SH x cosine",
         0,
         0,
         {NAN, NAN},
         heldOutErrors(regress(inputs, sample.cosine, character), sample.cosine, character.held_out)});
    for (std::size_t i = 0; i < options.lobes.size(); ++i) {
        if (progress) progress(double(i) / double(options.lobes.size()));
        const int count = options.lobes[i];
        const LobeProblem problem{source.order, count, chooseLobeRidge(source, sample.visibility, count), source.train};
        const LobeMaps maps = fitLobeMaps(problem, sample.visibility, inputs, options.threads);
        add(std::to_string(count) + (count == 1 ? " lobe" : " lobes"),
            maps.squares > 0 ? std::sqrt(maps.error / maps.squares) : 0, problem.ridge,
            predictLobes(source.order, count, maps, inputs, character.held_out, options.threads));
    }
    return comparison;
}

}  // namespace penumbra
