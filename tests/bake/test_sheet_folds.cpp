// Crumpled, folded and draped sheets, compared with brute force and with the wedge that the inside of a fold sees.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>

#include "formats/cache/numpy_array.h"
#include "formats/cache/zip_archive.h"
#include "tests/bake/sheets.h"
#include "tests/difference.h"

namespace penumbra::test_sheet_folds {
namespace {

using namespace sheets;
using shapes::Shape;

// --- Brute force ----------------------------------------------------------------------------------------------------

// Moments by 64 x 64 jittered directions of the hemisphere in double, without an acceleration structure.
std::vector<double> bruteForce(const Shape& scene, Vec3d start, Vec3d normal, std::mt19937& random) {
    constexpr int kSteps = 64;
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vec3d side = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Vec3d other = cross(normal, side);
    const std::vector<shapes::SeenTriangle> seen = shapes::seenFrom(start, scene);
    std::vector<double> y(kSize), b(kSize);
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double z = (i + uniform(random)) / kSteps, a = 2 * std::numbers::pi * (j + uniform(random)) / kSteps;
            const double r = std::sqrt(1 - z * z);
            const Vec3d d = side * (r * std::cos(a)) + other * (r * std::sin(a)) + normal * z;
            if (shapes::blocked(seen, d)) continue;
            evalBasis(kOrder, d, y);
            for (std::size_t k = 0; k < kSize; ++k) b[k] += y[k] * 2 * std::numbers::pi / (kSteps * kSteps);
        }
    return b;
}

// Relative error of both sides of every `step`-th vertex from `first` on.
double errorAgainstBruteForce(const Shape& shape, const Shape& occluder, std::size_t step, std::size_t first = 0) {
    const Sheet sheet = sheetOf(shape);
    const std::vector<float> b = momentsOf(shape, occluder);
    Shape all = shape;
    shapes::append(all, occluder);
    const double lift = 1e-6 * boxDiagonal(shape.positions);
    std::mt19937 random(7);
    double difference = 0, sum = 0;
    for (std::size_t v = first; v < shape.positions.size(); v += step)
        for (const int side : {1, -1}) {
            const std::size_t s = side > 0 ? v : shape.positions.size() + v;
            const std::vector<double> expected =
                bruteForce(all, toDouble(sheet.positions[s]) + toDouble(sheet.normals[s]) * lift,
                           toDouble(sheet.normals[s]), random);
            for (std::size_t k = 0; k < kSize; ++k) {
                difference += std::pow(double(b[s * kSize + k]) - expected[k], 2);
                sum += expected[k] * expected[k];
            }
        }
    return std::sqrt(difference / sum);
}

// A handkerchief crumpled by two waves: slopes of up to 37 and 66 degrees.
TEST(Sheets, CrumpledSheetMatchesBruteForce) {
    for (const double height : {0.05, 0.15}) {
        Shape sheet = grid(21, 0);
        for (Vec3& p : sheet.positions)
            p = toFloat({p.x * 0.4,
                         height * (std::sin(6 * double(p.x) + 2 * double(p.z)) + 0.4 * std::sin(5 * double(p.z))),
                         p.z * 0.5});
        const double error = errorAgainstBruteForce(sheet, {}, 29);
        std::printf("crumpled sheet of height %.2f against brute force: %.3f%%\n", height, 100 * error);
        EXPECT_LT(error, 0.02) << height;
    }
}

// --- Folds ----------------------------------------------------------------------------------------------------------

constexpr std::array kFromFold{0.0, 1e-3, 1e-2, 0.1, 1.0};

// A sheet of 2 x 2 that is folded along z, `wedge` radians between its halves; fronts inside. Vertex 3 k + 1 of a half
// is in its middle, kFromFold[k] from the fold.
Shape foldedSheet(double wedge) {
    Shape s;
    const auto columns = std::uint32_t(kFromFold.size());
    for (const Vec3d along : {Vec3d{1, 0, 0}, Vec3d{std::cos(wedge), std::sin(wedge), 0}})
        for (std::uint32_t k = s.positions.empty() ? 0 : 1; k < columns; ++k)
            for (const double z : {-1.0, 0.0, 1.0})
                s.positions.push_back(toFloat(along * kFromFold[k] + Vec3d{0, 0, z}));
    const auto vertex = [&](bool second, std::uint32_t k, std::uint32_t row) {
        return 3 * (second && k > 0 ? columns - 1 + k : k) + row;
    };
    for (const bool second : {false, true})
        for (std::uint32_t k = 0; k + 1 < columns; ++k)
            for (std::uint32_t row = 0; row < 2; ++row) {
                const std::uint32_t a = vertex(second, k, row), b = vertex(second, k, row + 1),
                                    c = vertex(second, k + 1, row), d = vertex(second, k + 1, row + 1);
                s.triangles.push_back(second ? Triangle{a, c, b} : Triangle{a, b, c});
                s.triangles.push_back(second ? Triangle{b, c, d} : Triangle{b, d, c});
            }
    return s;
}

// Returns the moments of the lune of azimuths [0, wedge] about z, integrated over 512 x 512 midpoints.
std::vector<double> luneMoments(double wedge) {
    constexpr int kSteps = 512;
    std::vector<double> y(kSize), b(kSize);
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double z = 2 * (i + 0.5) / kSteps - 1, a = wedge * (j + 0.5) / kSteps, r = std::sqrt(1 - z * z);
            evalBasis(kOrder, Vec3d{r * std::cos(a), r * std::sin(a), z}, y);
            for (std::size_t k = 0; k < kSize; ++k) b[k] += y[k] * 2 * wedge / (double(kSteps) * kSteps);
        }
    return b;
}

// Two wide half planes meet in a fold. A point between them sees the lune between their directions, however far it is
// from the fold, because a ray below the other half plane meets that plane. A point outside sees its whole hemisphere.
// At 1e-3 from a fold of 170 degrees the other half is nearer than the bias. With 4096 rays we measured errors inside
// of 0.65% (120 degrees), 0.38% (150) and 0.17% (170) of the open hemisphere, and at most 0.12% outside. The bounds are
// 1% and 0.5%.
TEST(Sheets, SharpFoldsSeeAWedgeInsideAndEverythingOutside) {
    for (const double fold : {120.0, 150.0, 170.0}) {
        const double wedge = (180 - fold) * std::numbers::pi / 180;
        const Shape sheet = foldedSheet(wedge);
        const std::vector<float> b = momentsOf(sheet, {}, 4096);
        const std::size_t fronts = sheet.positions.size();
        Largest inside, outside;
        for (std::size_t k = 0; k < 3; ++k) {  // the halves are wide as seen from there
            const Vec3d out = k == 0 ? Vec3d{-std::cos(wedge / 2), -std::sin(wedge / 2), 0} : Vec3d{0, -1, 0};
            inside.add(errorOf(at(b, 3 * k + 1), luneMoments(wedge)));
            outside.add(errorOf(at(b, fronts + 3 * k + 1), capMoments(out, 0)));
        }
        std::printf("fold of %.0f degrees: %.3f%% inside, %.3f%% outside\n", fold, 100 * inside, 100 * outside);
        EXPECT_LT(inside, 0.01) << fold;
        EXPECT_LT(outside, 5e-3) << fold;
    }
}

// From the fold to the rim along its middle, so that both halves end in sight. Measured 0.73% to 0.78%; the bound is
// 2%.
TEST(Sheets, SharpFoldsMatchBruteForce) {
    for (const double fold : {120.0, 150.0, 170.0}) {
        const double error = errorAgainstBruteForce(foldedSheet((180 - fold) * std::numbers::pi / 180), {}, 3, 1);
        std::printf("fold of %.0f degrees against brute force: %.3f%%\n", fold, 100 * error);
        EXPECT_LT(error, 0.02) << fold;
    }
}

// At the two rims across the fold the other half ends as well. 1e-3 from a fold of 170 degrees it is nearer than the
// bias and the search ray passes it, so that rays start beyond it: inside, the first coefficient is 0.97 of the open
// hemisphere's instead of 0.53. This leak is known: it stays at these four vertices and is 0.446 at most. All others
// are within 1.9%; the bounds are 0.46 and 2%.
TEST(Sheets, SharpFoldsLeakAtTheirEndsOnly) {
    for (const double fold : {120.0, 150.0, 170.0}) {
        const Shape shape = foldedSheet((180 - fold) * std::numbers::pi / 180);
        const Sheet sheet = sheetOf(shape);
        const std::vector<float> b = momentsOf(shape, {});
        const double lift = 1e-6 * boxDiagonal(shape.positions), open = std::sqrt(std::numbers::pi);
        std::mt19937 random(7);
        const std::size_t fronts = shape.positions.size();
        for (std::size_t s = 0; s < 2 * fronts; ++s) {
            if (s % 3 == 1) continue;  // the middle
            const std::vector<double> expected =
                bruteForce(shape, toDouble(sheet.positions[s]) + toDouble(sheet.normals[s]) * lift,
                           toDouble(sheet.normals[s]), random);
            const std::size_t column = s % fronts / 3, from_fold = column < 5 ? column : column - 4;
            if (fold == 170 && from_fold == 1 && s < fronts)
                EXPECT_LT(double(b[s * kSize]) - expected[0], 0.46 * open) << "front " << s;
            else
                EXPECT_LT(errorOf(at(b, s), expected), 0.02) << fold << " degrees, vertex " << s;
        }
    }
}

std::vector<double> readArray(const ZipArchive& zip, const std::string& name, std::size_t first, std::size_t count) {
    return readNumbers(openNumpy(openMember(zip, name + ".npy").value(), name), first, count);
}

Shape shapeOf(const std::vector<double>& positions, const std::vector<double>& faces) {
    Shape s;
    for (std::size_t i = 0; i < positions.size(); i += 3)
        s.positions.push_back(toFloat({positions[i], positions[i + 1], positions[i + 2]}));
    for (std::size_t i = 0; i < faces.size(); i += 3)
        s.triangles.push_back({std::uint32_t(faces[i]), std::uint32_t(faces[i + 1]), std::uint32_t(faces[i + 2])});
    return s;
}

// A simulated cloth on its ball.
TEST(Sheets, DrapedClothMatchesBruteForce) {
    const char* data = std::getenv("PENUMBRA_DATA");
    const std::filesystem::path path = std::filesystem::path(data ? data : "") / "cloth" / "drape_A.npz";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << "no $PENUMBRA_DATA/cloth/drape_A.npz";
    const ZipArchive zip = openZip(path);
    const std::size_t vertices = 3721, frame = 100;
    const Shape cloth =
        shapeOf(readArray(zip, "verts", frame * vertices * 3, vertices * 3), readArray(zip, "faces", 0, 7200 * 3));
    const Shape ball = shapeOf(readArray(zip, "ball_verts", 0, 1106 * 3), readArray(zip, "ball_faces", 0, 2208 * 3));
    const double error = errorAgainstBruteForce(cloth, ball, 373);
    RecordProperty("relative_error", std::to_string(error));
    std::printf("draped cloth on its ball against brute force: %.3f%%\n", 100 * error);
    EXPECT_LT(error, 0.02);
}

}  // namespace
}  // namespace penumbra::test_sheet_folds
