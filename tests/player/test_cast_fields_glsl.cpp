// Tests the GLSL of casters with fields in shaders of an engine: a compute shader with storage buffers, and a fragment
// shader with texture buffers. Texts and arrays come out of the C interface. They give what the CPU gives.
#include <gtest/gtest.h>

#include <algorithm>

#include "runtime/cast/cast_shadow.h"
#include "sh/tangent.h"
#include "tests/capi/packed_asset.h"
#include "tests/player/cast_shaders.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_cast_fields_glsl {
namespace {

using namespace capi_test;
using namespace player_test;

// For each receiver: mirrored [21], E, whether any part counts, 0; then its numbers.
constexpr CastShaders kFieldShaders{R"(
layout(std430, binding = 0) readonly buffer Fields { uint fields[]; };
layout(std430, binding = 1) readonly buffer Parts { vec4 parts[]; };
#define PENUMBRA_FIELD(word) fields[word]
#define PENUMBRA_PART(part, row) parts[7 * (part) + (row)]
)",
                                    R"(
uniform usamplerBuffer fields;
uniform samplerBuffer parts;
#define PENUMBRA_FIELD(word) texelFetch(fields, int(word)).x
#define PENUMBRA_PART(part, row) texelFetch(parts, 7 * (part) + (row))
)",
                                    R"(
void castAt(vec3 place, mat3 local_from_scene, inout float result[RESULTS + NUMBERS], out float mirrored[21]) {
    bool seen = penumbra_cast_fields(part_count, ivec2(left_out_begin, left_out_end), place, local_from_scene,
                                     mirrored);
    if (seen) penumbra_cast_clamp(mirrored);
    for (int i = 0; i < 21; ++i) result[i] = mirrored[i];
    result[21] = penumbra_cast_ambient(mirrored);
    result[22] = float(seen);
    result[23] = 0.0;
}
)",
                                    "part_count", 24};

struct FieldInputs : CastInputs {
    std::vector<std::uint32_t> fields;
    std::vector<float> parts;

    int partCount() const { return int(parts.size() / 28); }
    CastProgram program() const {
        return {kFieldShaders,
                *this,
                {CasterBuffer{"fields", GL_R32UI, bytesOf(fields)}, {"parts", GL_RGBA32F, bytesOf(parts)}},
                partCount()};
    }
    void add(Vec3 position, Vec3 normal, Vec3 towards) {
        positions.push_back(position);
        normals.push_back(normal);
        tangents.push_back(tangentOf(normal, towards));
    }
};

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
// penumbra_scene_ambient(): where factors ring above FarConstants::most, E depends on them a little.
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

// The bound is a hundredth of the project's, half a step of an 8-bit picture. Measured: E within 8.3e-7, in both
// shaders.
TEST(CastFieldsGlsl, GivesWhatTheCpuGivesAtAnyPoint) {
    FieldPair pair("D5");
    FieldInputs& inputs = pair.inputs;
    inputs.texts = castText(nullptr);
    addReceivers(inputs, 800);
    std::vector<float> e(inputs.count());
    for (const std::size_t except : {std::size_t(PENUMBRA_NONE), std::size_t(1)}) {
        inputs.left_out[0] = pair.first_of_second;
        inputs.left_out[1] = except == 1 ? inputs.partCount() : pair.first_of_second;
        const penumbra_points points{&inputs.positions[0].x, &inputs.normals[0].x, inputs.count()};
        ASSERT_EQ(penumbra_scene_ambient(pair.scene.get(), except, &points, e.data(), nullptr), PENUMBRA_OK);
        EXPECT_LT(*std::ranges::min_element(e), 0.3f);
        for (const bool compute : {true, false}) {
            if (!compute && except == 1) continue;  // each program takes seconds to compile
            const CastProgram program = inputs.program();
            const std::vector<float> results = compute ? program.computed() : program.drawn();
            const double worst = program.difference(results, 21, 1, e, 1);
            std::printf("%s shader: E within %.1e\n", compute ? "compute" : "fragment", worst);
            EXPECT_LT(worst, 2e-5);
            const std::size_t open = program.expectOpen(results, 22, 21);
            EXPECT_GT(open, 10u);
            EXPECT_LT(open, inputs.count() / 2);
        }
    }
}

// Measured: 1.4e-6.
TEST(CastFieldsGlsl, CastsOnCharactersAsTheSceneDoes) {
    for (const char* convention : {"D5"}) {
        FieldPair pair(convention);
        const penumbra_asset_info info = infoOf(pair.assets[1]);
        Frame frame(info);
        frame.evaluate(pair.characters[1].get(), info);
        pair.inputs.addVertices(frame, info, affineOf(FieldPair::kPlaces[1]), pair.first_of_second,
                                pair.inputs.partCount());  // without its own parts
        pair.inputs.texts = castTextOf(pair.assets[1]);
        ASSERT_EQ(frame.cast(pair.scene.get(), 1, pair.characters[1].get(), FieldPair::kPlaces[1]), PENUMBRA_OK);
        const CastProgram program = pair.inputs.program();
        const std::vector<float> results = program.computed();
        const auto worst = [&](const std::vector<float>& expected) {
            return program.difference(results, kFieldShaders.results, info.coefficient_count, expected, info.stride);
        };
        EXPECT_GT(worst(pair.inputs.coefficients), 0.1) << "nothing is cast";
        EXPECT_LT(worst(frame.coefficients), 5e-5) << convention;
        std::printf("%s: numbers within %.1e\n", convention, worst(frame.coefficients));
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
}  // namespace penumbra::test_cast_fields_glsl
