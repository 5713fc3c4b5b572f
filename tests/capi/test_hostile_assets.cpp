// Bytes that are no asset, or no sound one, give a status and a sentence, and never a crash or a hang.
#include <gtest/gtest.h>

#include <chrono>
#include <random>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "tests/capi/use_c_api.h"

namespace penumbra {
namespace {

using namespace capi_test;
using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

TEST(CApiHostile, EveryTruncationIsRefused) {
    const std::vector<std::byte> whole = packed();
    penumbra_error error;
    ASSERT_EQ(useBytes(whole.data(), whole.size(), &error), PENUMBRA_OK);
    for (std::size_t n = 0; n < whole.size(); ++n) {
        const std::vector<std::byte> cut(whole.data(), whole.data() + n);  // a copy: tools see any read beyond it
        ASSERT_EQ(useBytes(n ? cut.data() : whole.data(), n, &error), PENUMBRA_INVALID_ASSET) << "first " << n;
        ASSERT_NE(error.message[0], 0);
    }
}

// Changes 1 to 4 bytes, each by a flipped bit or to a new byte.
std::vector<std::byte> mutated(std::vector<std::byte> bytes, std::mt19937& random) {
    const int changes = 1 + int(random() % 4);
    for (int i = 0; i < changes; ++i) {
        const std::size_t at = random() % bytes.size();
        if (random() % 2)
            bytes[at] ^= std::byte(1u << random() % 8);
        else
            bytes[at] = std::byte(random());
    }
    return bytes;
}

// With the hash as it was, the hash catches every mutation. With the hash put right, what the checks behind it let
// through must be usable. The slowest case took 17 ms on a busy machine; 1 s leaves room for AddressSanitizer.
TEST(CApiHostile, TenThousandMutations) {
    int refused = 0, used = 0;
    double slowest = 0;
    std::mt19937 random(17);
    for (const ModelKind kind : kModelKinds) {
        Recipe recipe;
        recipe.tube.kind = kind;
        recipe.tube.features = kind == ModelKind::kQuadratic ? FeatureKind::kJointAngles : FeatureKind::kRelativeBones;
        const std::vector<std::byte> whole = packed(recipe);
        for (int trial = 0; trial < 2500; ++trial) {
            std::vector<std::byte> bytes = mutated(whole, random);
            penumbra_error error;
            ASSERT_TRUE(bytes == whole || useBytes(bytes.data(), bytes.size(), &error) == PENUMBRA_INVALID_ASSET);
            sealAsset(bytes);
            const Clock::time_point start = Clock::now();
            const penumbra_status status = useBytes(bytes.data(), bytes.size(), &error);
            slowest = std::max(slowest, secondsSince(start));
            ASSERT_TRUE(status == PENUMBRA_OK || status == PENUMBRA_INVALID_ASSET) << error.message;
            ++(status == PENUMBRA_OK ? used : refused);
        }
    }
    EXPECT_GT(refused, 500);
    EXPECT_GT(used, 500);
    EXPECT_LT(slowest, 1.0);
    std::printf("%d refused, %d used; slowest %.1f ms\n", refused, used, 1e3 * slowest);
}

// A few bytes can ask for sizes that the file does not hold: a pose of 2^32 rotations (37 s and 16 GB without the
// check), or the squares of more inputs than there are features.
TEST(CApiHostile, SizesThatTheFileDoesNotHold) {
    for (const FeatureKind features : synthetic::kSkinnedFeatures) {
        Recipe recipe;
        recipe.tube.kind = ModelKind::kAdditive;
        recipe.tube.features = features;
        std::vector<std::byte> bytes = packed(recipe);
        fbs::GetMutableAsset(bytes.data())->mutable_animation()->mutate_pose_size(0xfffffff0u);
        sealAsset(bytes);
        const Clock::time_point start = Clock::now();
        penumbra_error error;
        const penumbra_status status = useBytes(bytes.data(), bytes.size(), &error);
        EXPECT_EQ(status, features == FeatureKind::kJointAngles ? PENUMBRA_INVALID_ASSET : PENUMBRA_OK);
        EXPECT_LT(secondsSince(start), 1.0);
    }
    Recipe recipe{.tube = {.joints = 2, .inputs = 12}};
    recipe.tube.kind = ModelKind::kQuadratic;
    std::vector<std::byte> bytes = packed(recipe);
    penumbra_error error;
    EXPECT_EQ(useBytes(bytes.data(), bytes.size(), &error), PENUMBRA_OK) << error.message;
    recipe.tube.inputs = 13;
    EXPECT_THROW(packed(recipe), InvalidInput);
}

}  // namespace
}  // namespace penumbra
