// Tests errors of frames against closed forms, the CSV, and the gate.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "player/render/error_gate.h"
#include "player/render/frame_errors.h"
#include "tests/runtime/synthetic_asset.h"

namespace penumbra::test_frame_figures {
namespace {

using player_test::SyntheticAsset;
using testing::ElementsAre;
using testing::HasSubstr;

ErrorSums errorsAt(const SyntheticAsset& data, std::size_t frame, const TruthMean* mean) {
    Shot look;
    look.asset = &data.asset;
    look.truth = &data.truth;
    PosedFrame posed(look, 2);
    posed.pose(frame, frame);
    return errorsOf(posed, mean);
}

// The truth is unoccluded. Mirrored (D5) that is 1 on the whole sphere, y = sqrt(4 pi) in band 0 alone. The model has
// it times 0.6 + 0.4 cos v, where v counts in each cluster. Then |y' - y|^2 / 4 pi is the square of what is lacking,
// and |E(y') - E(y)| is what is lacking. Measured: 2e-10 and 5e-8.
TEST(FrameErrors, AModelDarkenedByAKnownFactor) {
    const SyntheticAsset data({.basis_size = 0});
    const ErrorSums sums = errorsAt(data, 1, nullptr);
    EXPECT_EQ(sums.vertices, data.asset.mesh.positions.size());
    double squares = 0, ambient = 0;
    for (const ClusterView& cluster : data.asset.model.clusters)
        for (std::size_t v = 0; v < cluster.vertex_count; ++v) {
            const double lacking = 0.4 - 0.4 * std::cos(double(v));
            squares += lacking * lacking;
            ambient += lacking;
        }
    EXPECT_NEAR(sums.rmsV(), std::sqrt(squares / double(sums.vertices)), 1e-6);
    EXPECT_NEAR(sums.ambientMean(), ambient / double(sums.vertices), 1e-6);
    EXPECT_TRUE(std::isnan(sums.relativeError())) << "no mean was given";
}

// Against a mean of 0 the variation is sum |y|^2 = 4 pi a vertex. Measured: 8e-4 of some 15,000, and 1.5e-8.
TEST(FrameErrors, RelativeErrorIsAgainstTheGivenMean) {
    const SyntheticAsset data({.basis_size = 0});
    TruthMean mean;
    mean.coefficients.resize(data.asset.mesh.positions.size() * std::size_t(data.asset.model.stride));
    const ErrorSums sums = errorsAt(data, 1, &mean);
    EXPECT_NEAR(sums.variation, 4 * std::numbers::pi * double(sums.vertices), 0.01);
    EXPECT_NEAR(sums.relativeError(), sums.rmsV(), 1e-6);
}

// Every frame's truth is the same, so the mean over training frames is that truth and nothing varies (measured:
// 9e-12). The stored mean is what a model without components evaluates to (2.4e-7).
TEST(FrameErrors, TheMeanIsOfTrainingFramesOfTheTruth) {
    SyntheticAsset data({.basis_size = 0});
    Shot look;
    look.asset = &data.asset;
    look.truth = &data.truth;
    PosedFrame posed(look, 1);
    const TruthMean mean = truthMean(posed);
    EXPECT_TRUE(mean.from_truth);
    EXPECT_LT(errorsAt(data, 0, &mean).variation, 1e-9);
    for (ClipView& clip : data.asset.animation.clips) clip.held_out = true;
    const TruthMean stored = truthMean(posed);
    EXPECT_FALSE(stored.from_truth);
    posed.pose(0, 0);
    const std::span<const float> model = posed.coefficients(VisibilitySource::kModel);
    for (std::size_t i = 0; i < model.size(); ++i) EXPECT_NEAR(stored.coefficients[i], double(model[i]), 2e-6) << i;
}

TEST(FrameErrors, SumsOverFramesAreTakenBeforeTheyAreDivided) {
    ErrorSums a{1, 10, 2, 0.5, 4 * std::numbers::pi, 1}, b{1, 30, 6, 0.9, 0, 3};
    a.add(b);
    EXPECT_EQ(a.frames, 2u);
    EXPECT_DOUBLE_EQ(a.ambientMean(), 0.2);
    EXPECT_DOUBLE_EQ(a.ambient_max, 0.9);
    EXPECT_DOUBLE_EQ(a.rmsV(), std::sqrt(1.0 / 40));
    EXPECT_DOUBLE_EQ(a.relativeError(), std::sqrt(std::numbers::pi));
}

// --- Pictures -------------------------------------------------------------------------------------------------------

Image flat(int size, float value, float alpha) {
    return {size, size, std::vector<Vec3>(std::size_t(size * size), Vec3{value, value, value} * alpha),
            std::vector<float>(std::size_t(size * size), alpha)};
}

TEST(ImageError, IsInStepsOfEightBitsOverPixelsThatBothCover) {
    // These are the linear values of the bytes 100 and 110.
    Image a = flat(4, linearFromSrgb(100 / 255.0f), 1), b = flat(4, linearFromSrgb(110 / 255.0f), 1);
    EXPECT_DOUBLE_EQ(imageError(a, b, 1, ImageMetrics::kRmse, 1).rmse(), 10);
    EXPECT_TRUE(std::isnan(imageError(a, b, 1, ImageMetrics::kRmse, 1).flip()));
    for (std::size_t i = 0; i < 8; ++i) a.alpha[i] = 0.5f;  // half the pixels do not count, whatever their colour
    const ImageError half = imageError(a, b, 1, ImageMetrics::kRmse, 1);
    EXPECT_EQ(half.pixels, 8u);
    EXPECT_DOUBLE_EQ(half.rmse(), 10);
    EXPECT_TRUE(std::isnan(imageError(flat(4, 1, 0), flat(4, 1, 0), 1, ImageMetrics::kRmseAndFlip, 1).rmse()))
        << "nothing is covered";
    EXPECT_DOUBLE_EQ(imageError(flat(4, 0.1f, 1), flat(4, 0.2f, 1), 100, ImageMetrics::kRmse, 1).rmse(), 0)
        << "both clipped";
}

TEST(ImageError, FlipOfEqualPicturesIsZeroAndOfBlackAndWhiteNearOne) {
    const Image grey = flat(24, 0.3f, 1), white = flat(24, 1, 1), dark = flat(24, 0, 1);
    EXPECT_DOUBLE_EQ(imageError(grey, grey, 1, ImageMetrics::kRmseAndFlip, 2).flip(), 0);
    EXPECT_GT(imageError(white, dark, 1, ImageMetrics::kRmseAndFlip, 2).flip(), 0.95);
    EXPECT_EQ(imageError(white, dark, 1, ImageMetrics::kRmseAndFlip, 2).flip_pixels, 576u);
}

TEST(ImageError, FlipIsTheSameForAnyThreadCountAndWhateverIsFarAway) {
    Image a = flat(64, 0, 0), b = a;
    for (int y = 30; y < 40; ++y)
        for (int x = 20; x < 33; ++x) {
            const std::size_t i = std::size_t(y * 64 + x);
            a.alpha[i] = b.alpha[i] = 1;
            a.pixels[i] = {0.1f * float(x % 5), 0.3f, 0.02f * float(y)};
            b.pixels[i] = {0.3f, 0.1f * float(y % 3), 0.02f * float(x)};
        }
    const ImageError one = imageError(a, b, 1, ImageMetrics::kRmseAndFlip, 1);
    EXPECT_GT(one.flip(), 0.1);
    EXPECT_EQ(imageError(a, b, 1, ImageMetrics::kRmseAndFlip, 7).flip_sum, one.flip_sum);
    // A covered pixel in a corner makes the whole picture the region that is compared.
    a.alpha[0] = b.alpha[0] = a.alpha[4095] = b.alpha[4095] = 1;
    const ImageError whole = imageError(a, b, 1, ImageMetrics::kRmseAndFlip, 1);
    EXPECT_EQ(whole.flip_pixels, one.flip_pixels + 2);
    EXPECT_NEAR(whole.flip_sum, one.flip_sum, 1e-9) << "the two equal pixels add nothing";
}

// --- CSV and gate ---------------------------------------------------------------------------------------------------

AnimationView animation() {
    static const double times[] = {0, 0.5, 1, 0, 0.25};
    AnimationView view;
    view.clips = {{"walk", 0, 3, false}, {"say \"hi\", twice", 3, 2, true}};
    view.times = times;
    return view;
}

// Makes records with the ambient errors of the five frames; a negative one has no truth.
std::vector<FrameRecord> records(const std::vector<double>& errors) {
    std::vector<FrameRecord> list;
    for (std::size_t i = 0; i < errors.size(); ++i) {
        FrameRecord record{{std::size_t(i >= 3), i >= 3 ? i - 3 : i, i, i}};
        record.out_of_range = 0.1 * double(i);
        if (errors[i] >= 0) {
            record.errors = ErrorSums{1, 10, 10 * errors[i], 2 * errors[i], 0, std::nan("")};
            record.errors->tail.add(2 * errors[i]);
        }
        list.push_back(record);
    }
    return list;
}

TEST(FigureCsv, HasARowAFrameAndEmptyFieldsForWhatIsNotMeasured) {
    EXPECT_EQ(figuresCsv(records({0.25, -1, 0.125, 1.0 / 3}), animation()),
              "clip,frame,time,held_out,truth,ambient_error_mean,ambient_error_p999,ambient_error_max,rms_v,relative_"
              "error,image_rmse,flip,"
              "out_of_range,transfer_error\n"
              "walk,0,0,0,1,0.25,0.5,0.5,0,,,,0,0\n"
              "walk,1,0.5,0,0,,,,,,,,0.1,\n"
              "walk,2,1,0,1,0.125,0.25,0.25,0,,,,0.2,0\n"
              "\"say \"\"hi\"\", twice\",0,0,1,1,0.333333333,0.666666667,0.666666667,0,,,,0.3,0\n");
}

std::string messageOf(const ErrorGate& gate, const std::vector<double>& errors) {
    return judge(gate, records(errors), animation()).message;
}

TEST(ErrorGate, PassesOnlyWhenNoFrameIsAbove) {
    EXPECT_EQ(messageOf({.above = 0.3}, {0.1, 0.3, 0.2}), "");
    EXPECT_TRUE(judge({.above = 0.3}, records({0.1, 0.3}), animation()).passed);
    const GateResult result = judge({.above = 0.15}, records({0.1, 0.3, 0.2, 0.25, 0.4}), animation());
    EXPECT_FALSE(result.passed);
    EXPECT_THAT(result.failed, ElementsAre(4, 1, 3, 2));
    EXPECT_EQ(result.message,
              "ambient-mean is above 0.15 in 4 of 5 frames; worst: say \"hi\", twice 1 (0.4), walk 1 (0.3), say "
              "\"hi\", twice 0 (0.25)");
}

TEST(ErrorGate, AShareOfFramesMayBeAbove) {
    EXPECT_EQ(messageOf({.above = 0.2, .percent = 50}, {0.1, 0.3, 0.4, 0.2}), "");
    EXPECT_THAT(messageOf({.above = 0.2, .percent = 49}, {0.1, 0.3, 0.4, 0.2}),
                HasSubstr("in 2 of 4 frames (49% may be)"));
}

TEST(ErrorGate, OneFigureOverTheRun) {
    EXPECT_EQ(messageOf({.above = 0.2, .over_run = true}, {0.1, 0.3}), "") << "the mean is 0.2";
    EXPECT_THAT(messageOf({.above = 0.19, .over_run = true}, {0.1, 0.3}),
                HasSubstr("ambient-mean is 0.2, above 0.19, over 2 frames; worst: walk 1 (0.3)"));
    EXPECT_THAT(messageOf({.figure = Figure::kAmbientMax, .above = 0.5, .over_run = true}, {0.1, 0.3}),
                HasSubstr("ambient-max is 0.6, above 0.5, over 2 frames"));
    EXPECT_THAT(messageOf({.figure = Figure::kAmbientTail, .above = 0.5, .over_run = true}, {0.1, 0.3}),
                HasSubstr("ambient-p999 is 0.6, above 0.5, over 2 frames"));
}

TEST(ErrorGate, WhatWasNotMeasuredNeverPasses) {
    for (const bool over_run : {false, true}) {
        EXPECT_THAT(messageOf({.above = 1, .over_run = over_run}, {0.1, -1, 0.2, -1}),
                    HasSubstr("2 of 4 frames have no ambient-mean (the first: walk 1)"));
        EXPECT_THAT(messageOf({.above = 1, .over_run = over_run}, {}), HasSubstr("nothing was compared"));
    }
    EXPECT_THAT(messageOf({.figure = Figure::kRelative, .above = 1}, {0.1}),
                HasSubstr("1 of 1 frames have no relative"));
    EXPECT_THAT(messageOf({.figure = Figure::kFlip, .above = 1}, {0.1}), HasSubstr("no flip"));
    EXPECT_EQ(messageOf({.figure = Figure::kOutOfRange, .above = 1}, {-1, -1}), "") << "it needs no truth";
}

// One number of one vertex is NaN, and one colour of a pixel, which a PNG shows as black as the truth is there.
TEST(ErrorGate, NaNNeverPasses) {
    SyntheticAsset data({.basis_size = 0});
    NumbersView& mean = data.asset.model.clusters[0].mean;
    std::vector<float> coefficients(mean.count);
    decode(mean, coefficients);
    coefficients[0] = NAN;
    mean.data = reinterpret_cast<const std::byte*>(coefficients.data());
    Image model = flat(24, 0, 1);
    const Image truth = model;
    model.pixels[5].y = NAN;
    FrameRecord record;
    record.errors = errorsAt(data, 1, nullptr);
    record.image = imageError(model, truth, 1, ImageMetrics::kRmseAndFlip, 1);
    for (const Figure figure : {Figure::kAmbientMean, Figure::kAmbientMax, Figure::kRmsV, Figure::kTransfer,
                                Figure::kImageRmse, Figure::kFlip})
        for (const bool over_run : {false, true})
            EXPECT_FALSE(
                judge({.figure = figure, .above = 1e9, .over_run = over_run}, {&record, 1}, animation()).passed)
                << nameOf(figure);
}

}  // namespace
}  // namespace penumbra::test_frame_figures
