// Tests the GLSL of casters with fields in shaders of an engine: a compute shader with storage buffers, and a fragment
// shader with texture buffers. Texts and arrays come out of the C interface. They give what the CPU gives.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "player/gl/gl_context.h"
#include "player/gl/gl_objects.h"
#include "player/gl/offscreen_target.h"
#include "player/runtime/cast/cast_shadow.h"
#include "sh/tangent.h"
#include "tests/capi/packed_asset.h"
#include "tests/synthetic_composition.h"

namespace penumbra {
namespace {

using namespace capi_test;

// For each receiver: mirrored [21], E, whether any part counts, 0; then its numbers.
constexpr std::size_t kFieldResults = 24;

constexpr char kFieldStorage[] = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer Fields { uint fields[]; };
layout(std430, binding = 1) readonly buffer Parts { vec4 parts[]; };
layout(std430, binding = 2) readonly buffer Receivers { vec4 receivers[]; };
layout(std430, binding = 3) readonly buffer Numbers { vec4 given[]; };
layout(std430, binding = 4) writeonly buffer Results { float results[]; };
#define PENUMBRA_FIELD(word) fields[word]
#define PENUMBRA_PART(part, row) parts[7 * (part) + (row)]
#define RECEIVER(i) receivers[i]
#define GIVEN(i) given[i]
)";
constexpr char kFieldTextures[] = R"(#version 430 core
uniform usamplerBuffer fields;
uniform samplerBuffer parts, receivers, given;
layout(location = 0) out vec4 color;
#define PENUMBRA_FIELD(word) texelFetch(fields, int(word)).x
#define PENUMBRA_PART(part, row) texelFetch(parts, 7 * (part) + (row))
#define RECEIVER(i) texelFetch(receivers, i)
#define GIVEN(i) texelFetch(given, i)
)";
constexpr char kFieldCommon[] = R"(
#ifndef PENUMBRA_STRIDE4
#define NUMBERS 0
#else
#define NUMBERS (4 * PENUMBRA_STRIDE4)
#endif
uniform int part_count, receiver_count, left_out_begin, left_out_end;

void castOn(int r, out float result[24 + NUMBERS]) {
    vec3 normal = RECEIVER(3 * r + 1).xyz, tangent = RECEIVER(3 * r + 2).xyz;
    mat3 local_from_scene = transpose(mat3(tangent, cross(normal, tangent), normal));
    float mirrored[21];
    bool seen = penumbra_cast_fields(part_count, ivec2(left_out_begin, left_out_end), RECEIVER(3 * r).xyz,
                                     local_from_scene, mirrored);
    if (seen) penumbra_cast_clamp(mirrored);
    for (int i = 0; i < 21; ++i) result[i] = mirrored[i];
    result[21] = penumbra_cast_ambient(mirrored);
    result[22] = float(seen);
    result[23] = 0.0;
#ifdef PENUMBRA_STRIDE4
    vec4 numbers[PENUMBRA_STRIDE4];
    for (int q = 0; q < PENUMBRA_STRIDE4; ++q) numbers[q] = GIVEN(r * PENUMBRA_STRIDE4 + q);
    penumbra_cast_numbers(numbers, mirrored);
    for (int i = 0; i < NUMBERS; ++i) result[24 + i] = numbers[i / 4][i % 4];
#endif
}
)";
constexpr char kFieldComputeMain[] = R"(
void main() {
    int r = int(gl_GlobalInvocationID.x);
    if (r >= receiver_count) return;
    float result[24 + NUMBERS];
    castOn(r, result);
    for (int i = 0; i < 24 + NUMBERS; ++i) results[r * (24 + NUMBERS) + i] = result[i];
}
)";
constexpr char kFieldFragmentMain[] = R"(
void main() {
    float result[24 + NUMBERS];
    castOn(int(gl_FragCoord.x), result);
    int q = 4 * int(gl_FragCoord.y);
    color = vec4(result[q], result[q + 1], result[q + 2], result[q + 3]);
}
)";
constexpr char kFieldPicture[] = R"(#version 430 core
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
)";

std::string textOf(const auto& get) {
    std::size_t length = 0;
    EXPECT_EQ(get(nullptr, 0, &length), PENUMBRA_OK);
    std::string text(length + 1, '?');
    EXPECT_EQ(get(text.data(), text.size(), &length), PENUMBRA_OK);
    return text.c_str();
}

std::string fieldCastText(const penumbra_asset* asset) {
    return textOf([&](char* text, std::size_t capacity, std::size_t* length) {
        return penumbra_cast_get_glsl(asset, text, capacity, length, nullptr);
    });
}

struct FieldInputs {
    std::vector<std::uint32_t> fields;
    std::vector<float> parts;
    std::vector<Vec3> positions, normals, tangents;
    std::vector<float> numbers = {0, 0, 0, 0};
    std::size_t stride = 0;  // of the numbers
    int left_out[2] = {0, 0};
    std::string texts;

    std::size_t count() const { return positions.size(); }
    std::size_t rowSize() const { return kFieldResults + stride; }
    std::vector<float> receivers() const {
        std::vector<float> texels;
        for (std::size_t r = 0; r < count(); ++r)
            for (const Vec3 v : {positions[r], normals[r], tangents[r]})
                texels.insert(texels.end(), {v.x, v.y, v.z, 0.0f});
        return texels;
    }
    void add(Vec3 position, Vec3 normal, Vec3 towards) {
        positions.push_back(position);
        normals.push_back(normal);
        tangents.push_back(tangentOf(normal, towards));
    }
};

void setFieldCounts(const GlObject& program, const FieldInputs& inputs) {
    const auto set = [&](const char* name, std::size_t value) {
        gl::Uniform1i(gl::GetUniformLocation(program.id(), name), int(value));
    };
    set("part_count", inputs.parts.size() / 28);
    set("receiver_count", inputs.count());
    set("left_out_begin", std::size_t(inputs.left_out[0]));
    set("left_out_end", std::size_t(inputs.left_out[1]));
}

// Both return [receivers, rowSize()].
std::vector<float> computedFields(const FieldInputs& inputs) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program = makeComputeProgram(kFieldStorage + inputs.texts + kFieldCommon + kFieldComputeMain);
    gl::UseProgram(program.id());
    setFieldCounts(program, inputs);
    std::vector<float> results(inputs.count() * inputs.rowSize(), -7.0f);
    const std::vector<float> receivers = inputs.receivers();
    std::vector<GlObject> buffers;
    const auto bind = [&](auto values) {
        buffers.push_back(makeBuffer(GL_SHADER_STORAGE_BUFFER, values));
        gl::BindBufferBase(GL_SHADER_STORAGE_BUFFER, GLuint(buffers.size() - 1), buffers.back().id());
    };
    bind(std::span<const std::uint32_t>(inputs.fields));
    for (const std::vector<float>* values : {&inputs.parts, &receivers, &inputs.numbers})
        bind(std::span<const float>(*values));
    bind(std::span<const float>(results));
    gl::DispatchCompute(GLuint((inputs.count() + 63) / 64), 1, 1);
    gl::MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    const auto size = GLsizeiptr(results.size() * sizeof(float));
    std::memcpy(results.data(), gl::MapBufferRange(GL_SHADER_STORAGE_BUFFER, 0, size, GL_MAP_READ_BIT),
                std::size_t(size));
    checkGl("casting");
    return results;
}

std::vector<float> drawnFields(const FieldInputs& inputs) {
    const auto context = createGlContext(GlBackend::kOsMesa);
    const GlObject program =
        makeProgram(kFieldPicture, kFieldTextures + inputs.texts + kFieldCommon + kFieldFragmentMain);
    gl::UseProgram(program.id());
    setFieldCounts(program, inputs);
    const std::vector<float> receivers = inputs.receivers();
    std::vector<TextureBuffer> buffers;
    const auto bind = [&](const char* name, GLenum format, auto values) {
        const auto unit = GLint(buffers.size());
        gl::ActiveTexture(GLenum(GL_TEXTURE0 + unit));
        buffers.push_back(makeTextureBuffer(format, values));
        gl::BindTexture(GL_TEXTURE_BUFFER, buffers.back().texture.id());
        gl::Uniform1i(gl::GetUniformLocation(program.id(), name), unit);
    };
    bind("fields", GL_R32UI, std::span<const std::uint32_t>(inputs.fields));
    bind("parts", GL_RGBA32F, std::span<const float>(inputs.parts));
    bind("receivers", GL_RGBA32F, std::span<const float>(receivers));
    bind("given", GL_RGBA32F, std::span<const float>(inputs.numbers));
    const std::size_t rows = inputs.rowSize() / 4, count = inputs.count();
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

// A tube, and beside it a ball that stands still in the tube's frame.
std::vector<std::byte> composedBytes(const char* convention, int joints) {
    synthetic::TubeOptions tube{.rings = 12, .segments = 9, .joints = joints};
    tube.convention = parseConvention(convention);
    Model model = synthetic::composedTube(tube);
    synthetic::addStillBall(model, {-1.2f, 0.4f, 0.1f});
    return packAsset(model, materials(), lights(3), {.precision = AssetPrecision::kI8}, "{}", 1).bytes;
}

// Two characters of two assets, which stand in one another.
struct FieldPair {
    static constexpr float kPlaces[2][12] = {{0.6f, 0, 0.8f, 0.4f, 0, 1, 0, 0.3f, -0.8f, 0, 0.6f, 0.2f},
                                             {1, 0, 0, 0.1f, 0, 1, 0, 0, 0, 0, 1, 0}};
    std::vector<std::byte> bytes[2];
    Asset assets[2];
    Character characters[2];
    Scene scene;
    FieldInputs inputs;
    int first_of_second = 0;  // of the parts

    explicit FieldPair(const char* convention) : bytes{composedBytes(convention, 5), composedBytes(convention, 4)} {
        penumbra_scene* made = nullptr;
        const penumbra_asset* casters[2];
        for (std::size_t c = 0; c < 2; ++c) casters[c] = (assets[c] = open(bytes[c])).get();
        EXPECT_EQ(penumbra_scene_create(casters, 2, &made, nullptr), PENUMBRA_OK);
        scene.reset(made);
        for (std::size_t c = 0; c < 2; ++c) add(c);
    }

private:
    void add(std::size_t c) {
        characters[c] = capi_test::character(assets[c]);
        first_of_second = int(c * penumbra_asset_part_count(assets[0].get()));
        const std::size_t first_word = inputs.fields.size(), first_row = inputs.parts.size();
        inputs.fields.resize(first_word + penumbra_asset_field_words(assets[c].get()));
        inputs.parts.resize(first_row + 28 * penumbra_asset_part_count(assets[c].get()));
        int status = penumbra_character_set_frame(characters[c].get(), c, nullptr);
        status |= penumbra_scene_set_caster(scene.get(), c, characters[c].get(), kPlaces[c], nullptr);
        status |= penumbra_asset_get_fields(assets[c].get(), first_word, &inputs.fields[first_word], nullptr);
        status |= penumbra_character_get_parts(characters[c].get(), kPlaces[c], first_word, &inputs.parts[first_row],
                                               nullptr);
        EXPECT_EQ(status, PENUMBRA_OK);
    }
};

// On a ground, anywhere among the characters, and as far away as parts count. Tangents are those of
// penumbra_scene_probe(): where factors ring above FarConstants::most, E depends on them a little.
void addReceivers(FieldInputs& inputs, std::size_t count) {
    synthetic::Noise noise(5);
    for (std::size_t r = 0; r < count; ++r) {
        const float reach = r % 8 == 7 ? 16.0f : r % 8 == 6 ? 5.0f : 1.2f;
        const Vec3 random{noise(), noise(), noise()};
        if (r % 4 == 0)
            inputs.add(Vec3{random.x * reach, -0.2f, random.z * reach}, {0, 1, 0}, {1, 0, 0});
        else
            inputs.add(Vec3{0, 0.8f, 0} + random * reach, normalized(Vec3{noise(), noise(), noise()}), {1, 0, 0});
    }
}

double largestOf(const FieldInputs& inputs, std::span<const float> results, std::size_t first, std::size_t count,
                 std::span<const float> expected, std::size_t stride) {
    double worst = 0;
    for (std::size_t r = 0; r < inputs.count(); ++r)
        for (std::size_t i = 0; i < count; ++i)
            worst = std::max(
                worst, std::abs(double(results[r * inputs.rowSize() + first + i]) - double(expected[r * stride + i])));
    return worst;
}

// The bound is a hundredth of the project's, half a step of an 8-bit picture. Measured: E within 8.3e-7, in both
// shaders.
TEST(CastFieldsGlsl, GivesWhatTheCpuGivesAtAnyPoint) {
    FieldPair pair("D5");
    FieldInputs& inputs = pair.inputs;
    inputs.texts = fieldCastText(nullptr);
    addReceivers(inputs, 800);
    std::vector<float> e(inputs.count());
    for (const std::size_t except : {std::size_t(PENUMBRA_NONE), std::size_t(1)}) {
        inputs.left_out[0] = pair.first_of_second;
        inputs.left_out[1] = except == 1 ? int(inputs.parts.size() / 28) : pair.first_of_second;
        ASSERT_EQ(penumbra_scene_probe(pair.scene.get(), except, &inputs.positions[0].x, &inputs.normals[0].x,
                                       inputs.count(), e.data(), nullptr, nullptr),
                  PENUMBRA_OK);
        EXPECT_LT(*std::ranges::min_element(e), 0.3f);
        for (const bool compute : {true, false}) {
            if (!compute && except == 1) continue;  // each program takes seconds to compile
            const std::vector<float> results = compute ? computedFields(inputs) : drawnFields(inputs);
            ASSERT_EQ(results.size(), inputs.count() * inputs.rowSize());
            const double worst = largestOf(inputs, results, 21, 1, e, 1);
            std::printf("%s shader: E within %.1e\n", compute ? "compute" : "fragment", worst);
            EXPECT_LT(worst, 2e-5);
            std::size_t open = 0;
            for (std::size_t r = 0; r < inputs.count(); ++r) {
                const float* row = &results[r * inputs.rowSize()];
                if (row[22] != 0) continue;
                ++open;
                EXPECT_EQ(row[0], 2 * std::sqrt(std::numbers::pi_v<float>));
                for (std::size_t i = 1; i < 21; ++i) EXPECT_EQ(row[i], 0.0f);
            }
            EXPECT_GT(open, 10u);
            EXPECT_LT(open, inputs.count() / 2);
        }
    }
}

// The vertices of the second character, whose own parts are left out.
void addVertices(FieldPair& pair, const Frame& frame) {
    FieldInputs& inputs = pair.inputs;
    const penumbra_asset_info info = infoOf(pair.assets[1]);
    Affine placed;
    std::copy_n(FieldPair::kPlaces[1], 12, placed.m.begin());
    for (std::size_t v = 0; v < info.vertex_count; ++v) {
        const auto at = [&](const std::vector<float>& a) { return Vec3{a[3 * v], a[3 * v + 1], a[3 * v + 2]}; };
        inputs.positions.push_back(placed.point(at(frame.positions)));
        inputs.normals.push_back(placed.linear() * at(frame.normals));
        inputs.tangents.push_back(placed.linear() * at(frame.tangents));
    }
    inputs.numbers = frame.numbers;
    inputs.stride = info.stride;
    inputs.left_out[0] = pair.first_of_second;
    inputs.left_out[1] = int(inputs.parts.size() / 28);
}

// Measured: 1.4e-6.
TEST(CastFieldsGlsl, CastsOnCharactersAsTheSceneDoes) {
    for (const char* convention : {"D5"}) {
        FieldPair pair(convention);
        const penumbra_asset_info info = infoOf(pair.assets[1]);
        Frame frame(info);
        frame.evaluate(pair.characters[1].get(), info);
        addVertices(pair, frame);
        const Shading shading = capi_test::shading(pair.assets[1]);
        pair.inputs.texts = "#define PENUMBRA_MATERIAL(i) vec4(0)\n#define PENUMBRA_LIGHT(i) vec4(0)\n" +
                            textOf([&](char* text, std::size_t capacity, std::size_t* length) {
                                return penumbra_shading_get_glsl(shading.get(), text, capacity, length, nullptr);
                            }) +
                            fieldCastText(pair.assets[1].get());
        ASSERT_EQ(penumbra_scene_cast(pair.scene.get(), 1, pair.characters[1].get(), FieldPair::kPlaces[1], 0,
                                      info.vertex_count, frame.numbers.data(), nullptr),
                  PENUMBRA_OK);
        const std::vector<float> results = computedFields(pair.inputs);
        const auto worst = [&](const std::vector<float>& expected) {
            return largestOf(pair.inputs, results, kFieldResults, info.number_count, expected, info.stride);
        };
        EXPECT_GT(worst(pair.inputs.numbers), 0.1) << "nothing is cast";
        EXPECT_LT(worst(frame.numbers), 5e-5) << convention;
        std::printf("%s: numbers within %.1e\n", convention, worst(frame.numbers));
    }
}

TEST(CastFieldsGlsl, WrongCallsAreRefused) {
    FieldPair pair("D5");
    const std::vector<std::byte> plain = packed();
    const Asset without = open(plain);
    const penumbra_asset* const asset = pair.assets[0].get();
    const penumbra_character* const character = pair.characters[0].get();
    std::uint32_t* const words = pair.inputs.fields.data();
    float* const rows = pair.inputs.parts.data();
    const Character other = capi_test::character(without);
    float scaled[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
    EXPECT_EQ(penumbra_asset_field_words(asset) % 4, 0u);
    EXPECT_EQ(penumbra_asset_part_count(without.get()), 0u);
    EXPECT_EQ(penumbra_asset_part_count(nullptr), 0u);
    EXPECT_EQ(penumbra_asset_field_words(without.get()), 0u);
    EXPECT_EQ(penumbra_asset_field_words(nullptr), 0u);
    EXPECT_EQ(penumbra_asset_get_fields(nullptr, 0, words, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_fields(asset, 0, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_asset_get_fields(without.get(), 0, words, nullptr), PENUMBRA_UNSUPPORTED);
    for (const std::size_t first :
         {std::size_t(2), std::size_t(1) << 26, (std::size_t(1) << 26) - 4, ~std::size_t(3)}) {
        EXPECT_EQ(penumbra_asset_get_fields(asset, first, words, nullptr), PENUMBRA_INVALID_ARGUMENT) << first;
        EXPECT_EQ(penumbra_character_get_parts(character, nullptr, first, rows, nullptr), PENUMBRA_INVALID_ARGUMENT);
    }
    EXPECT_EQ(penumbra_character_get_parts(nullptr, nullptr, 0, rows, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_parts(character, nullptr, 0, nullptr, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_parts(character, scaled, 0, rows, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_character_get_parts(other.get(), nullptr, 0, rows, nullptr), PENUMBRA_UNSUPPORTED);
}

}  // namespace
}  // namespace penumbra
