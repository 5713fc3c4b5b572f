// The numbers of a camera from corners of a grid that this test projects.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "fit/camera/solve_camera.h"
#include "fit/camera/tag_grid.h"
#include "formats/common/errors.h"
#include "sh/quaternion.h"

namespace penumbra::test_solve_camera {
namespace {

using ::testing::HasSubstr;

const TagGrid kGrid{TagFamily::k36h11, 5, 7, 0.03, 0.01};

PinholeCamera trueCamera() {
    PinholeCamera camera;
    camera.f = 612;
    camera.cx = 325;
    camera.cy = 231;
    camera.width = 640;
    camera.height = 480;
    camera.k1 = -0.16;
    camera.k2 = 0.05;
    return camera;
}

// Where the corners of the grid are seen from a place whose tilt, turn and shift follow from `number`.
GridShot shotOf(int number, double tilt, double noise, std::mt19937& random) {
    std::normal_distribution<double> normal;
    const double around = number * 2.4;
    const Mat3d turn = matrixOf(multiply(rotationOf(Vec3d{tilt * std::cos(around), tilt * std::sin(around), 0}),
                                         rotationOf(Vec3d{std::numbers::pi, 0, 0})));
    const Vec3d place{0.06 * std::cos(number * 1.7), 0.05 * std::sin(number * 2.9), 0.33 + 0.02 * (number % 4)};
    std::vector<DetectedTag> tags;
    for (int id = 0; id < kGrid.columns * kGrid.rows; ++id) {
        DetectedTag tag;
        tag.id = id;
        const Vec3d middle{(id % 5 - 2) * 0.04, (3 - id / 5) * 0.04, 0};
        bool inside = true;
        for (std::size_t i = 0; i < 4; ++i) {
            const auto at = project(trueCamera(), turn * (middle + tagCorners(kGrid.side)[i]) + place);
            inside = inside && at && at->x > 0 && at->x < 639 && at->y > 0 && at->y < 479;
            if (at) tag.corners[i] = {at->x + noise * normal(random), at->y + noise * normal(random)};
        }
        if (inside) tags.push_back(tag);
    }
    return {"shot" + std::to_string(number) + ".jpg", seenGridCorners(kGrid, tags)};
}

std::vector<GridShot> shotsOf(int count, double tilt, double noise) {
    std::mt19937 random(3);
    std::vector<GridShot> out;
    for (int i = 0; i < count; ++i) out.push_back(shotOf(i, tilt, noise, random));
    return out;
}

TEST(SolveCamera, IsExactWithoutNoise) {
    const std::vector<GridShot> shots = shotsOf(8, 0.5, 0);
    const SolvedCamera solved = solveCamera(640, 480, shots);
    EXPECT_NEAR(solved.camera.f, 612, 1e-3);
    EXPECT_NEAR(solved.camera.cx, 325, 1e-3);
    EXPECT_NEAR(solved.camera.cy, 231, 1e-3);
    EXPECT_NEAR(solved.camera.k1, -0.16, 1e-5);
    EXPECT_NEAR(solved.camera.k2, 0.05, 1e-4);
    EXPECT_LE(solved.residual, 1e-4);
    EXPECT_GT(solved.coverage, 0.7);
    EXPECT_NEAR(solved.tilt, 0.5 * 180 / std::numbers::pi, 1e-3);
}

// The standard deviations are those of the errors: none is beyond four of them.
TEST(SolveCamera, TellsItsErrors) {
    const SolvedCamera solved = solveCamera(640, 480, shotsOf(12, 0.5, 0.1));
    const PinholeCamera truth = trueCamera(), &found = solved.camera;
    const double off[] = {found.f - truth.f, found.cx - truth.cx, found.cy - truth.cy, found.k1 - truth.k1,
                          found.k2 - truth.k2};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_LE(std::abs(off[i]), 4 * solved.deviations[i]) << i;
    EXPECT_LE(std::abs(off[0]), 0.002 * truth.f);
    EXPECT_LE(std::hypot(off[1], off[2]), 1);
    EXPECT_NEAR(solved.residual, 0.1 * std::sqrt(2.0), 0.01);
}

// One tag in a picture is read wrongly: its corners are 30 pixels off.
TEST(SolveCamera, BearsAWrongTag) {
    std::vector<GridShot> shots = shotsOf(8, 0.5, 0.05);
    for (std::size_t i = 0; i < 4; ++i) shots[2].points[i].pixel.x += 30;
    const SolvedCamera solved = solveCamera(640, 480, shots);
    EXPECT_NEAR(solved.camera.f, 612, 0.001 * 612);
    EXPECT_EQ(solved.strays, 4u);
    EXPECT_LE(solved.residual, 0.08);
}

TEST(SolveCamera, RefusesALevelGrid) {
    try {
        (void)solveCamera(640, 480, shotsOf(6, 0.01, 0.05));
        ADD_FAILURE();
    } catch (const InvalidInput& problem) {
        EXPECT_THAT(problem.what(), HasSubstr("shot0.jpg: the grid is level with all pictures"));
    }
    EXPECT_THROW((void)solveCamera(640, 480, {}), InvalidInput);
}

TEST(TagGrid, ReadsItsWords) {
    const TagGrid grid = parseTagGrid("25h9:6x8:0.024:0.006");
    EXPECT_EQ(grid.family, TagFamily::k25h9);
    EXPECT_EQ(grid.columns, 6);
    EXPECT_EQ(grid.rows, 8);
    EXPECT_EQ(grid.side, 0.024);
    EXPECT_EQ(grid.gap, 0.006);
    for (const char* wrong : {"", "36h11", "36h11:6x8:0.02", "99h1:6x8:0.02:0.01", "36h11:6:0.02:0.01",
                              "36h11:0x8:0.02:0.01", "36h11:6x8:0:0.01", "36h11:6x8:0.02:-1", "36h11:6x8:nan:0.01",
                              "36h11:6x8x2:0.02:0.01", "36h11:6x8:0.02m:0.01"})
        EXPECT_THROW((void)parseTagGrid(wrong), BadOption) << wrong;
}

TEST(TagGrid, LeavesOutWhatIsOfNoGridAndRefusesATagThatIsThereTwice) {
    std::vector<DetectedTag> tags(2);
    tags[0].id = 1;
    tags[1].id = 35;
    const std::vector<SeenPoint> seen = seenGridCorners(kGrid, tags);
    ASSERT_EQ(seen.size(), 4u);
    EXPECT_NEAR(seen[3].point.x, -0.04 - 0.015, 1e-12);  // upper left of the second tag of the first row
    EXPECT_NEAR(seen[3].point.y, 0.12 + 0.015, 1e-12);
    tags[1].id = 1;
    EXPECT_THROW((void)seenGridCorners(kGrid, tags), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_solve_camera
