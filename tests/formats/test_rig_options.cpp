// Options by which a bake read its rig, on their way to those who read it again.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "formats/common/errors.h"
#include "formats/common/pass_rig_options.h"
#include "formats/rig/rig_options_json.h"

namespace penumbra::test_rig_options {
namespace {

TEST(RigOptionsJson, ComeBackFromABakeAndFromWhatIsMadeOfIt) {
    RigOptions options;
    options.nodes = {"Body", "Hat*"};
    options.without = {"Cape"};
    options.split_angle = 35;
    options.crease = 60;
    options.sides = RigSides::kFronts;
    nlohmann::ordered_json bake{{"rays", 64}}, model{{"model", "linear"}}, bounced;
    listRigOptions(options, bake);
    passRigOptions(bake.dump(), model);
    passRigOptions(model.dump(), bounced);
    for (const nlohmann::ordered_json& json : {bake, model, bounced}) {
        const RigOptions read = rigOptionsOf(json.dump());
        EXPECT_EQ(read.nodes, options.nodes) << json;
        EXPECT_EQ(read.without, options.without) << json;
        EXPECT_EQ(read.split_angle, options.split_angle) << json;
        EXPECT_EQ(read.crease, options.crease) << json;
        EXPECT_EQ(read.sides, options.sides) << json;
    }
}

TEST(RigOptionsJson, DefaultsAddNothing) {
    nlohmann::ordered_json model{{"model", "linear"}};
    passRigOptions(R"({"rays":64})", model);
    passRigOptions("not JSON", model);
    EXPECT_EQ(model.dump(), R"({"model":"linear"})");
    EXPECT_TRUE(rigOptionsOf(model.dump()).nodes.empty());
    EXPECT_EQ(rigOptionsOf("[]").split_angle, RigOptions().split_angle);
}

TEST(RigOptionsJson, DamageIsRefused) {
    for (const char* text :
         {"{", R"({"nodes":3})", R"({"crease":"x"})", R"({"split_angle":-1})", R"({"rig":{"crease":999}})"})
        EXPECT_THROW(rigOptionsOf(text), InvalidInput) << text;
}

}  // namespace
}  // namespace penumbra::test_rig_options
