// Finds the patterns of values over time.
//
// Problem: A [F, V] holds F frames of V vertices. Find K patterns D [K, V] and weights W [F, K] so that mean + W D is
// as near to A as K of them can be (Eckart and Young 1936: the leading singular vectors).
//
// Naive: a singular value decomposition of A - mean, which is [275, 13380] for one clip and takes seconds.
//
// Here: the axes of the Gram matrix B B^T of the centred rows, which is only F x F. Its eigenvectors are the left
// singular vectors U, and D = U^T B. The error of K patterns is the sum of the eigenvalues that are left out.
#include "pack/export/principal_weights.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "formats/common/errors.h"
#include "pack/compress/dense_solvers.h"

namespace penumbra {

namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::size_t chooseCount(const PrincipalWeights& found, const PatternChoice& choice) {
    const std::size_t all = found.rms_of_count.size() - 1;
    if (choice.count > 0) return std::min(choice.count, all);
    if (choice.max_rms <= 0) return all;
    std::size_t count = 0;
    while (count < all && found.rms_of_count[count] > choice.max_rms) ++count;
    return count;
}

// The values ascend no more: what rounding makes of an eigenvalue of 0 is below a 1e-12th of the largest one.
void measureCounts(const Eigen::VectorXd& energies, double numbers, PrincipalWeights& out) {
    double left = 0;
    std::vector<double> from_last;
    const double least = energies.size() > 0 ? 1e-12 * std::max(energies[0], 0.0) : 0;
    for (Eigen::Index k = energies.size(); k-- > 0;) {
        if (!(energies[k] > least)) continue;
        from_last.push_back(std::sqrt(left / numbers));
        left += energies[k];
    }
    from_last.push_back(std::sqrt(left / numbers));
    out.rms_of_count.assign(from_last.rbegin(), from_last.rend());
}

// Fills weights and components from the axes of the frames, and makes the largest weight of each 1.
void takeComponents(const RowMatrix& centred, const Eigen::MatrixXd& axes, PrincipalWeights& out) {
    const Eigen::Index frames = centred.rows(), vertices = centred.cols(), count = Eigen::Index(out.count);
    RowMatrix components = axes.leftCols(count).transpose() * centred;
    out.weights.resize(std::size_t(frames * count));
    for (Eigen::Index k = 0; k < count; ++k) {
        Eigen::Index largest = 0;
        const double scale = axes.col(k).cwiseAbs().maxCoeff(&largest) * (axes(largest, k) < 0 ? -1 : 1);
        components.row(k) *= scale;
        for (Eigen::Index f = 0; f < frames; ++f) out.weights[std::size_t(f * count + k)] = float(axes(f, k) / scale);
    }
    out.components.resize(std::size_t(count * vertices));
    std::transform(components.data(), components.data() + components.size(), out.components.begin(),
                   [](double x) { return float(x); });
}

// Measures what a player shows, with the numbers as they are stored.
void measureErrors(std::span<const float> values, std::size_t frames, PrincipalWeights& out) {
    const std::size_t vertices = out.mean.size();
    double squares = 0;
    std::vector<double> shown(vertices);
    for (std::size_t f = 0; f < frames; ++f) {
        std::copy(out.mean.begin(), out.mean.end(), shown.begin());
        for (std::size_t k = 0; k < out.count; ++k) {
            const double weight = double(out.weights[f * out.count + k]);
            for (std::size_t v = 0; v < vertices; ++v) shown[v] += weight * double(out.components[k * vertices + v]);
        }
        for (std::size_t v = 0; v < vertices; ++v) {
            const double difference = shown[v] - double(values[f * vertices + v]);
            squares += difference * difference;
            out.max = std::max(out.max, std::abs(difference));
        }
    }
    out.rms = std::sqrt(squares / double(values.size()));
}

}  // namespace

PrincipalWeights principalWeights(std::span<const float> values, std::size_t frames, const PatternChoice& choice) {
    const std::size_t vertices = values.size() / frames;
    if (frames > kMaxFrames && vertices > kMaxFrames)
        throw Unsupported(std::to_string(frames) + " frames are too many for morph targets; at most " +
                          std::to_string(kMaxFrames) + ": choose fewer clips or a lower rate");
    RowMatrix centred = Eigen::Map<const Eigen::Matrix<float, -1, -1, Eigen::RowMajor>>(
                            values.data(), Eigen::Index(frames), Eigen::Index(vertices))
                            .cast<double>();
    PrincipalWeights out;
    for (Eigen::Index v = 0; v < centred.cols(); ++v) out.mean.push_back(float(centred.col(v).mean()));
    for (Eigen::Index v = 0; v < centred.cols(); ++v) centred.col(v).array() -= double(out.mean[std::size_t(v)]);
    SymmetricAxes found;
    if (frames <= vertices) {
        found = symmetricAxes(centred * centred.transpose());
    } else {
        // Fewer vertices than frames: the other Gram matrix, of which U = B V / sigma.
        found = symmetricAxes(centred.transpose() * centred);
        found.axes = (centred * found.axes).colwise().normalized().eval();
    }
    measureCounts(found.values, double(values.size()), out);
    out.count = chooseCount(out, choice);
    takeComponents(centred, found.axes, out);
    measureErrors(values, frames, out);
    return out;
}

}  // namespace penumbra
