// Height fields through the C interface: the classes behind it, and refusals.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "sh/height/analytic_heights.h"
#include "sh/height/field_in_scene.h"
#include "sh/height/height_visibility.h"
#include "tests/capi/packed_asset.h"
#include "tests/difference.h"
#include "tests/runtime/count_allocations.h"

namespace penumbra::test_heights {
namespace {

using namespace capi_test;
using ::testing::HasSubstr;

struct FreeHeights {
    void operator()(penumbra_heights* field) const { penumbra_heights_destroy(field); }
};
using Heights = std::unique_ptr<penumbra_heights, FreeHeights>;

constexpr penumbra_heights_options kOptions = {40, 50, 0.1f, 0.2f, {1, 2, 3}, PENUMBRA_BORDER_CLAMPED, 0, 0};

std::vector<float> dunes(double seconds = 0) {
    std::vector<float> heights(2000);
    analyticHeights(parseAnalyticHeights("dunes:height=1,length=3"), {40, 50, 0.2f, 0.1f}, seconds, 0, 40, heights);
    return heights;
}

Heights make(const std::vector<float>& heights, const penumbra_heights_options& options = kOptions) {
    penumbra_heights* field = nullptr;
    penumbra_error error{};
    EXPECT_EQ(penumbra_heights_create(&options, heights.data(), &field, &error), PENUMBRA_OK) << error.message;
    return Heights(field);
}

struct FieldPoints {
    std::vector<float> positions, normals, tangents, coefficients, radiance;
    explicit FieldPoints(std::size_t count = 2000)
        : positions(3 * count),
          normals(3 * count),
          tangents(3 * count),
          coefficients(PENUMBRA_HEIGHTS_STRIDE * count),
          radiance(3 * count) {}
    penumbra_vertices view() {
        return {positions.data(),     normals.data(), tangents.data(), coefficients.data(), nullptr, 0,
                positions.size() / 3, nullptr};
    }
    void read(const penumbra_heights* field, std::size_t first = 0, std::size_t rows = 40) {
        const penumbra_vertices points = view();
        EXPECT_EQ(penumbra_heights_get_points(field, first, rows, &points, nullptr), PENUMBRA_OK);
    }
};

void updateAll(penumbra_heights* field) {
    EXPECT_EQ(penumbra_heights_update(field, 0, penumbra_heights_update_rows(field), nullptr), PENUMBRA_OK);
}

TEST(CApiHeights, GiveWhatTheClassesGive) {
    const Heights field = make(dunes());
    updateAll(field.get());
    FieldPoints points;
    points.read(field.get());
    const HeightField plain({40, 50, 0.2f, 0.1f}, dunes());
    HeightVisibility visibility(plain, 5, 4);
    visibility.evaluate(plain, 0, visibility.receiverRows());
    std::vector<Vec3> normals(50), tangents(50);
    std::vector<float> coefficients(50 * PENUMBRA_HEIGHTS_STRIDE);
    for (std::size_t r = 0; r < 40; ++r) {
        visibility.coefficients(plain, int(r), 0, normals, tangents, PENUMBRA_HEIGHTS_STRIDE, coefficients);
        for (std::size_t c = 0; c < 50; ++c) {
            const std::size_t at = r * 50 + c;
            EXPECT_FLOAT_EQ(points.positions[3 * at], 1 + 0.1f * float(c));
            EXPECT_FLOAT_EQ(points.positions[3 * at + 1], 2 + plain.heights()[at]);
            EXPECT_FLOAT_EQ(points.positions[3 * at + 2], 3 + 0.2f * float(r));
            EXPECT_EQ(points.normals[3 * at + 1], normals[c].z);
            for (std::size_t i = 0; i < 15; ++i)
                EXPECT_EQ(points.coefficients[at * PENUMBRA_HEIGHTS_STRIDE + i],
                          coefficients[c * PENUMBRA_HEIGHTS_STRIDE + i]);
        }
    }
    // A point, and the middle of a square, where the two triangles meet.
    const float places[] = {1 + 0.1f * 7, 3 + 0.2f * 9, 1 + 0.1f * 20.5f, 3 + 0.2f * 30.5f};
    float heights[2] = {};
    EXPECT_EQ(penumbra_heights_query(field.get(), places, 2, heights, nullptr), PENUMBRA_OK);
    EXPECT_NEAR(heights[0], 2 + plain.heights()[9 * 50 + 7], 1e-5);
    EXPECT_NEAR(heights[1], 2 + (plain.heights()[31 * 50 + 20] + plain.heights()[30 * 50 + 21]) / 2, 1e-5);
}

// As "on_ground" of a scene has it.
TEST(CApiHeights, TellTheGroundUnderAPose) {
    const Heights field = make(dunes());
    const HeightField plain({40, 50, 0.2f, 0.1f}, dunes());
    const std::vector<Vec3> pose = {{0.1f, 0.3f, 0.2f}, {0.4f, 0.31f, 0.9f}, {0.2f, 1.7f, 0.5f}};
    const float placed[] = {0, 0, 1, 2.5f, 0, 1, 0, 7, -1, 0, 0, 6.5f};
    float height = 0;
    ASSERT_EQ(penumbra_heights_under(field.get(), &pose[0].x, pose.size(), placed, &height, nullptr), PENUMBRA_OK);
    EXPECT_FLOAT_EQ(height,
                    float(groundUnderPose(plain, {1, 2, 3}, pose, {{0, 0, 1, 2.5f, 0, 1, 0, 7, -1, 0, 0, 6.5f}})));
    ASSERT_EQ(penumbra_heights_under(field.get(), nullptr, 0, placed, &height, nullptr), PENUMBRA_OK);
    EXPECT_FLOAT_EQ(height, float(heightOfField(plain, {1, 2, 3}, 2.5, 6.5)));
    penumbra_error error;
    const float bad[] = {0, NAN, 0};
    EXPECT_EQ(penumbra_heights_under(field.get(), bad, 1, placed, &height, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_heights_under(field.get(), nullptr, 1, placed, &height, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_heights_under(nullptr, nullptr, 0, placed, &height, &error), PENUMBRA_INVALID_ARGUMENT);
}

// With next to no tolerance all points look for themselves, whatever rows one asks for.
TEST(CApiHeights, WithAToleranceLookMoreClosely) {
    penumbra_heights_options options = kOptions;
    options.step = 1;
    const Heights field = make(dunes());
    penumbra_heights* full = nullptr;
    ASSERT_EQ(penumbra_heights_create(&options, dunes().data(), &full, nullptr), PENUMBRA_OK);
    const Heights owner(full);
    updateAll(full);
    updateAll(field.get());
    FieldPoints expected, coarse, points;
    expected.read(full);
    coarse.read(field.get());
    EXPECT_NE(coarse.coefficients, expected.coefficients);
    EXPECT_EQ(penumbra_heights_set_tolerance(field.get(), 1e-7f, nullptr), PENUMBRA_OK);
    updateAll(field.get());
    for (std::size_t first = 0; first < 40; first += 5) points.read(field.get(), first, 5);
    EXPECT_LT(largestDifference(points.coefficients, expected.coefficients), 1e-3);
    EXPECT_GT(largestDifference(coarse.coefficients, expected.coefficients), 0.05);
    EXPECT_EQ(penumbra_heights_set_tolerance(field.get(), 0, nullptr), PENUMBRA_OK);
    updateAll(field.get());
    points.read(field.get());
    EXPECT_EQ(points.coefficients, coarse.coefficients);
}

TEST(CApiHeights, AnEditGivesWhatANewFieldGivesAndAllocatesNothing) {
    const Heights edited = make(dunes());
    updateAll(edited.get());
    std::vector<float> heights = dunes(), box(6, 2.0f);
    for (std::size_t r = 11; r < 14; ++r)
        for (std::size_t c = 20; c < 22; ++c) heights[r * 50 + c] = 2;
    FieldPoints points, expected;
    points.read(edited.get());
    const std::size_t before = allocationCount();
    EXPECT_EQ(penumbra_heights_set(edited.get(), 11, 3, 20, 2, box.data(), nullptr), PENUMBRA_OK);
    updateAll(edited.get());
    points.read(edited.get());
    EXPECT_EQ(allocationCount(), before);
    const Heights whole = make(heights);
    updateAll(whole.get());
    expected.read(whole.get());
    EXPECT_EQ(points.coefficients, expected.coefficients);
}

TEST(CApiHeights, AreShadedAndShadowCharacters) {
    const std::vector<std::byte> bytes = packed();
    const Asset asset = open(bytes);
    const Heights field = make(dunes());
    updateAll(field.get());
    FieldPoints points;
    points.read(field.get());
    const float eye[3] = {5, 9, 5}, albedo[3] = {0.5f, 0.4f, 0.3f};
    const penumbra_vertices view = points.view();
    penumbra_error error{};
    EXPECT_EQ(penumbra_heights_shade(field.get(), eye, &view, points.radiance.data(), &error),
              PENUMBRA_INVALID_ARGUMENT);
    EXPECT_THAT(error.message, HasSubstr("no look yet"));
    for (const std::size_t material : {PENUMBRA_NONE, std::size_t(0)}) {
        EXPECT_EQ(penumbra_heights_set_look(field.get(), asset.get(), material, albedo, 0, nullptr, &error),
                  PENUMBRA_OK)
            << error.message;
        EXPECT_EQ(penumbra_heights_shade(field.get(), eye, &view, points.radiance.data(), nullptr), PENUMBRA_OK);
        EXPECT_GT(largestOf(points.radiance), 0.01);
    }
    const Character character = capi_test::character(asset);
    const penumbra_asset_info info = infoOf(asset);
    Frame frame(info);
    frame.evaluate(character.get(), info, 1);
    const std::vector<float> unshadowed = frame.coefficients;
    const penumbra_vertices vertices = frame.vertices();
    const float deep[12] = {1, 0, 0, 3, 0, 1, 0, 2, 0, 0, 1, 5};
    EXPECT_EQ(penumbra_heights_shadow(field.get(), character.get(), deep, &vertices, nullptr), PENUMBRA_OK);
    EXPECT_NE(frame.coefficients, unshadowed);
}

TEST(CApiHeights, RefuseWhatIsWrong) {
    penumbra_heights* field = nullptr;
    penumbra_error error{};
    const auto problem = [&](penumbra_heights_options options, float height) {
        std::vector<float> heights = dunes();
        heights[17] = height;
        EXPECT_EQ(penumbra_heights_create(&options, heights.data(), &field, &error), PENUMBRA_INVALID_ARGUMENT);
        return std::string(error.message);
    };
    EXPECT_THAT(problem(kOptions, std::nanf("")), HasSubstr("heights[17]"));
    EXPECT_THAT(problem(kOptions, 2e7f), HasSubstr("heights[17]"));
    penumbra_heights_options wrong = kOptions;
    wrong.columns = 65537;
    EXPECT_THAT(problem(wrong, 0), HasSubstr("columns is more than 65536"));
    wrong = kOptions;
    wrong.rows = 0;
    EXPECT_THAT(problem(wrong, 0), HasSubstr("rows is 0"));
    wrong = kOptions;
    for (const float cell : {0.0f, std::nanf("")}) {
        wrong.cell_x = cell;
        EXPECT_THAT(problem(wrong, 0), HasSubstr("cell"));
    }
    wrong = kOptions;
    wrong.corner[1] = std::nanf("");
    EXPECT_THAT(problem(wrong, 0), HasSubstr("corner[1] is not finite"));
    wrong = kOptions;
    wrong.order = 6;
    EXPECT_THAT(problem(wrong, 0), HasSubstr("order"));
    wrong = kOptions;
    wrong.step = 3;
    EXPECT_THAT(problem(wrong, 0), HasSubstr("step"));
    EXPECT_EQ(penumbra_heights_create(&kOptions, nullptr, &field, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const Heights good = make(dunes());
    const float one = 0;
    EXPECT_EQ(penumbra_heights_set(good.get(), 40, 1, 0, 1, &one, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_heights_update(good.get(), 0, 1000, nullptr), PENUMBRA_INVALID_ARGUMENT);
    for (const float tolerance : {-0.1f, 1.1f, std::numeric_limits<float>::quiet_NaN()})
        EXPECT_EQ(penumbra_heights_set_tolerance(good.get(), tolerance, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_heights_set_tolerance(nullptr, 0.1f, nullptr), PENUMBRA_INVALID_ARGUMENT);
    const float nan[3] = {std::nanf(""), 0, 0};
    float height = 0;
    EXPECT_EQ(penumbra_heights_shade(good.get(), nan, nullptr, nullptr, &error), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_STREQ(error.message, "eye[0] is not finite");
    EXPECT_EQ(penumbra_heights_query(good.get(), nan, 1, &height, nullptr), PENUMBRA_INVALID_ARGUMENT);
    EXPECT_EQ(penumbra_heights_under(good.get(), nan, 1, nullptr, &height, nullptr), PENUMBRA_INVALID_ARGUMENT);
    for (const int bits : {60, 63}) {  // refused before the array is read
        const std::size_t many = std::size_t(1) << bits;
        EXPECT_EQ(penumbra_heights_query(good.get(), nan, many, &height, &error), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(error.message, HasSubstr("count is"));
        EXPECT_EQ(penumbra_heights_under(good.get(), nan, many, nullptr, &height, &error), PENUMBRA_INVALID_ARGUMENT);
        EXPECT_THAT(error.message, HasSubstr("count is"));
    }
    EXPECT_EQ(penumbra_heights_update_rows(nullptr), 0u);
    penumbra_heights_destroy(nullptr);
}

}  // namespace
}  // namespace penumbra::test_heights
