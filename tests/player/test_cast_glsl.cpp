// Tests the GLSL of sphere casters in shaders of an engine: a compute shader with storage buffers, and a fragment
// shader with texture buffers. Texts and tables come out of the C interface. They give what the CPU gives.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "player/gl/offscreen_target.h"
#include "player/runtime/cast/cast_shadow.h"
#include "sh/cast/cast_visibility.h"
#include "sh/tangent.h"
#include "tests/capi/packed_asset.h"

namespace penumbra {
namespace {

using namespace capi_test;

// For each receiver: visibility [25], mirrored [21], E, whether any sphere counts; then its numbers.
constexpr std::size_t kCastResults = 48;

constexpr char kComputeBuffers[] = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Spheres { vec4 spheres[]; };
layout(std430, binding = 1) readonly buffer CapLogs { vec4 cap_logs[]; };
layout(std430, binding = 2) readonly buffer Receivers { vec4 receivers[]; };
layout(std430, binding = 3) readonly buffer Numbers { vec4 given[]; };
layout(std430, binding = 4) writeonly buffer Results { float results[]; };
#define PENUMBRA_SPHERE(i) spheres[i]
#define PENUMBRA_CAP_LOG(i) cap_logs[i]
#define RECEIVER(i) receivers[i]
#define GIVEN(i) given[i]
)";
constexpr char kFragmentBuffers[] = R"(#version 430 core
uniform samplerBuffer spheres, cap_logs, receivers, given;
layout(location = 0) out vec4 color;
#define PENUMBRA_SPHERE(i) texelFetch(spheres, i)
#define PENUMBRA_CAP_LOG(i) texelFetch(cap_logs, i)
#define RECEIVER(i) texelFetch(receivers, i)
#define GIVEN(i) texelFetch(given, i)
)";
constexpr char kNoShading[] = R"(
#define PENUMBRA_MATERIAL(i) vec4(0)
#define PENUMBRA_LIGHT(i) vec4(0)
)";
constexpr char kCommon[] = R"(
#ifndef PENUMBRA_STRIDE4
#define NUMBERS 0
#else
#define NUMBERS (4 * PENUMBRA_STRIDE4)
#endif
uniform int sphere_count, receiver_count, left_out_begin, left_out_end;

void castOn(int r, out float result[48 + NUMBERS]) {
    vec3 normal = RECEIVER(3 * r + 1).xyz, tangent = RECEIVER(3 * r + 2).xyz;
    mat3 local_from_scene = transpose(mat3(tangent, cross(normal, tangent), normal));
    float visibility[25], mirrored[21];
    bool seen = penumbra_cast_visibility(sphere_count, ivec2(left_out_begin, left_out_end), RECEIVER(3 * r).xyz,
                                         local_from_scene, visibility);
    penumbra_cast_mirror(visibility, mirrored);
    for (int i = 0; i < 25; ++i) result[i] = visibility[i];
    for (int i = 0; i < 21; ++i) result[25 + i] = mirrored[i];
    result[46] = penumbra_cast_ambient(mirrored);
    result[47] = float(seen);
#ifdef PENUMBRA_STRIDE4
    vec4 numbers[PENUMBRA_STRIDE4];
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q) numbers[q] = GIVEN(r * PENUMBRA_STRIDE4 + q);
    penumbra_cast_numbers(numbers, mirrored);
    for (int i = 0; i < NUMBERS; ++i) result[48 + i] = numbers[i / 4][i % 4];
#endif
}
)";
constexpr char kComputeMain[] = R"(
void main() {
    int r = int(gl_GlobalInvocationID.x);
    if (r >= receiver_count) return;
    float result[48 + NUMBERS];
    castOn(r, result);
    for (int i = 0; i < 48 + NUMBERS; ++i) results[r * (48 + NUMBERS) + i] = result[i];
}
)";
constexpr char kFragmentMain[] = R"(
void main() {
    float result[48 + NUMBERS];
    castOn(int(gl_FragCoord.x), result);
    int q = 4 * int(gl_FragCoord.y);
    color = vec4(result[q], result[q + 1], result[q + 2], result[q + 3]);
}
)";
constexpr char kWholePicture[] = R"(#version 430 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

std::string castText(const penumbra_asset* asset) {
    std::size_t length = 0;
    EXPECT_EQ(penumbra_cast_get_glsl(asset, nullptr, 0, &length, nullptr), PENUMBRA_OK);
    std::string text(length + 1, '?');
    EXPECT_EQ(penumbra_cast_get_glsl(asset, text.data(), length, &length, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(text[0], '?');
    EXPECT_EQ(penumbra_cast_get_glsl(asset, text.data(), text.size(), &length, nullptr), PENUMBRA_OK);
    EXPECT_EQ(std::strlen(text.c_str()), length);
    return text.c_str();
}

std::string shadingTextOf(const Asset& asset) {
    const Shading shading = capi_test::shading(asset);
    std::size_t length = 0;
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), nullptr, 0, &length, nullptr), PENUMBRA_OK);
    std::string text(length + 1, '?');
    EXPECT_EQ(penumbra_shading_get_glsl(shading.get(), text.data(), text.size(), &length, nullptr), PENUMBRA_OK);
    return text.c_str();
}

struct CastInputs {
    std::vector<CasterSphere> spheres;
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> numbers = {0, 0, 0, 0};
    std::size_t stride = 0;  // of the numbers
    int left_out[2] = {0, 0};
    std::string texts;

    std::size_t rowSize() const { return kCastResults + stride; }
    CastPoints points() const { return {positions, normals, tangents}; }
};

std::vector<float> receiverTexels(const CastInputs& inputs) {
    std::vector<float> texels;
    for (std::size_t r = 0; r < inputs.positions.size(); ++r)
        for (const Vec3 v : {inputs.positions[r], inputs.normals[r], inputs.tangents[r]})
            texels.insert(texels.end(), {v.x, v.y, v.z, 0.0f});
    return texels;
}

std::vector<float> capLogs() {
    std::vector<float> texels(4 * PENUMBRA_CAP_LOG_TEXELS);
    EXPECT_EQ(penumbra_get_cap_logs(texels.data(), nullptr), PENUMBRA_OK);
    return texels;
}

void setCounts(const GlObject& program, const CastInputs& inputs) {
    const auto set = [&](const char* name, int value) {
        gl::Uniform1i(gl::GetUniformLocation(program.id(), name), value);
    };
    set("sphere_count", int(inputs.spheres.size()));
    set("receiver_count", int(inputs.positions.size()));
    set("left_out_begin", inputs.left_out[0]);
    set("left_out_end", inputs.left_out[1]);
}

// Returns [receivers, rowSize()].
std::vector<float> computed(const CastInputs& inputs) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeComputeProgram(kComputeBuffers + inputs.texts + kCommon + kComputeMain);
    gl::UseProgram(program.id());
    setCounts(program, inputs);
    const std::vector<float> receivers = receiverTexels(inputs), logs = capLogs();
    std::vector<GlObject> buffers;
    const auto bind = [&](auto values) {
        buffers.push_back(makeBuffer(GL_SHADER_STORAGE_BUFFER, values));
        gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(buffers.size() - 1), buffers.back().id());
    };
    std::vector<float> results(inputs.positions.size() * inputs.rowSize(), -7.0f);
    bind(std::span(inputs.spheres));
    for (const std::vector<float>* values : {&logs, &receivers, &inputs.numbers}) bind(std::span<const float>(*values));
    bind(std::span<const float>(results));
    gl::DispatchCompute(GLuint((inputs.positions.size() + 63) / 64), 1, 1);
    gl::MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto size = GLsizeiptr(results.size() * sizeof(float));
    std::memcpy(results.data(), gl::MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, size, GL_MAP_READ_BIT),
                std::size_t(size));
    checkGl("casting");
    return results;
}

// Does the same by drawing: a column for each receiver, 4 numbers a pixel.
std::vector<float> drawnCast(const CastInputs& inputs) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeProgram(kWholePicture, kFragmentBuffers + inputs.texts + kCommon + kFragmentMain);
    gl::UseProgram(program.id());
    setCounts(program, inputs);
    const std::vector<float> receivers = receiverTexels(inputs), logs = capLogs();
    std::vector<TextureBuffer> buffers;
    const auto bind = [&](const char* name, auto values) {
        const auto unit = GLint(buffers.size());
        gl::ActiveTexture(GLenum(GL_TEXTURE0 + unit));
        buffers.push_back(makeTextureBuffer(GL_RGBA32F, values));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffers.back().texture.id());
        gl::Uniform1i(gl::GetUniformLocation(program.id(), name), unit);
    };
    bind("spheres", std::span(inputs.spheres));
    bind("cap_logs", std::span<const float>(logs));
    bind("receivers", std::span<const float>(receivers));
    bind("given", std::span<const float>(inputs.numbers));
    const std::size_t rows = inputs.rowSize() / 4, count = inputs.positions.size();
    const OffscreenTarget target(int(count), int(rows), 1);
    target.begin();
    const GlObject vertex_array = makeVertexArray();
    gl::BindVertexArray(vertex_array.id());
    const std::vector<std::uint32_t> triangle = {0, 1, 2};
    const GlObject indices = makeBuffer(GL_ELEMENT_ARRAY_BUFFER, std::span<const std::uint32_t>(triangle));
    gl::DrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, nullptr);
    checkGl("drawing");
    const Image image = target.read();
    std::vector<float> results;
    for (std::size_t r = 0; r < count; ++r)
        for (std::size_t q = 0; q < rows; ++q) {
            const std::size_t pixel = (rows - 1 - q) * count + r;
            for (std::size_t c = 0; c < 3; ++c) results.push_back(image.pixels[pixel][int(c)]);
            results.push_back(image.alpha[pixel]);
        }
    return results;
}

// Some 30 spheres in a space as large as two people, and receivers among them, inside of them, and as far away as
// spheres count.
CastInputs someCasters(std::size_t receivers) {
    CastInputs inputs;
    synthetic::Noise noise(11);
    for (int s = 0; s < 30; ++s)
        inputs.spheres.push_back({{0.6f * noise(), 1 + noise(), 0.4f * noise()}, 0.12f + 0.08f * noise()});
    for (std::size_t r = 0; r < receivers; ++r) {
        const float reach = r % 8 == 7 ? 12.0f : r % 8 == 6 ? 5.0f : 1.0f;
        Vec3 position = Vec3{0, 1, 0} + Vec3{noise(), noise(), noise()} * reach;
        if (r % 8 == 0) {  // near the surface of a sphere, on either side of it
            const CasterSphere& sphere = inputs.spheres[r / 8 % 30];
            const Vec3 away = normalized(Vec3{noise(), noise(), noise()});
            position = sphere.centre + away * (sphere.radius * (1 + 0.2f * noise()));
        }
        inputs.positions.push_back(position);
        inputs.normals.push_back(normalized(Vec3{noise(), noise(), noise()}));
        inputs.tangents.push_back(tangentOf(inputs.normals.back(), {noise(), noise(), noise()}));
    }
    inputs.positions[1] = inputs.spheres[0].centre;
    inputs.texts = castText(nullptr);
    return inputs;
}

// The largest difference of columns [first, first + count) of the results from `expected` [receivers, stride].
double worstOf(const CastInputs& inputs, std::span<const float> results, std::size_t first, std::size_t count,
               std::span<const float> expected, std::size_t stride) {
    double worst = 0;
    for (std::size_t r = 0; r < inputs.positions.size(); ++r)
        for (std::size_t i = 0; i < count; ++i)
            worst = std::max(
                worst, std::abs(double(results[r * inputs.rowSize() + first + i]) - double(expected[r * stride + i])));
    return worst;
}

// Measured: numbers within 1.4e-5 of 3.5, E within 4.4e-6. Half a step of an 8-bit picture is 2e-3.
TEST(CastGlsl, GivesWhatTheCpuGivesAtAnyPoint) {
    CastInputs inputs = someCasters(1000);
    inputs.left_out[0] = 4;
    inputs.left_out[1] = 9;
    std::vector<CasterSphere> counted = inputs.spheres;
    counted.erase(counted.begin() + 4, counted.begin() + 9);
    std::vector<float> mirrored(inputs.positions.size() * kMirroredCast), e;
    castMirrored(counted, inputs.points(), kSphereFade, mirrored);
    std::array<float, kMirroredCast> weights;
    ambientWeights({BelowHorizon::kMirrored, kFieldOrder}, weights);
    float darkest = 1;
    for (std::size_t r = 0; r < inputs.positions.size(); ++r) {
        float sum = 0;
        for (std::size_t i = 0; i < kMirroredCast; ++i) sum += weights[i] * mirrored[r * kMirroredCast + i];
        e.push_back(std::clamp(sum, 0.0f, 1.0f));
        darkest = std::min(darkest, e.back());
    }
    EXPECT_LT(darkest, 0.15f);
    for (const bool compute : {true, false}) {
        const std::vector<float> results = compute ? computed(inputs) : drawnCast(inputs);
        ASSERT_EQ(results.size(), inputs.positions.size() * inputs.rowSize());
        const double numbers = worstOf(inputs, results, 25, kMirroredCast, mirrored, kMirroredCast);
        const double ambient = worstOf(inputs, results, 46, 1, e, 1);
        std::printf("%s shader: numbers within %.1e, E within %.1e\n", compute ? "compute" : "fragment", numbers,
                    ambient);
        EXPECT_LT(numbers, 5e-5);
        EXPECT_LT(ambient, 2e-5);
        std::size_t open = 0;
        for (std::size_t r = 0; r < inputs.positions.size(); ++r) {
            const float* row = &results[r * inputs.rowSize()];
            if (row[47] != 0) continue;
            ++open;
            EXPECT_EQ(row[0], 2 * float(std::sqrt(M_PI)));
            for (std::size_t i = 1; i < 25; ++i) EXPECT_EQ(row[i], 0.0f);
        }
        EXPECT_GT(open, 10u);
        EXPECT_LT(open, 500u);
    }
}

// In the frame of the scene. All spheres count whole within 28 radii, and no receiver is inside of one, where scenes
// have a rule of their own. Measured with all spheres: 3.1e-6.
TEST(CastGlsl, GivesTheVisibilityOverTheWholeSphere) {
    CastInputs inputs = someCasters(300);
    for (std::size_t r = 0; r < 300; ++r) {
        inputs.positions[r] = Vec3{0, 1, 0} + normalized(inputs.positions[r] - Vec3{0, 1, 0}) * 0.2f;
        inputs.normals[r] = {0, 0, 1};
        inputs.tangents[r] = {1, 0, 0};
    }
    inputs.spheres.erase(inputs.spheres.begin() + 15, inputs.spheres.end());
    for (CasterSphere& sphere : inputs.spheres) sphere.radius = std::max(sphere.radius, 0.08f);
    std::erase_if(inputs.spheres, [](const CasterSphere& s) {
        return length(s.centre - Vec3{0, 1, 0}) < s.radius + 0.2f;
    });
    inputs.spheres.push_back({{0, 1, 0}, 0});  // hides nothing
    std::vector<float> expected(300 * 25);
    castVisibility(kCastOrder, inputs.spheres, inputs.positions, expected);
    const double worst = worstOf(inputs, computed(inputs), 0, 25, expected, 25);
    std::printf("visibility within %.1e\n", worst);
    EXPECT_LT(worst, 2e-5);
}

// An asset that casts by spheres.
std::vector<std::byte> sphereTube(const char* convention) {
    synthetic::TubeOptions tube{.rings = 12, .segments = 9};
    tube.convention = parseConvention(convention);
    const Model model = synthetic::tubeModel(tube);
    SphereBlockers blockers;
    for (std::size_t j = 0; j < model.joint_centers.size(); ++j) {
        blockers.spheres.push_back({model.joint_centers[j], 0.3f});
        blockers.joints.push_back(std::uint16_t(j));
    }
    return packAsset(model, materials(), lights(3), {.precision = AssetPrecision::kI8, .blockers = blockers}, "{}", 1)
        .bytes;
}

Affine affineOf(const float* rows) {
    Affine out;
    std::copy_n(rows, 12, out.m.begin());
    return out;
}

// Two characters of one asset, which stand beside one another.
struct CastPair {
    static constexpr float kPlaces[2][12] = {{0.6f, 0, 0.8f, 0.4f, 0, 1, 0, 0.3f, -0.8f, 0, 0.6f, 0.2f},
                                             {1, 0, 0, -0.3f, 0, 1, 0, 0, 0, 0, 1, 0}};
    Scene scene;
    Character characters[2];
    std::vector<CasterSphere> spheres;  // of the first, then of the second

    explicit CastPair(const Asset& asset) {
        penumbra_scene* made = nullptr;
        const penumbra_asset* casters[2] = {asset.get(), asset.get()};
        int status = penumbra_scene_create(casters, 2, &made, nullptr);
        scene.reset(made);
        const std::size_t count = penumbra_asset_sphere_count(asset.get());
        spheres.resize(2 * count);
        for (std::size_t c = 0; c < 2; ++c) {
            characters[c] = capi_test::character(asset);
            const penumbra_character* character = characters[c].get();
            status |= penumbra_character_set_frame(characters[c].get(), c, nullptr);
            status |= penumbra_scene_set_caster(scene.get(), c, character, kPlaces[c], nullptr);
            status |= penumbra_character_get_spheres(character, kPlaces[c], &spheres[c * count].centre.x, nullptr);
        }
        EXPECT_EQ(status, PENUMBRA_OK);
    }
};

// The vertices of the second character, whose own spheres are left out.
CastInputs secondOf(const CastPair& pair, const Asset& asset, const Frame& frame) {
    CastInputs inputs;
    const penumbra_asset_info info = infoOf(asset);
    const Affine placed = affineOf(CastPair::kPlaces[1]);
    for (std::size_t v = 0; v < info.vertex_count; ++v) {
        const auto at = [&](const std::vector<float>& a) { return Vec3{a[3 * v], a[3 * v + 1], a[3 * v + 2]}; };
        inputs.positions.push_back(placed.point(at(frame.positions)));
        inputs.normals.push_back(placed.linear() * at(frame.normals));
        inputs.tangents.push_back(placed.linear() * at(frame.tangents));
    }
    inputs.spheres = pair.spheres;
    inputs.numbers = frame.numbers;
    inputs.stride = info.stride;
    inputs.left_out[0] = int(pair.spheres.size() / 2);
    inputs.left_out[1] = int(pair.spheres.size());
    inputs.texts = kNoShading + shadingTextOf(asset) + castText(asset.get());
    return inputs;
}

// Measured: 1.4e-6.
TEST(CastGlsl, CastsOnCharactersAsTheSceneDoes) {
    for (const char* convention : {"D5", "A4", "B3"}) {
        const std::vector<std::byte> bytes = sphereTube(convention);
        const Asset asset = open(bytes);
        const penumbra_asset_info info = infoOf(asset);
        ASSERT_GT(penumbra_asset_sphere_count(asset.get()), 1u);
        const CastPair pair(asset);
        Frame frame(info);
        frame.evaluate(pair.characters[1].get(), info);
        const CastInputs inputs = secondOf(pair, asset, frame);
        ASSERT_EQ(penumbra_scene_cast(pair.scene.get(), 1, pair.characters[1].get(), CastPair::kPlaces[1], 0,
                                      info.vertex_count, frame.numbers.data(), nullptr),
                  PENUMBRA_OK);
        for (const bool compute : {true, false}) {
            const std::vector<float> results = compute ? computed(inputs) : drawnCast(inputs);
            const auto worst = [&](const std::vector<float>& expected) {
                return worstOf(inputs, results, kCastResults, info.number_count, expected, info.stride);
            };
            EXPECT_GT(worst(inputs.numbers), 0.1) << "nothing is cast";
            EXPECT_LT(worst(frame.numbers), 1e-5) << convention;
            std::printf("%s, %s shader: numbers within %.1e\n", convention, compute ? "compute" : "fragment",
                        worst(frame.numbers));
        }
    }
}

TEST(CastGlsl, WrongCallsAreRefused) {
    const std::vector<std::byte> bytes = sphereTube("D5"), plain = packed();
    const Asset asset = open(bytes), without = open(plain);
    const Character character = capi_test::character(asset);
    float spheres[4 * 64], scaled[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    ASSERT_LE(penumbra_asset_sphere_count(asset.get()), 64u);
    EXPECT_EQ(penumbra_asset_sphere_count(without.get()), 0u);
    EXPECT_EQ(penumbra_asset_sphere_count(nullptr), 0u);
    EXPECT_EQ(penumbra_character_get_spheres(nullptr, nullptr, spheres, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), nullptr, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), scaled, spheres, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_spheres(character.get(), nullptr, spheres, nullptr), PENUMBRA_OK);
    EXPECT_EQ(penumbra_cast_get_glsl(nullptr, nullptr, 0, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_get_cap_logs(nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
}

}  // namespace
}  // namespace penumbra
