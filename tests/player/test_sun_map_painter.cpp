#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "player/draw/sun_map_painter.h"
#include "player/gl/gl_context.h"
#include "player/gl/offscreen_target.h"
#include "tests/player/gl_calls.h"
#include "tests/runtime/count_allocations.h"
#include "tests/runtime/sun_scenes.h"

namespace penumbra::test_sun_map_painter {
namespace {

using player_test::SunMesh;

constexpr const char* kReceiverVertex = R"(#version 430 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 vertex_normal;
uniform mat4 clip_from_model;
out vec3 place, normal;
void main() {
    place = position;
    normal = vertex_normal;
    gl_Position = clip_from_model * vec4(position, 1.0);
}
)";
constexpr const char* kReceiverFragment = R"(
in vec3 place, normal;
layout(location = 0) out vec4 color;
void main() { color = vec4(sunVisibility(0, place, normalize(normal)), place.xy, 1.0); }
)";

// Past the first sun: by the normal of the triangle, and by that of the vertices.
constexpr const char* kFacetFragment = R"(
in vec3 place, normal;
layout(location = 0) out vec4 color;
void main() {
    vec3 n = normalize(normal), face = sunFacing(place, n);
    float cosine = -dot(sun_frames[2].xyz, face);
    color = vec4(sunVisibility(0, place, face), cosine, sunVisibility(0, place, n), 1.0);
}
)";

// Nothing is drawn where blocks tell nothing.
constexpr const char* kKnownFragment = R"(
in vec3 place, normal;
layout(location = 0) out vec4 color;
void main() {
    SunReceiver receiver;
    bool faces = sunReceiver(0, sunPlace(0, place), normalize(normal), receiver);
    SunReceiver whole = receiver;  // looks as far as the nearest caster of the map says
    float known = faces ? sunFromBlocks(0, receiver) : 0.0;
    if (known < 0.0) discard;
    color = vec4(known, faces ? sunFromTexels(0, whole) : 0.0, 0.0, 1.0);
}
)";

// Draws triangles that are seen from below, from z = -1, x and y from -1 to 1.
class Receiver {
public:
    // A vertex has its position and its normal.
    Receiver(const char* fragment, std::span<const float> vertices, std::span<const std::uint32_t> triangles)
        : program_(makeProgram(kReceiverVertex, "#version 430 core\n" + sunGlsl() + fragment)),
          at_(sunUniforms(program_)),
          count_(GLsizei(triangles.size())),
          vertex_array_(makeVertexArray()) {
        gl::BindVertexArray(vertex_array_.id());
        vertices_ = makeBuffer(GL_ARRAY_BUFFER, vertices);
        for (GLuint i = 0; i < 2; ++i) {
            gl::VertexAttribPointer(i, 3, GL_FLOAT, GL_FALSE, 24, reinterpret_cast<const void*>(12 * std::size_t(i)));
            gl::EnableVertexAttribArray(i);
        }
        triangles_ = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles);
    }
    void draw(const SunMapPainter& maps) const {
        gl::UseProgram(program_.id());
        const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
        gl::UniformMatrix4fv(gl::GetUniformLocation(program_.id(), "clip_from_model"), 1, GL_FALSE, identity);
        maps.bind(at_, 3);
        gl::BindVertexArray(vertex_array_.id());
        gl::DrawElements(GL_TRIANGLES, count_, GL_UNSIGNED_INT, nullptr);
        checkGl("drawing a receiver");
    }

private:
    GlObject program_;
    SunUniforms at_;
    GLsizei count_;
    GlObject vertex_array_, vertices_, triangles_;
};

// The square z = 0: visibility, x, y.
Receiver groundReceiver(const char* fragment = kReceiverFragment) {
    constexpr float kCorners[] = {-1, -1, 0, 0, 0, 1, 1, -1, 0, 0, 0, 1, 1, 1, 0, 0, 0, 1, -1, 1, 0, 0, 0, 1};
    constexpr std::uint32_t kTriangles[] = {0, 1, 2, 0, 2, 3};
    return {fragment, kCorners, kTriangles};
}

// Values of the two paths differ where a texel's center lies on an edge of a triangle in one of them only.
TEST(SunMapPainter, GivesThePictureOfTheCpu) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter maps(2, 512);
    const Receiver ground = groundReceiver();
    const OffscreenTarget target(160, 160, 1);
    SunMesh sphere = player_test::sunSphere(20);
    for (Vec3& p : sphere.positions) p = p * 0.25f + Vec3{-0.1f, 0.1f, 0.4f};
    const SunMesh bar = player_test::sunBox({0.2f, -0.6f, 0}, {0.25f, 0.1f, 0.3f});
    const SunCasters casters{{sphere, bar}};
    maps.setCasters(casters);
    std::size_t other = 0, pixels = 0;
    for (const float radius : {0.0f, 0.01f, 0.1f})
        for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{-1, 0, 0.5f}}) {
            const SunNest nests[] = {player_test::sunNestOf(casters, direction, radius, 512)};
            const SunMap map = player_test::sunMapOf(casters.members, direction, radius, 512);
            maps.draw(nests, casters);
            target.begin();
            ground.draw(maps);
            for (const Vec3 pixel : target.read().pixels) {
                ++pixels;
                other += !(std::abs(pixel.x - map.visibility({pixel.y, pixel.z, 0}, {0, 0, 1})) <= 0.5f / 255);
            }
        }
    EXPECT_LE(double(other), 0.002 * double(pixels)) << other << " of " << pixels;
}

constexpr const char* kSecondSunFragment = R"(
in vec3 place, normal;
layout(location = 0) out vec4 color;
void main() { color = vec4(sunVisibility(1, place, normalize(normal)), place.xy, 1.0); }
)";

// The share of pixels of which the CPU's maps tell something else.
double otherShare(const Image& picture, const SunMaps& maps) {
    std::size_t other = 0;
    for (const Vec3 pixel : picture.pixels)
        other += !(std::abs(pixel.x - maps.visibility({pixel.y, pixel.z, 0}, {0, 0, 1})) <= 0.5f / 255);
    return double(other) / double(picture.pixels.size());
}

// A ground that is wide beside a ball and a bar, and waves, so that the picture goes through two borders of maps.
struct WideScene {
    SunMesh ball = player_test::sunSphere(20), bar = player_test::sunBox({0.2f, -0.6f, 0}, {0.205f, -0.55f, 0.1f});
    SunMesh ground = player_test::sunGround(
        300, 65, [](float x, float y) { return 2 * std::sin(0.2f * x + 0.1f * y) - 0.001f * (x * x + y * y) - 0.01f; });
    // The ball moves between the bar and the post, so that maps stay where they are.
    SunMesh post = player_test::sunBox({-0.4f, 0.3f, 0}, {-0.395f, 0.305f, 0.35f});
    WideScene() { moveBall(0); }
    void moveBall(float x) {
        ball = player_test::sunSphere(20);
        for (Vec3& p : ball.positions) p = p * 0.05f + Vec3{x - 0.1f, 0.1f, 0.1f};
    }
    SunCasters casters(std::uint64_t version) const { return {{ball, bar, post}, ground, version}; }
};

// The second sun has one map and the first several, or the other way round.
TEST(SunMapPainter, GivesTheNestedMapsOfTheCpu) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter maps(2, 512);
    const Receiver first = groundReceiver(), second = groundReceiver(kSecondSunFragment);
    const OffscreenTarget target(160, 160, 1);
    const WideScene wide;
    const SunCasters casters = wide.casters(0);
    maps.setCasters(casters);
    for (const float radius : {0.0f, 0.005f, 0.05f})
        for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{-1, 0, 0.3f}}) {
            SunMaps nested, one;
            nested.begin(casters, direction, radius, 512);
            nested.draw(casters);
            EXPECT_GE(nested.maps().size(), 3u);
            SunNest whole = nested.nest();
            whole.maps.erase(whole.maps.begin(), whole.maps.end() - 1);
            const SunNest nests[] = {nested.nest(), whole}, turned[] = {whole, nested.nest()};
            maps.draw(nests, casters);
            target.begin();
            first.draw(maps);
            EXPECT_LE(otherShare(target.read(), nested), 0.002) << radius << " " << direction.x;
            maps.draw(turned, casters);
            target.begin();
            second.draw(maps);
            const Image seen = target.read();
            EXPECT_LE(otherShare(seen, nested), 0.002) << radius << " " << direction.x;
            std::size_t dark = 0;
            for (const Vec3 pixel : seen.pixels) dark += pixel.x < 0.5f;
            EXPECT_GT(dark, 20u) << "nothing casts";
        }
}

// Maps of a ground that has not changed are not drawn again, and what is seen is the same as if they were.
TEST(SunMapPainter, DrawsAMapOfGroundAloneOnceForEachVersion) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const Receiver ground = groundReceiver();
    const OffscreenTarget target(160, 160, 1);
    WideScene wide;
    SunMapPainter kept(1, 512);
    kept.setCasters(wide.casters(1));
    SunFrame frame;
    const auto picture = [&](SunMapPainter& maps, std::uint64_t version) {
        const SunCasters casters = wide.casters(version);
        const SunNest nests[] = {player_test::sunNestOf(casters, {1, 2, 3}, 0.005f, 512)};
        frame = nests[0].maps[0].frame;
        maps.draw(nests, casters);
        target.begin();
        ground.draw(maps);
        std::vector<float> seen;
        for (const Vec3 pixel : target.read().pixels) seen.push_back(pixel.x);
        return seen;
    };
    const auto anew = [&] {
        SunMapPainter maps(1, 512);
        maps.setCasters(wide.casters(0));
        return picture(maps, 0);
    };
    const std::vector<float> at_first = picture(kept, 1);
    EXPECT_EQ(at_first, anew());
    const SunFrame first_frame = frame;
    wide.moveBall(0.02f);
    const std::vector<float> moved = picture(kept, 1);
    EXPECT_NE(moved, at_first);
    EXPECT_EQ(frame.rows, first_frame.rows);
    EXPECT_EQ(moved, anew());
    for (Vec3& p : wide.ground.positions) p.z -= p.x > 3 ? 8 : 0;
    EXPECT_NE(picture(kept, 1), anew()) << "the version tells of the change";
    EXPECT_EQ(picture(kept, 2), anew());
}

// Triangles of a coarse ball with the normals of a sphere, which face the sun, are all lit. By the normals of the
// vertices 208 of 287,000 pixels are dark, and many more where a mesh is hollow.
TEST(SunMapPainter, CoarseMeshesWithSmoothNormalsHaveNoAcne) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter maps(1, 512);
    const OffscreenTarget target(256, 256, 1);
    SunMesh ball = player_test::sunSphere(9);
    std::vector<float> vertices;
    for (Vec3& p : ball.positions) {
        const Vec3 normal = p;
        p = p * 0.9f;
        for (const Vec3 v : {p, normal}) vertices.insert(vertices.end(), {v.x, v.y, v.z});
    }
    const Receiver receiver(kFacetFragment, vertices, ball.triangles);
    const SunCasters casters{{ball}};
    maps.setCasters(casters);
    std::size_t lit = 0, dark = 0, dark_by_normals = 0;
    for (const float radius : {0.0f, 0.01f, 0.05f})
        for (const Vec3 direction : {Vec3{0, 0, -1}, Vec3{1, 2, -3}, Vec3{-2, 0.5f, -1}}) {
            const SunNest nests[] = {player_test::sunNestOf(casters, direction, radius, 512)};
            maps.draw(nests, casters);
            target.begin();
            receiver.draw(maps);
            for (const Vec3 pixel : target.read().pixels) {
                if (pixel.y < 0.2f) continue;  // turned away, or the background
                ++lit;
                dark += pixel.x < 0.99f;
                dark_by_normals += pixel.z < 0.99f;
            }
        }
    EXPECT_GT(lit, 100000u);
    EXPECT_EQ(dark, 0u) << "of " << lit;
    EXPECT_GT(dark_by_normals, 100u);
}

// Blocks give the same visibility as texels, and they cover most of a picture.
TEST(SunMapPainter, BlocksTellMostPixelsWhatTexelsTell) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const OffscreenTarget target(160, 160, 1);
    SunMesh sphere = player_test::sunSphere(20);
    for (Vec3& p : sphere.positions) p = p * 0.25f + Vec3{-0.1f, 0.1f, 0.4f};
    const SunMesh bar = player_test::sunBox({0.2f, -0.6f, 0}, {0.25f, 0.1f, 0.3f});
    const SunCasters casters{{sphere, bar}};
    const Receiver ground = groundReceiver(kKnownFragment);
    for (const int size : {500, 512, 1024}) {
        SunMapPainter maps(1, size);
        maps.setCasters(casters);
        for (const float radius : {0.0f, 0.005f, 0.05f})
            for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{-1, 0, 0.5f}}) {
                const SunNest nests[] = {player_test::sunNestOf(casters, direction, radius, size)};
                maps.draw(nests, casters);
                target.begin();
                ground.draw(maps);
                const Image image = target.read();
                std::size_t known = 0, wrong = 0;
                for (std::size_t i = 0; i < image.pixels.size(); ++i) {
                    known += image.alpha[i] > 0;
                    wrong += image.alpha[i] > 0 && image.pixels[i].x != image.pixels[i].y;
                }
                EXPECT_EQ(wrong, 0u) << size << " " << radius;
                EXPECT_GT(double(known), 0.5 * double(image.pixels.size())) << size << " " << radius;
            }
    }
}

// Backs of closed surfaces are left out of the map. Those of the same boxes turned inside out are not.
TEST(SunMapPainter, BacksOfClosedSurfacesChangeNothing) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter fronts(1, 256), both(1, 256);
    const Receiver ground = groundReceiver();
    const OffscreenTarget target(160, 160, 1);
    SunMesh boxes = player_test::sunBox({-0.5f, -0.5f, 0.1f}, {-0.1f, 0.2f, 0.4f});
    for (const SunMesh& box : {player_test::sunBox({-0.3f, 0, 0.2f}, {0.4f, 0.1f, 0.3f}),
                               player_test::sunBox({0.2f, -0.6f, 0}, {0.25f, 0.1f, 0.3f})}) {
        for (const std::uint32_t v : box.triangles)
            boxes.triangles.push_back(v + std::uint32_t(boxes.positions.size()));
        boxes.positions.insert(boxes.positions.end(), box.positions.begin(), box.positions.end());
    }
    ASSERT_EQ(findClosedSurfaces(boxes.triangles).closedIndices(), boxes.triangles.size());
    ASSERT_TRUE(allOutward(findClosedSurfaces(boxes.triangles), boxes.positions));
    SunMesh inside_out = boxes;
    for (std::size_t t = 0; t < boxes.triangles.size(); t += 3)
        std::swap(inside_out.triangles[t], inside_out.triangles[t + 1]);
    fronts.setCasters({{boxes}});
    both.setCasters({{inside_out}});
    for (const Vec3 direction : {Vec3{0, 0, 1}, Vec3{1, 2, 3}, Vec3{-1, 0, 0.5f}}) {
        const auto picture = [&](SunMapPainter& maps, const SunMesh& mesh) {
            const SunCasters casters{{mesh}};
            const SunNest nests[] = {player_test::sunNestOf(casters, direction, 0.005f, 256)};
            maps.draw(nests, casters);
            target.begin();
            ground.draw(maps);
            return target.read();
        };
        const Image seen = picture(fronts, boxes), expected = picture(both, inside_out);
        std::size_t other = 0, dark = 0;
        for (std::size_t i = 0; i < seen.pixels.size(); ++i) {
            other += seen.pixels[i] != expected.pixels[i];
            dark += seen.pixels[i].x < 0.5f;
        }
        EXPECT_EQ(other, 0u) << direction.x;
        EXPECT_GT(dark, 1000u) << "nothing casts";
    }
}

TEST(SunMapPainter, NoFrameAllocates) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter maps(1, 64);
    const SunMesh bar = player_test::sunBox({0.2f, -0.6f, 0}, {0.25f, 0.1f, 0.3f});
    const SunCasters casters{{bar}};
    maps.setCasters(casters);
    SunMaps on_cpu;
    SunNest nest;
    const auto drawBoth = [&](float angle) {
        const Vec3 direction{std::cos(angle), std::sin(angle), 1};
        on_cpu.begin(casters, direction, 0.01f, 64);
        on_cpu.draw(casters);
        fitSunNest(casters, direction, 0.01f, 64, nest);
        maps.draw({&nest, 1}, casters);
    };
    drawBoth(0);
    const player_test::GlCalls calls;
    const std::size_t before = allocationCount();
    drawBoth(1);
    EXPECT_EQ(allocationCount(), before);
    EXPECT_EQ(calls.made(), 0);
}

TEST(SunMapPainter, VerticesThatAreNotFiniteCastNothing) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    SunMapPainter maps(1, 128);
    const Receiver ground = groundReceiver();
    const OffscreenTarget target(32, 32, 1);
    SunMesh sheet = player_test::sunSquare({0, 0, 1}, 0.5f);
    for (Vec3& p : sheet.positions) p.z = 0.5f;
    const auto darkness = [&] {
        const SunCasters casters{{sheet}};
        const SunNest nests[] = {player_test::sunNestOf(casters, {0, 0, 1}, 0.01f, 128)};
        maps.draw(nests, casters);
        target.begin();
        ground.draw(maps);
        double sum = 0;
        for (const Vec3 pixel : target.read().pixels) sum += 1 - double(pixel.x);
        return sum / 1024;
    };
    const SunCasters casters{{sheet}};
    maps.setCasters(casters);
    EXPECT_NEAR(darkness(), 0.25, 0.01);
    const Vec3 corner = sheet.positions[1];  // a corner of one of the two triangles
    sheet.positions[1].x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_NEAR(darkness(), 0.125, 0.01);
    sheet.positions[1] = corner;
    EXPECT_NEAR(darkness(), 0.25, 0.01);
    for (Vec3& p : sheet.positions) p.x = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(darkness(), 0);
}

TEST(SunMapPainter, SizesAboveTheLimitAreUnsupported) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    GLint limit = 0;
    gl::GetIntegerv(GL_MAX_TEXTURE_SIZE, &limit);
    EXPECT_THROW(SunMapPainter(1, limit + 1), Unsupported);
}

}  // namespace
}  // namespace penumbra::test_sun_map_painter
