// Bytes that are no asset, or no sound one, give a status and a sentence, and never a crash or a hang.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <random>

#include "asset_generated.h"
#include "formats/common/errors.h"
#include "tests/capi/use_c_api.h"

namespace penumbra::test_hostile_assets {
namespace {

using namespace capi_test;

// The processor time of this thread. Other work on the machine does not count.
double threadSeconds() {
    timespec now{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

// Seconds to use an asset that is whole: the least of three, none of which may fail.
double workOf(const std::vector<std::byte>& whole) {
    double least = 1e9;
    for (int i = 0; i < 3; ++i) {
        const double start = threadSeconds();
        penumbra_error error;
        EXPECT_EQ(useBytes(whole.data(), whole.size(), &error), PENUMBRA_OK) << error.message;
        least = std::min(least, threadSeconds() - start);
    }
    return least;
}

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

// A changed asset may cost so many times the whole one, in processor time. The largest ratio measured was 5.
constexpr double kMaxWork = 100;

// With the hash as it was, the hash catches every mutation. With the hash put right, what the checks behind it let
// through must be usable.
TEST(CApiHostile, TenThousandMutations) {
    int refused = 0, used = 0;
    double most_work = 0;
    std::mt19937 random(17);
    for (const ModelKind kind : kModelKinds) {
        Recipe recipe;
        recipe.tube.kind = kind;
        recipe.tube.features = kind == ModelKind::kQuadratic ? FeatureKind::kJointAngles : FeatureKind::kRelativeBones;
        recipe.bounces = kind == ModelKind::kAdditive || kind == ModelKind::kQuadratic;
        const std::vector<std::byte> whole = packed(recipe);
        const double work_of_whole = workOf(whole);
        for (int trial = 0; trial < 2500; ++trial) {
            std::vector<std::byte> bytes = mutated(whole, random);
            penumbra_error error;
            ASSERT_TRUE(bytes == whole || useBytes(bytes.data(), bytes.size(), &error) == PENUMBRA_INVALID_ASSET);
            sealAsset(bytes);
            const double start = threadSeconds();
            const penumbra_status status = useBytes(bytes.data(), bytes.size(), &error);
            most_work = std::max(most_work, (threadSeconds() - start) / work_of_whole);
            ASSERT_TRUE(status == PENUMBRA_OK || status == PENUMBRA_INVALID_ASSET) << error.message;
            ++(status == PENUMBRA_OK ? used : refused);
        }
    }
    EXPECT_GT(refused, 500);
    EXPECT_GT(used, 500);
    EXPECT_LT(most_work, kMaxWork);
    std::printf("%d refused, %d used; at most %.1f times the work of the whole asset\n", refused, used, most_work);
}

// A few bytes can ask for sizes that the file does not hold: a pose of 2^32 rotations (37 s and 16 GB without the
// check), or the squares of more inputs than there are features.
TEST(CApiHostile, SizesThatTheFileDoesNotHold) {
    for (const FeatureKind features : synthetic::kSkinnedFeatures) {
        Recipe recipe;
        recipe.tube.kind = ModelKind::kAdditive;
        recipe.tube.features = features;
        std::vector<std::byte> bytes = packed(recipe);
        const double work_of_whole = workOf(bytes);
        fbs::GetMutableAsset(bytes.data())->mutable_animation()->mutate_pose_size(0xfffffff0u);
        sealAsset(bytes);
        const double start = threadSeconds();
        penumbra_error error;
        const penumbra_status status = useBytes(bytes.data(), bytes.size(), &error);
        EXPECT_LT(threadSeconds() - start, kMaxWork * work_of_whole);
        EXPECT_EQ(status, features == FeatureKind::kJointAngles ? PENUMBRA_INVALID_ASSET : PENUMBRA_OK);
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
}  // namespace penumbra::test_hostile_assets
