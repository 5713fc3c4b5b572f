#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "fit/models/linear_model.h"
#include "fit/numerics/cross_validation.h"

namespace penumbra::test_cross_validation {
namespace {

FrameList clipsOf(const std::vector<std::size_t>& lengths) {
    FrameList list;
    for (std::size_t c = 0; c < lengths.size(); ++c) {
        list.clip_names.push_back("c" + std::to_string(c));
        for (std::size_t f = 0; f < lengths[c]; ++f) {
            list.clip.push_back(std::uint16_t(c));
            list.time.push_back(double(f));
        }
    }
    return list;
}

std::vector<std::size_t> allFrames(const FrameList& list) {
    std::vector<std::size_t> frames(list.frameCount());
    for (std::size_t f = 0; f < frames.size(); ++f) frames[f] = f;
    return frames;
}

TEST(Folds, AreWholeClipsWhenThereAreEnough) {
    const FrameList list = clipsOf({10, 3, 7, 20, 5});
    const std::vector<int> folds = makeFolds(list, allFrames(list));
    std::map<int, std::set<int>> clips_of_fold;
    for (std::size_t f = 0; f < folds.size(); ++f) clips_of_fold[folds[f]].insert(list.clip[f]);
    EXPECT_EQ(clips_of_fold.size(), 5u);
    for (const auto& [fold, clips] : clips_of_fold) EXPECT_EQ(clips.size(), 1u);
}

// The clips of 20 and 6 frames become 10 + 10 + 6, then 5 + 5 + 10 + 6.
TEST(Folds, CutTheLongestClipIntoContiguousBlocks) {
    const FrameList list = clipsOf({20, 6});
    std::vector<int> expected(5, 2);
    expected.insert(expected.end(), 5, 3);
    expected.insert(expected.end(), 10, 0);
    expected.insert(expected.end(), 6, 1);
    EXPECT_EQ(makeFolds(list, allFrames(list)), expected);
}

TEST(Folds, AreAtMostEightAndBalanced) {
    const FrameList list = clipsOf(std::vector<std::size_t>(20, 5));
    std::map<int, int> size;
    for (int fold : makeFolds(list, allFrames(list))) ++size[fold];
    EXPECT_EQ(size.size(), 8u);
    for (auto [fold, frames] : size) EXPECT_TRUE(frames == 10 || frames == 15) << fold;
}

TEST(Folds, OfOneFrameAreOne) { EXPECT_EQ(makeFolds(clipsOf({1}), std::vector<std::size_t>{0}), std::vector<int>{0}); }

// Returns the squared error of ridge regressions that are fitted again without each fold.
double refittedError(const Matrix& x, const Matrix& y, const std::vector<int>& folds, double alpha) {
    double error = 0;
    for (int fold = 0; fold < 4; ++fold) {
        Matrix x_in(0, x.columns), y_in(0, y.columns), x_out = x_in, y_out = y_in;
        for (std::size_t r = 0; r < x.rows; ++r) {
            Matrix& to_x = folds[r] == fold ? x_out : x_in;
            Matrix& to_y = folds[r] == fold ? y_out : y_in;
            to_x.values.insert(to_x.values.end(), x.row(r).begin(), x.row(r).end());
            to_y.values.insert(to_y.values.end(), y.row(r).begin(), y.row(r).end());
            ++to_x.rows;
            ++to_y.rows;
        }
        const Matrix predicted = predict(fitRidge(x_in, y_in, alpha), x_out);
        for (std::size_t i = 0; i < predicted.values.size(); ++i)
            error += std::pow(predicted.values[i] - y_out.values[i], 2);
    }
    return error;
}

TEST(BlockedErrors, EqualThoseOfRefittedRidges) {
    std::mt19937 random{11};
    std::normal_distribution<double> normal;
    Matrix x(40, 6), y(40, 3);
    for (double& v : x.values) v = normal(random);
    for (std::size_t r = 0; r < 40; ++r)
        for (std::size_t k = 0; k < 3; ++k) y(r, k) = x(r, k) - x(r, 5 - k) + 0.3 * normal(random);
    const FrameList list = clipsOf({10, 12, 9, 9});
    const std::vector<int> folds = makeFolds(list, allFrames(list));
    const std::vector<double> alphas = {1e-3, 1, 20};
    const std::vector<double> errors = blockedErrors(x, y, folds, 1.0, alphas);
    for (std::size_t a = 0; a < alphas.size(); ++a) {
        const double expected = refittedError(x, y, folds, alphas[a]);
        EXPECT_NEAR(errors[a], expected, 1e-9 * expected) << "alpha " << alphas[a];
    }
}

}  // namespace
}  // namespace penumbra::test_cross_validation
