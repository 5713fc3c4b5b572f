// Ranges of a material's parameter, as users write them.
#include <gtest/gtest.h>

#include <stdexcept>

#include "sh/brdf/brdf_range.h"

namespace penumbra::test_brdf_range {
namespace {

TEST(BrdfRange, IsParsedWithAllElse) {
    const auto range = parseBrdfRange("ward-gmd:ax=0.2,ay=0.1..0.5,color=1/0.5/0.25");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->parameter, 1u);
    EXPECT_EQ(range->least, 0.1);
    EXPECT_EQ(range->most, 0.5);
    EXPECT_EQ(range->sum.terms, std::vector{parseBrdf("ward-gmd:ax=0.2,ay=0.3,color=1/0.5/0.25")}) << "the middle";
    EXPECT_EQ(toString(sumAt(*range, 0.1).terms[0]), "ward-gmd:ax=0.2,ay=0.1,color=1/0.5/0.25");
    EXPECT_EQ(range->name, "ward-gmd:ax=0.2,ay=0.1..0.5,color=1/0.5/0.25");
    EXPECT_EQ(parseBrdfRange("ggx:f0=1e-3..1")->name, "ggx:alpha=0.3,f0=0.001..1");
}

TEST(BrdfRange, IsOfOneTermOfASum) {
    const auto range = parseBrdfRange("ggx:alpha=0.3+ggx:alpha=0.1..0.5,f0=0.04+lambert:color=0.2");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->terms, 0b010);
    EXPECT_EQ(range->name, "ggx:alpha=0.3,f0=0.9+ggx:alpha=0.1..0.5,f0=0.04+lambert:color=0.2/0.2/0.2");
    const BrdfSum at = sumAt(*range, 0.5);
    EXPECT_EQ(at.terms[0].parameters.at("alpha"), 0.3);
    EXPECT_EQ(at.terms[1].parameters.at("alpha"), 0.5);
}

// In a principled material both GGX lobes follow the range.
TEST(BrdfRange, OfPrincipledIsItsRoughness) {
    const auto range = parseBrdfRange("principled:color=0.8/0.2/0.1,metallic=0.5,roughness=0.2..0.8");
    ASSERT_TRUE(range);
    EXPECT_EQ(range->terms, 0b110);
    EXPECT_EQ(range->name, "principled:color=0.8/0.2/0.1,metallic=0.5,roughness=0.2..0.8,ior=1.5,specular=1");
    for (const std::size_t t : {1, 2}) EXPECT_EQ(sumAt(*range, 0.25).terms[t].parameters.at("roughness"), 0.25);
}

TEST(BrdfRange, OthersHaveNone) {
    for (const char* text : {"lambert", "ggx:alpha=0.3", "ggx:alpha=.3,f0=.9", "../x.brdf", ""})
        EXPECT_FALSE(parseBrdfRange(text)) << text;
}

TEST(BrdfRange, WrongOnesAreNamed) {
    const auto expect = [](const char* text, const char* words) {
        try {
            parseBrdfRange(text);
            ADD_FAILURE() << text;
        } catch (const std::invalid_argument& error) {
            EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << text << ": " << error.what();
        }
    };
    expect("ggx:alpha=0.6..0.1", "ggx alpha: the first end of its range must be below the second");
    expect("ggx:alpha=0.3..0.3", "ggx alpha: the first end of its range must be below the second");
    expect("ggx:alpha=nan..0.5", "ggx alpha must be a number from 0.01 to 1, not 'nan'");
    expect("ggx:alpha=-1..0.5", "not '-1'");
    expect("ggx:alpha=0.1..2", "not '2'");
    expect("ggx:alpha=0.1..", "expected key=value");
    expect("ggx:alpha=..0.5", "expected key=value");
    expect("ggx:alpha=0.1..0.5,f0=0..1", "only one parameter has a range");
    expect("ggx:rough=0.1..0.5", "ggx has no 'rough'");
    expect("lambert:color=0.1..0.5", "lambert color has no range");
    expect("phong-live:exponent=1..5", "phong-live has no tables");
    expect("principled:metallic=0..1", "principled metallic has no range: only its roughness may have one");
    expect("lambert+ggx:alpha=0.6..0.1", "ggx alpha: the first end of its range must be below the second");
}

}  // namespace
}  // namespace penumbra::test_brdf_range
