#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "sh/cast/cast_reference.h"
#include "tests/sh/caster_scenes.h"

namespace penumbra::test_cast_reference {
namespace {

const std::vector<Vec3> kPlaces = {{0.4f, 0.1f, 0}, {0.9f, -0.3f, 0.02f}, {1.5f, 1, 0.5f}, {-0.5f, 0.5f, 1.2f}};

TEST(CastExponential, ReadsItsOwnNames) {
    for (const char* word : {"hyb-ps2", "hyb-ol", "ps-1", "ps-9", "ps-20", "ol", "chain"})
        EXPECT_EQ(nameOf(parseCastExponential(word)), word);
    EXPECT_TRUE(parseCastExponential("hyb-ps2").isDefault());
    EXPECT_FALSE(parseCastExponential("chain").isDefault());
    for (const char* word : {"", "ps", "ps-", "ps-0", "ps-21", "ps-9x", "ps--1", "ps-99999999999", "PS-9", "olx"})
        EXPECT_THROW(parseCastExponential(word), std::invalid_argument) << word;
}

// The default is what the lanes compute. Measured: below 1e-5.
TEST(CastReference, IsWhatTheLanesCompute) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    for (int order = kMinLogOrder; order <= kMaxLogOrder; ++order) {
        const std::size_t n = std::size_t(coefficientCount(order));
        std::vector<float> fast(kPlaces.size() * n);
        castVisibility(order, person, kPlaces, fast);
        for (std::size_t r = 0; r < kPlaces.size(); ++r) {
            std::vector<double> slow(n);
            castReference({}, order, person, kPlaces[r], {}, slow);
            for (std::size_t i = 0; i < n; ++i) EXPECT_NEAR(fast[r * n + i], slow[i], 5e-5) << order;
        }
    }
}

// A sphere that fades in part is a smaller one here, and a weighted logarithm in the lanes.
TEST(CastReference, IsMirroredAndFadesAsTheLanesDo) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    std::vector<Vec3> places = kPlaces;
    for (const float far : {2.5f, 4.0f, 5.5f, 9.0f}) places.push_back({far, 0, 0.5f});
    const std::vector<Vec3> normals(places.size(), {0, 0, 1}), tangents(places.size(), {1, 0, 0});
    std::vector<float> fast(places.size() * kMirroredCast), slow(fast);
    const CastFade fade{0.0001f, 0.0003f};
    castMirrored(person, {places, normals, tangents}, fade, fast);
    castMirroredReference({}, person, {places, normals, tangents}, fade, slow);
    for (std::size_t i = 0; i < fast.size(); ++i) EXPECT_NEAR(fast[i], slow[i], 1e-3) << i;
}

// From 0.9 m on all ways are alike (RMS over the sphere; formulas, section 10), and each is one of its own.
TEST(CastReference, AllWaysAreNearOneAnotherFarFromTheBody) {
    const std::vector<CasterSphere> person = inFloats(goldenPerson());
    std::vector<double> chain(25), other(25);
    castReference(parseCastExponential("chain"), 5, person, kPlaces[2], {}, chain);
    for (const char* word : {"hyb-ps2", "hyb-ol", "ps-9", "ol"}) {
        castReference(parseCastExponential(word), 5, person, kPlaces[2], {}, other);
        double squares = 0;
        for (std::size_t i = 0; i < 25; ++i) squares += (other[i] - chain[i]) * (other[i] - chain[i]);
        EXPECT_LT(std::sqrt(squares / (4 * std::acos(-1.0))), 0.03) << word;
        EXPECT_GT(squares, 1e-12) << word;
    }
}

}  // namespace
}  // namespace penumbra::test_cast_reference
