// The loops that multiply far parts into one another, against farVisibility().
#include <gtest/gtest.h>

#include "pack/pack_asset.h"
#include "runtime/evaluate/evaluator.h"
#include "tests/difference.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_far_kernel {
namespace {

using synthetic::composedTube;

const synthetic::TubeOptions kTube{
    .rings = 20, .segments = 9, .joints = 6, .clusters = 4, .components = 5, .inputs = 4};

// Receivers all over the tube and inside its balls.
struct ScatteredReceivers {
    std::vector<Vec3> positions, normals, tangents;

    ScatteredReceivers() {
        synthetic::Noise noise(3);
        for (std::size_t i = 0; i < 1021; ++i) {
            const float size = i % 5 == 0 ? 30.0f : 0.4f;
            positions.push_back(Vec3{noise(), 2 + 2.5f * noise(), noise()} * size);
            normals.push_back(normalized(Vec3{noise(), noise(), noise()}));
            if (i < 3) normals.back() = {0, i == 1 ? -1.0f : 0.0f, i == 1 ? 0.0f : 1.0f};
            tangents.push_back(normalized(cross(normals.back(), Vec3{noise(), noise(), noise()})));
        }
    }
};

// The parts of a tube, in one of its poses.
struct PosedTube {
    Packed packed = packAsset(composedTube(kTube), {}, {}, {.precision = AssetPrecision::kF32}, "{}", 1);
    AssetView asset = openAsset(packed.bytes);
    FarTables tables = makeFarTables(*asset.model.composition, 5);
    FarPose pose{tables};

    PosedTube() { pose.set(tables, asset.animation.bonesOf(1)); }
};

struct KernelError {
    Largest largest, blocked;  // blocked: most of the sphere
    double squares = 0;
    std::size_t count = 0;

    void add(double off) {
        largest.add(std::abs(off));
        squares += off * off;
        ++count;
    }
    double rms() const { return std::sqrt(squares / double(count)); }
};

// Compares a path with farVisibility() for receivers that see `parts`, all of which are multiplied in.
KernelError kernelError(const EvaluatorPath& path, const std::vector<std::uint16_t>& parts) {
    const PosedTube tube;
    const FarTables& tables = tube.tables;
    const FarPose& pose = tube.pose;
    const ScatteredReceivers all;
    const FarScene scene{tables.tables(), pose.parts.data(), parts.data(), parts.size()};
    KernelError error;
    std::vector<float> far(kMaxReceivers * kFarCoefficients), expected(kFarCoefficients);
    for (std::size_t first = 0; first < all.positions.size(); first += kMaxReceivers) {
        const std::size_t count = std::min(kMaxReceivers, all.positions.size() - first);
        path.far->far(tables.constants(), scene, {},
                      {&all.positions[first], &all.normals[first], &all.tangents[first], count}, far.data());
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t r = first + i;
            farVisibility(tables.fields(), pose.posed, parts, {all.positions[r], all.normals[r], all.tangents[r]},
                          expected);
            for (std::size_t n = 0; n < kFarCoefficients; ++n) error.add(far[i * kFarCoefficients + n] - expected[n]);
            error.blocked.add(1 - expected[0] / std::sqrt(4 * std::numbers::pi));
        }
    }
    return error;
}

// A product of two functions comes back from the directions exactly, so that what is left is the rounding of the
// weights of corners to 15 bits. Far numbers reach 3.5. Measured: rms 5e-6, 4.2e-4 at most.
TEST(FarKernel, MatchesFarVisibilityForTwoPartsOnEveryPath) {
    for (const EvaluatorPath& path : evaluatorPaths())
        for (const std::vector<std::uint16_t>& parts : {std::vector<std::uint16_t>{}, {2}, {2, 4}, {3, 5}}) {
            const KernelError error = kernelError(path, parts);
            EXPECT_LT(error.rms(), 1e-5) << path.name;
            EXPECT_LT(error.largest, 6e-4) << path.name;
            EXPECT_TRUE(error.blocked > 0.2 || parts.empty());
        }
}

// farVisibility() cuts each product off at order 6, and the directions do not. Measured: rms .0011 and .023 at most.
TEST(FarKernel, IsCloseToFarVisibilityForManyParts) {
    for (const EvaluatorPath& path : evaluatorPaths()) {
        const KernelError error = kernelError(path, {0, 1, 2, 3, 4, 5});
        EXPECT_LT(error.rms(), 0.002) << path.name;
        EXPECT_LT(error.largest, 0.05) << path.name;
    }
}

// Gains of near parts at random, some of them 0 and some above 1.
std::vector<std::uint8_t> randomGains(std::size_t count) {
    synthetic::Noise noise(7);
    std::vector<std::uint8_t> gains;
    for (std::size_t i = 0; i < count; ++i)
        gains.push_back(i % 5 == 0 ? std::uint8_t(0) : std::uint8_t(127.5f * (1 + noise())));
    return gains;
}

// Compares a path with farVisibility() and multiplyByNear(), for receivers with gains of their own.
KernelError nearError(const EvaluatorPath& path, const std::vector<std::uint16_t>& parts,
                      const std::vector<std::uint16_t>& near_parts) {
    const PosedTube tube;
    const FarTables& tables = tube.tables;
    const FarPose& pose = tube.pose;
    const ScatteredReceivers all;
    const std::size_t columns = near_parts.size();
    const std::vector<std::uint8_t> gains = randomGains(all.positions.size() * columns);
    const FarScene scene{tables.tables(), pose.parts.data(), parts.data(), parts.size(), 0, near_parts.data(), columns};
    KernelError error;
    std::vector<float> far(kMaxReceivers * kFarCoefficients), expected(kFarCoefficients);
    for (std::size_t first = 0; first < all.positions.size(); first += kMaxReceivers) {
        const std::size_t count = std::min(kMaxReceivers, all.positions.size() - first);
        path.far->far(
            tables.constants(), scene, {},
            {&all.positions[first], &all.normals[first], &all.tangents[first], count, &gains[first * columns]},
            far.data());
        for (std::size_t i = 0; i < count; ++i) {
            const std::size_t r = first + i;
            const Receiver receiver{all.positions[r], all.normals[r], all.tangents[r]};
            std::vector<NearPart> nears;
            for (std::size_t n = 0; n < columns; ++n)
                if (near_parts[n] != kNoPart) nears.push_back({near_parts[n], float(gains[r * columns + n]) / 128});
            farVisibility(tables.fields(), pose.posed, parts, receiver, expected);
            const float before = expected[0];
            multiplyByNear(tables.fields(), pose.posed, nears, receiver, expected);
            for (std::size_t n = 0; n < kFarCoefficients; ++n) error.add(far[i * kFarCoefficients + n] - expected[n]);
            error.blocked.add((before - expected[0]) / std::sqrt(4 * std::numbers::pi));
        }
    }
    return error;
}

// As with two far parts, the product is exact but for the weights of corners.
TEST(FarKernel, MatchesThePlainFormForNearPartsOnEveryPath) {
    for (const EvaluatorPath& path : evaluatorPaths())
        for (const auto& [parts, near_parts] :
             {std::pair{std::vector<std::uint16_t>{}, std::vector<std::uint16_t>{3}},
              {std::vector<std::uint16_t>{2}, std::vector<std::uint16_t>{kNoPart, 4}},
              {std::vector<std::uint16_t>{}, std::vector<std::uint16_t>{5, kNoPart, 1}}}) {
            const KernelError error = nearError(path, parts, near_parts);
            EXPECT_LT(error.rms(), 1e-5) << path.name;
            EXPECT_LT(error.largest, 6e-4) << path.name;
            EXPECT_GT(error.blocked, 0.1) << path.name;
        }
}

// As with many far parts, the plain form cuts each product off at order 6, and the directions do not.
TEST(FarKernel, IsCloseToThePlainFormForManyNearParts) {
    for (const EvaluatorPath& path : evaluatorPaths()) {
        const KernelError error = nearError(path, {0, 2}, {1, 3, 4, 5});
        EXPECT_LT(error.rms(), 0.002) << path.name;
        EXPECT_LT(error.largest, 0.05) << path.name;
    }
}

// With a gain of 1 a near part is a far one, and with 0 it is none.
TEST(FarKernel, NearPartsWithAGainOfOneAreFarParts) {
    const PosedTube tube;
    const FarTables& tables = tube.tables;
    const FarPose& pose = tube.pose;
    const ScatteredReceivers all;
    const std::vector<std::uint16_t> parts{0, 2, 3, 5}, near_parts{2, 3, 5};
    std::vector<std::uint8_t> gains;
    for (std::size_t r = 0; r < kMaxReceivers; ++r) gains.insert(gains.end(), {128, 0, 128});
    const std::vector<std::uint16_t> same{0, 2, 5};
    std::vector<float> near_numbers(kMaxReceivers * kFarCoefficients), far_coefficients(near_numbers.size());
    const FarReceivers receivers{all.positions.data(), all.normals.data(), all.tangents.data(), kMaxReceivers,
                                 gains.data()};
    for (const EvaluatorPath& path : evaluatorPaths()) {
        path.far->far(tables.constants(),
                      {tables.tables(), pose.parts.data(), parts.data(), 1, 0, near_parts.data(), near_parts.size()},
                      {}, receivers, near_numbers.data());
        path.far->far(tables.constants(), {tables.tables(), pose.parts.data(), same.data(), same.size()}, {}, receivers,
                      far_coefficients.data());
        // (1 - inside) multiplies at the directions or after them.
        EXPECT_LT(largestDifference(near_numbers, far_coefficients), 1e-5) << path.name;
        EXPECT_GT(largestDifference(near_numbers, std::vector<float>(near_numbers.size())), 1) << path.name;
    }
}

// Anchors a kilometre apart leave all parts to their receivers, however small these look. Anchors a micrometre apart
// sum what looks small.
TEST(FarKernel, AnchorsLeaveOutWhatIsNearerThanTheirSpacings) {
    const PosedTube tube;
    const FarTables& tables = tube.tables;
    const FarPose& pose = tube.pose;
    const ScatteredReceivers all;
    const std::vector<std::uint16_t> parts{0, 1, 2, 3, 4, 5};
    const std::size_t stride = anchorStride(parts.size());
    std::vector<float> values(kMaxReceivers * stride);
    for (const EvaluatorPath& path : evaluatorPaths())
        for (const float spacing : {1e3f, 1e-6f}) {
            const FarScene scene{tables.tables(), pose.parts.data(), parts.data(), parts.size(), spacing};
            path.far->anchors(tables.constants(), scene,
                              {all.positions.data(), all.normals.data(), all.tangents.data(), kMaxReceivers},
                              values.data());
            std::size_t summed = 0, near = 0;
            for (std::size_t r = 0; r < kMaxReceivers; ++r) {
                summed += values[r * stride] != 0;  // NaN, too
                for (std::size_t p = 0; p < parts.size(); ++p) near += values[r * stride + kAnchorSums + p] == 1;
            }
            EXPECT_EQ(summed > 0, spacing < 1) << path.name;
            EXPECT_EQ(near > kMaxReceivers, spacing > 1) << path.name;
        }
}

}  // namespace
}  // namespace penumbra::test_far_kernel
