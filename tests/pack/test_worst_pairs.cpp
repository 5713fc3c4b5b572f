#include <gtest/gtest.h>

#include <algorithm>

#include "pack/check/worst_pairs.h"

namespace penumbra::test_worst_pairs {
namespace {

// Vertices along a line of length 10, 0.1 apart, so that a neighbourhood of 3% is 0.3 long. Two clips of four frames.
struct Line {
    std::vector<Vec3> positions;
    AssetView asset;
    FrameList frames{{"run", "walk"}, {0, 0, 0, 0, 1, 1, 1, 1}, {0, 0.1, 0.2, 1, 0, 0.1, 0.2, 1}};

    Line() {
        for (int v = 0; v <= 100; ++v) positions.push_back({0.1f * float(v), 0, 0});
        asset.mesh.positions = positions;
    }
    std::vector<PlaceError> chosen(const PlaceSpread& spread, const std::vector<PlaceError>& errors) const {
        WorstPairs worst(asset, frames, spread);
        for (std::size_t f = 0; f < frames.frameCount(); ++f) {
            std::vector<float> model(positions.size(), 1), truth(positions.size(), 1);
            for (const PlaceError& error : errors)
                if (error.frame == f) truth[error.vertex] = error.e_truth, model[error.vertex] = error.e_model;
            worst.addFrame(f, model, truth);
        }
        return worst.chosen();
    }
};

std::vector<std::pair<std::size_t, std::uint32_t>> placesOf(const std::vector<PlaceError>& pairs) {
    std::vector<std::pair<std::size_t, std::uint32_t>> places;
    for (const PlaceError& pair : pairs) places.emplace_back(pair.frame, pair.vertex);
    return places;
}

using Places = std::vector<std::pair<std::size_t, std::uint32_t>>;

TEST(WorstPairs, AreSortedByTheSizeOfTheError) {
    const std::vector<PlaceError> pairs =
        Line().chosen({}, {{0, 10, 0.5f, 0.7f}, {4, 50, 0.9f, 0.1f}, {5, 90, 0.1f, 0.6f}});
    EXPECT_EQ(placesOf(pairs), (Places{{4, 50}, {5, 90}, {0, 10}}));
    EXPECT_EQ(pairs[0].e_model, 0.9f);
    EXPECT_EQ(pairs[0].e_truth, 0.1f);
}

TEST(WorstPairs, OneFaultOfARunOfFramesIsOnePlace) {
    const Line line;
    EXPECT_EQ(placesOf(line.chosen({}, {{0, 10, 0, 0.5f}, {1, 11, 0, 0.8f}, {2, 12, 0, 0.6f}})), (Places{{1, 11}}));
    // Another run, another clip, and what is farther away count.
    EXPECT_EQ(placesOf(line.chosen({}, {{1, 11, 0, 0.8f}, {3, 11, 0, 0.7f}, {5, 11, 0, 0.6f}, {1, 20, 0, 0.5f}})),
              (Places{{1, 11}, {3, 11}, {5, 11}, {1, 20}}));
}

TEST(WorstPairs, FewCountOfANeighbourhood) {
    const std::vector<PlaceError> errors = {{0, 11, 0, 0.8f}, {3, 11, 0, 0.7f}, {4, 11, 0, 0.6f}, {4, 70, 0, 0.1f}};
    EXPECT_EQ(placesOf(Line().chosen({.per_neighbourhood = 2}, errors)), (Places{{0, 11}, {3, 11}, {4, 70}}));
    EXPECT_EQ(placesOf(Line().chosen({.count = 1}, errors)), (Places{{0, 11}}));
}

TEST(WorstPairs, MemoryIsBoundedAndTheWorstStays) {
    const Line line;
    FrameList frames;
    frames.clip_names = {"long"};
    frames.clip.assign(3000, 0);
    for (int f = 0; f < 3000; ++f) frames.time.push_back(f);
    WorstPairs worst(line.asset, frames, {.count = 2, .per_neighbourhood = 100});
    std::vector<float> model(line.positions.size()), truth(line.positions.size(), 0.25f);
    for (std::size_t f = 0; f < 3000; ++f) {
        truth[40] = f == 17 ? 0.9f : 0.3f;
        truth[60] = f == 2900 ? 0.8f : 0.3f;
        worst.addFrame(f, model, truth);
    }
    EXPECT_EQ(placesOf(worst.chosen()), (Places{{17, 40}, {2900, 60}}));
}

}  // namespace
}  // namespace penumbra::test_worst_pairs
