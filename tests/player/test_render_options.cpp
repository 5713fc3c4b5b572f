#include <gtest/gtest.h>

#include <limits>

#include "formats/common/errors.h"
#include "player/frame/render_options.h"

namespace penumbra {
namespace {

TEST(RenderOptions, DefaultsCanBeUsed) { EXPECT_EQ(findProblem(RenderOptions{}), ""); }

TEST(RenderOptions, ProblemsNameOptionRangeAndValue) {
    RenderOptions options;
    options.samples = 3;
    EXPECT_EQ(findProblem(options), "--aa must be 1, 2, 4 or 8, not 3");
    options = {};
    options.width = 0;
    EXPECT_EQ(findProblem(options), "--size: the width must be 1..16384, not 0");
    options = {};
    options.height = 20000;
    EXPECT_EQ(findProblem(options), "--size: the height must be 1..16384, not 20000");
    options = {};
    options.frame = -1;
    EXPECT_EQ(findProblem(options), "--frame must be 0 or more, not -1");
    options = {};
    options.exposure = -0.5f;
    EXPECT_EQ(findProblem(options), "--exposure must be a finite number above 0, not -0.5");
    options = {};
    options.error_max = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NE(findProblem(options), "");
}

TEST(RenderOptions, WordsAreRead) {
    EXPECT_EQ(parseChannel("shaded"), Channel::kShaded);
    EXPECT_EQ(parseChannel("ao"), Channel::kAmbient);
    EXPECT_EQ(parseChannel("error"), Channel::kError);
    EXPECT_EQ(parseChannel("clusters"), Channel::kClusters);
    EXPECT_EQ(parseChannel("normals"), Channel::kNormals);
    EXPECT_EQ(parseChannel("parts"), Channel::kParts);
    EXPECT_EQ(parseSource("truth"), VisibilitySource::kTruth);
    EXPECT_EQ(parsePath("glsl"), EvaluationPath::kGlsl);
    EXPECT_EQ(parsePath("auto"), std::nullopt);
    EXPECT_EQ(parseReflectance("slices"), Reflectance::kSlices);
    EXPECT_EQ(parseReflectance("operators"), Reflectance::kOperators);
    EXPECT_EQ(parseLightForm("lobes"), LightForm::kLobes);
    EXPECT_EQ(parseLightForm("fixed"), LightForm::kFixed);
    EXPECT_EQ(parseLightForm("rotation"), LightForm::kRotation);
    EXPECT_EQ(parseLightForm("auto"), LightForm::kRotation);
    EXPECT_THROW(parseReflectance("rpo"), UsageError);
    EXPECT_THROW(parseLightForm(""), UsageError);
    for (const char* word : {"", "Shaded", "ao "}) EXPECT_THROW(parseChannel(word), UsageError);
    EXPECT_THROW(parseSource("both"), UsageError);
    EXPECT_THROW(parsePath("gpu"), UsageError);
}

TEST(RenderOptions, SizesAndColoursAreRead) {
    int width = 0, height = 0;
    parseSize("640x480", width, height);
    EXPECT_EQ(width, 640);
    EXPECT_EQ(height, 480);
    for (const char* text : {"640", "640x", "x480", "640x480x", "640*480", "6 40x480", "99999999999x1", "1.5x2"})
        EXPECT_THROW(parseSize(text, width, height), UsageError) << text;
    EXPECT_EQ(parseBackground("transparent"), std::nullopt);
    EXPECT_EQ(parseBackground("0.5/1/2e-1"), (Vec3{0.5f, 1, 0.2f}));
    for (const char* text : {"", "1/1", "1/1/1/1", "a/b/c", "-1/0/0", "nan/0/0", "inf/0/0"})
        EXPECT_THROW(parseBackground(text), UsageError) << text;
}

}  // namespace
}  // namespace penumbra
