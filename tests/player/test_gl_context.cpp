#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "player/gl/offscreen_target.h"

namespace penumbra::test_gl_context {
namespace {

TEST(GlContext, GivesOpenGl43WithoutAWindow) {
    for (const GlBackend backend : {GlBackend::kAuto, GlBackend::kOsMesa, GlBackend::kEgl}) {
        const auto context = createGlContext(backend);
        GLint major = 0, minor = 0;
        gl::GetIntegerv(GL_MAJOR_VERSION, &major);
        gl::GetIntegerv(GL_MINOR_VERSION, &minor);
        EXPECT_GE(10 * major + minor, 43) << context->description;
    }
}

TEST(GlContext, IsMadeAgainAfterItsEnd) {
    std::string first;
    for (int i = 0; i < 3; ++i) {
        const auto context = createGlContext(GlBackend::kOsMesa);
        if (i == 0) first = context->description;
        EXPECT_EQ(context->description, first);
        EXPECT_TRUE(context->software);
    }
}

TEST(GlObjects, ShaderErrorsNameTheLine) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    try {
        makeProgram("#version 430 core\nvoid main() { nothing(); }\n", "#version 430 core\nvoid main() {}\n");
        FAIL() << "compiled";
    } catch (const std::logic_error& error) {
        EXPECT_NE(std::string(error.what()).find("nothing"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("2: void main"), std::string::npos);
    }
}

TEST(OffscreenTarget, SizesAboveTheLimitAreUnsupported) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &limit);
    EXPECT_THROW(OffscreenTarget(limit + 1, 1, 1), Unsupported);
    EXPECT_THROW(OffscreenTarget(1, limit + 1, 1), Unsupported);
    EXPECT_THROW(OffscreenTarget(8, 8, 1024), Unsupported);
}

TEST(OffscreenTarget, ClearsToTransparentBlack) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    for (const int samples : {1, 4}) {
        const OffscreenTarget target(5, 3, samples);
        target.begin();
        const Image image = target.read();
        EXPECT_EQ(image.pixels, std::vector<Vec3>(15));
        EXPECT_EQ(image.alpha, std::vector<float>(15));
    }
}

}  // namespace
}  // namespace penumbra::test_gl_context
