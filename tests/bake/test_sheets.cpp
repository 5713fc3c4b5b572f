// Tests thin sheets: either side has moments of its own, and no light leaks through what lies on them.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <random>

#include "bake/moments.h"
#include "formats/cache/numpy_array.h"
#include "formats/cache/zip_archive.h"
#include "tests/bake/shapes.h"

namespace penumbra {
namespace {

using shapes::relativeError;
using shapes::Shape;

constexpr int kOrder = 5;
constexpr std::size_t kSize = 25;

struct Sheet {
    Mesh mesh;  // two-sided
    std::vector<Vec3> positions, normals;
};

Sheet sheetOf(const Shape& shape) {
    Mesh mesh;
    mesh.triangles = shape.triangles;
    mesh.rest_positions = shape.positions;
    Sheet sheet{withBacks(mesh), shape.positions, vertexNormals(shape.triangles, shape.positions)};
    appendBackPositions(sheet.positions);
    appendBackNormals(sheet.normals);
    return sheet;
}

// Returns the moments of fronts, then those of backs.
std::vector<float> momentsOf(const Shape& shape, const Shape& occluder, int rays = 1024, bool ground = false) {
    const Sheet sheet = sheetOf(shape);
    Blockers blockers;
    blockers.add(shape.triangles, shape.positions);
    blockers.add(occluder.triangles, occluder.positions);
    const SceneScale scale = sceneScale(shape.positions, boxDiagonal(shape.positions));
    std::vector<Vec3> scaled(shape.positions);
    scaled.insert(scaled.end(), occluder.positions.begin(), occluder.positions.end());
    for (Vec3& p : scaled) p = scale.apply(p);
    const OcclusionScene scene(scaled, blockers.triangles, true);
    const RayDirections directions = makeRayDirections(rays, 1, kOrder);
    MomentTracer tracer{scene, directions, scale, 1e-4f, ground};
    tracer.blockers = &blockers;
    tracer.mesh = &sheet.mesh;
    tracer.vertices = sheet.positions;
    std::vector<float> b(sheet.positions.size() * kSize);
    traceMoments(tracer, sheet.positions, sheet.normals, b);
    return b;
}

std::span<const float> at(const std::vector<float>& b, std::size_t v) { return std::span(b).subspan(v * kSize, kSize); }

// Returns the moments of a hemisphere from which a cap of half-angle `blocked` around the normal is blocked (0: it is
// open). They are zonal about the normal, with b_l = 2 pi sqrt((2l+1)/4pi) times the integral of P_l from 0 to
// cos(blocked), which is (P_(l+1) - P_(l-1)) / (2l+1) between the two ends.
std::vector<double> capMoments(Vec3d normal, double blocked) {
    const double top = std::cos(blocked);
    const auto integral = [&](unsigned l) {
        if (l == 0) return top;
        const auto at = [&](double x) { return (std::legendre(l + 1, x) - std::legendre(l - 1, x)) / (2 * l + 1); };
        return at(top) - at(0);
    };
    std::vector<double> y(kSize), b(kSize);
    evalBasis(kOrder, normal, y);
    for (unsigned l = 0; l < unsigned(kOrder); ++l)
        for (unsigned i = l * l; i < (l + 1) * (l + 1); ++i) b[i] = 2 * std::numbers::pi * integral(l) * y[i];
    return b;
}

double size(std::span<const float> b) {
    double sum = 0;
    for (const float x : b) sum += double(x) * x;
    return std::sqrt(sum);
}

// Returns the distance of `b` from the closed form in units of the open hemisphere's norm.
double errorOf(std::span<const float> b, const std::vector<double>& expected) {
    double sum = 0;
    for (std::size_t i = 0; i < b.size(); ++i) sum += std::pow(double(b[i]) - expected[i], 2);
    double open = 0;
    for (const double x : capMoments({0, 1, 0}, 0)) open += x * x;
    return std::sqrt(sum / open);
}

// Makes a grid of side x side vertices of size 2 about the y axis at height `height`, with fronts up.
Shape grid(int side, double height) {
    Shape s;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j)
            s.positions.push_back(toFloat({2.0 * i / (side - 1) - 1, height, 2.0 * j / (side - 1) - 1}));
    const auto corner = [&](int i, int j) { return std::uint32_t(i * side + j); };
    for (int i = 0; i + 1 < side; ++i)
        for (int j = 0; j + 1 < side; ++j) {
            s.triangles.push_back({corner(i, j), corner(i, j + 1), corner(i + 1, j)});
            s.triangles.push_back({corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)});
        }
    return s;
}

// Makes a fan around the y axis, with fronts up.
Shape disc(double radius, double height) {
    constexpr std::uint32_t kSides = 512;
    Shape s;
    s.positions.push_back(toFloat({0, height, 0}));
    for (std::uint32_t k = 0; k < kSides; ++k) {
        const double a = 2 * std::numbers::pi * k / kSides;
        s.positions.push_back(toFloat({radius * std::cos(a), height, radius * std::sin(a)}));
        s.triangles.push_back({0, 1 + (k + 1) % kSides, 1 + k});
    }
    return s;
}

// Makes a closed box, with fronts outside.
Shape box(Vec3d low, Vec3d high) {
    Shape s;
    for (int i = 0; i < 8; ++i)
        s.positions.push_back(toFloat({i & 1 ? high.x : low.x, i & 2 ? high.y : low.y, i & 4 ? high.z : low.z}));
    s.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                   {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
    return s;
}

// --- A sheet on a body ----------------------------------------------------------------------------------------------

// 1024 directions integrate an open hemisphere to 0.29% here. Edges of the sheet are 0.25 long and the bias is
// 2.8e-4: heights are far above both, far below both, and contact. The front sees the open sky. Of the back's rays
// only those within h / 2000 of the horizon pass the body's edge, which no ray of the set does.
TEST(Sheets, SheetOverAPlaneIsOpenAboveAndBlackBelow) {
    for (const double h : {0.5, 0.02, 1e-3, 2.8e-4, 1e-4, 1e-5, 4e-6, 1e-7, 0.0}) {
        const Shape sheet = grid(9, h);
        const std::vector<float> b = momentsOf(sheet, shapes::square({0, 0, 0}, {0, 1, 0}, 2000));
        const std::size_t fronts = sheet.positions.size();
        for (std::size_t v = 0; v < fronts; ++v) {
            EXPECT_LT(errorOf(at(b, v), capMoments({0, 1, 0}, 0)), 5e-3) << "front " << v << " at " << h;
            EXPECT_EQ(size(at(b, fronts + v)), 0) << "back " << v << " at " << h;
        }
    }
}

// The body below sees a disc of radius 1 at distance h, a cap of half-angle atan(1 / h). The body is the mesh of the
// bake, and the sheet is its occluder. Measured 0.2% to 0.9% of the open hemisphere with 1024 rays; the bound is
// 1.5%.
TEST(Sheets, PlaneUnderASheetSeesTheDisc) {
    const Shape body = grid(3, 0);  // vertex 4 is in the middle
    for (const double h : {3.0, 1.0, 0.5, 0.1, 0.01, 1e-3, 1e-4, 1e-5}) {
        const std::vector<float> b = momentsOf(body, disc(1, h));
        EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, std::atan(1 / h))), 0.015) << h;
        EXPECT_LT(errorOf(at(b, 9 + 4), capMoments({0, -1, 0}, 0)), 5e-3) << h;
    }
}

// Two sheets of one mesh lie on each other. Between them it is dark, and outside it is open.
TEST(Sheets, LayersShadeEachOther) {
    for (const double h : {0.01, 1e-4, 1e-5}) {
        Shape both = grid(9, 0);
        shapes::append(both, grid(9, h));
        const std::vector<float> b = momentsOf(both, {});
        const std::size_t fronts = both.positions.size(), lower = 4 * 9 + 4, upper = 81 + lower;
        EXPECT_LT(errorOf(at(b, upper), capMoments({0, 1, 0}, 0)), 5e-3) << h;
        EXPECT_LT(errorOf(at(b, fronts + lower), capMoments({0, -1, 0}, 0)), 5e-3) << h;
        // The gap of height h is open at its rim, 1 away. A ray (0.0087 each) may slip between two triangles along
        // their edge: at h = 1e-5 up to two of 1024 do.
        EXPECT_LT(size(at(b, lower)), 3 * h + 0.02) << h;
        EXPECT_LT(size(at(b, fronts + upper)), 3 * h + 0.02) << h;
    }
}

// --- Sunk in --------------------------------------------------------------------------------------------------------

// The sheet lies below the surface of a closed body by up to kSunkIn (0.01 of the sheet's diagonal of 2.83). Its
// front is lit as if it lay on the body, and its back is black. Deeper it is inside, and both are black.
TEST(Sheets, SheetSunkIntoABodyIsLitAsOnIt) {
    const Shape body = box({-50, -100, -50}, {50, 0, 50});
    for (const double depth : {1e-7, 1e-5, 1e-3, 0.02, 0.04}) {
        const Shape sheet = grid(5, -depth);
        const std::vector<float> b = momentsOf(sheet, body);
        const std::size_t fronts = sheet.positions.size();
        for (std::size_t v = 0; v < fronts; ++v) {
            if (depth < 0.028)
                EXPECT_LT(errorOf(at(b, v), capMoments({0, 1, 0}, 0)), 5e-3) << depth;
            else
                EXPECT_EQ(size(at(b, v)), 0) << depth;
            EXPECT_EQ(size(at(b, fronts + v)), 0) << depth;
        }
    }
    // A body whose triangles face inwards is the same body.
    Shape inside_out = body;
    for (Triangle& t : inside_out.triangles) std::swap(t[1], t[2]);
    EXPECT_EQ(momentsOf(grid(5, -1e-3), inside_out), momentsOf(grid(5, -1e-3), body));
}

// From a plate thinner than kSunkIn the sheet comes out at the side that is nearer, not at both.
TEST(Sheets, SheetSunkIntoAThinPlateComesOutOnce) {
    for (const bool near_top : {true, false}) {
        const double y = near_top ? -1e-3 : -9e-3;
        const std::vector<float> b = momentsOf(grid(5, y), box({-50, -0.01, -50}, {50, 0, 50}));
        for (std::size_t v = 0; v < 25; ++v) {
            EXPECT_EQ(size(at(b, v)) > 1, near_top) << v;
            EXPECT_EQ(size(at(b, 25 + v)) > 1, !near_top) << v;
        }
    }
}

// An open surface has no inside, so that what is behind it stays dark, however near it is.
TEST(Sheets, OpenSurfaceIsNotLeft) {
    const std::vector<float> b = momentsOf(grid(5, -1e-3), shapes::square({0, 0, 0}, {0, 1, 0}, 2000));
    for (std::size_t v = 0; v < 25; ++v) EXPECT_EQ(size(at(b, v)), 0) << v;
}

// --- Occluders and ground -------------------------------------------------------------------------------------------

// A ball of radius r at height d over the middle hides a cap of half-angle asin(r / d). Facets lose 1 - cos(pi / 256)
// of the radius. Measured 0.3% to 0.8% of the open hemisphere; the bound is 1.5%.
TEST(Sheets, BallOverASheetIsACap) {
    for (const auto& [r, d] : {std::pair(0.5, 1.0), {0.2, 2.0}, {0.9, 1.0}, {0.999, 1.0}}) {
        const std::vector<float> b = momentsOf(grid(3, 0), shapes::sphere({0, d, 0}, r, 128));
        EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, std::asin(r / d))), 0.015) << r;
        EXPECT_LT(errorOf(at(b, 9 + 4), capMoments({0, -1, 0}, 0)), 5e-3) << r;
    }
}

// The floor blocks what points down, wherever the sheet is. One that has sunk below it is shaded as if it lay on it.
TEST(Sheets, GroundBlocksWhatPointsDown) {
    const std::vector<float> b = momentsOf(grid(3, 0), {}, 1024, true);
    EXPECT_LT(errorOf(at(b, 4), capMoments({0, 1, 0}, 0)), 5e-3);
    EXPECT_EQ(size(at(b, 9 + 4)), 0);
    Shape wall = grid(3, 0);
    for (Vec3& p : wall.positions) p = {p.y, p.x, p.z};  // the front faces -x, because the turn changes hands
    const std::vector<float> upright = momentsOf(wall, {}, 4096, true);
    for (const std::size_t v : {std::size_t(4), std::size_t(13)})  // half of the hemisphere is left
        EXPECT_NEAR(upright[v * kSize], std::sqrt(std::numbers::pi) / 2, 2e-3);
}

// --- Creases --------------------------------------------------------------------------------------------------------

// The valley of 60 degrees runs along z. The left slope has most of the area at the crease, so that the normal there
// is nearly the left slope's and points behind the right slope. The back sees the 60 degrees between the slopes, and
// the front sees its whole hemisphere. Neither sees what is behind the sheet.
TEST(Sheets, NormalBehindATriangleDoesNotLeak) {
    const double r = 1000, c = std::cos(std::numbers::pi / 3), s = std::sin(std::numbers::pi / 3);
    Shape valley;
    valley.positions = {
        {0, 0, 0}, toFloat({0, 0, -r}), toFloat({0, 0, r}), toFloat({-40 * r, 0, 0}), toFloat({-r * c, r * s, 0})};
    valley.triangles = {{0, 2, 3}, {0, 3, 1}, {0, 4, 2}, {0, 1, 4}};  // fronts outside
    EXPECT_LT(vertexNormals(valley.triangles, valley.positions)[0].y, -0.99);
    const std::vector<float> b = momentsOf(valley, {}, 4096);
    const double y0 = std::sqrt(0.25 / std::numbers::pi);
    const double inside = b[5 * kSize] / y0, outside = b[0] / y0;
    EXPECT_NEAR(inside, 2 * std::numbers::pi / 3, 0.05);  // a lune of angle a has 2 a steradians
    EXPECT_NEAR(outside, 2 * std::numbers::pi, 0.05);
}

// --- Brute force ----------------------------------------------------------------------------------------------------

// Computes moments by 64 x 64 jittered directions of the hemisphere in double, without an acceleration structure.
std::vector<double> bruteForce(const Shape& scene, Vec3d start, Vec3d normal, std::mt19937& random) {
    constexpr int kSteps = 64;
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vec3d side = normalized(cross(normal, std::abs(normal.x) < 0.5 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Vec3d other = cross(normal, side);
    std::vector<double> y(kSize), b(kSize);
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double z = (i + uniform(random)) / kSteps, a = 2 * std::numbers::pi * (j + uniform(random)) / kSteps;
            const double r = std::sqrt(1 - z * z);
            const Vec3d d = side * (r * std::cos(a)) + other * (r * std::sin(a)) + normal * z;
            if (shapes::blocked(start, d, scene.positions, scene.triangles)) continue;
            evalBasis(kOrder, d, y);
            for (std::size_t k = 0; k < kSize; ++k) b[k] += y[k] * 2 * std::numbers::pi / (kSteps * kSteps);
        }
    return b;
}

// Returns the relative error of both sides of every `step`-th vertex from `first` on.
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

// A handkerchief is crumpled by two waves, with slopes of up to 37 and 66 degrees.
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

// A sheet of 2 x 2 that is folded along z with `wedge` radians between its halves, fronts inside. Vertex 3 k + 1 of a
// half lies in its middle, kFromFold[k] from the fold.
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

// Returns the moments of the lune of azimuths [0, wedge] about z, by 512 x 512 midpoints.
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

// Inside two wide half planes a point sees the lune between the directions of the two, at whatever distance from the
// fold: a ray that rises more steeply than the other half meets it. Outside, everything is open. At 1e-3 from a fold
// of 170 degrees the other half is nearer than the bias. Of the open hemisphere 0.65% (120), 0.38% (150) and 0.17%
// (170) were measured inside with 4096 rays, and 0.12% at most outside; the bounds are 1% and 0.5%.
TEST(Sheets, SharpFoldsSeeAWedgeInsideAndEverythingOutside) {
    for (const double fold : {120.0, 150.0, 170.0}) {
        const double wedge = (180 - fold) * std::numbers::pi / 180;
        const Shape sheet = foldedSheet(wedge);
        const std::vector<float> b = momentsOf(sheet, {}, 4096);
        const std::size_t fronts = sheet.positions.size();
        double inside = 0, outside = 0;
        for (std::size_t k = 0; k < 3; ++k) {  // the halves are wide as seen from there
            const Vec3d out = k == 0 ? Vec3d{-std::cos(wedge / 2), -std::sin(wedge / 2), 0} : Vec3d{0, -1, 0};
            inside = std::max(inside, errorOf(at(b, 3 * k + 1), luneMoments(wedge)));
            outside = std::max(outside, errorOf(at(b, fronts + 3 * k + 1), capMoments(out, 0)));
        }
        std::printf("fold of %.0f degrees: %.3f%% inside, %.3f%% outside\n", fold, 100 * inside, 100 * outside);
        EXPECT_LT(inside, 0.01) << fold;
        EXPECT_LT(outside, 5e-3) << fold;
    }
}

// Goes from the fold to the rim along the middle, so that both halves end in sight. Measured 0.73% to 0.78%; the
// bound is 2%. The two rims across the fold are left out. There the other half is nearer than the bias and ends as
// well, so that the search ray passes it and rays start beyond it (0.97 of the hemisphere instead of 0.53, 1e-3 from
// a fold of 170 degrees).
TEST(Sheets, SharpFoldsMatchBruteForce) {
    for (const double fold : {120.0, 150.0, 170.0}) {
        const double error = errorAgainstBruteForce(foldedSheet((180 - fold) * std::numbers::pi / 180), {}, 3, 1);
        std::printf("fold of %.0f degrees against brute force: %.3f%%\n", fold, 100 * error);
        EXPECT_LT(error, 0.02) << fold;
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

// A simulated cloth lies on its ball.
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
}  // namespace penumbra
