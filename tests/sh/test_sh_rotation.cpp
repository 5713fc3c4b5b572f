#include <random>

#include "sh/sh_rotation.h"
#include "tests/difference.h"
#include "tests/sh/golden.h"

namespace penumbra::test_sh_rotation {

namespace {

Mat3d axisRotation(Vec3d axis, double angle) {
    const Vec3d a = normalized(axis);
    const double c = std::cos(angle), s = std::sin(angle), t = 1 - c;
    return {{c + t * a.x * a.x, t * a.x * a.y - s * a.z, t * a.x * a.z + s * a.y, t * a.x * a.y + s * a.z,
             c + t * a.y * a.y, t * a.y * a.z - s * a.x, t * a.x * a.z - s * a.y, t * a.y * a.z + s * a.x,
             c + t * a.z * a.z}};
}

Mat3 toSingle(const Mat3d& a) {
    Mat3 b;
    for (int i = 0; i < 9; ++i) b.m[i] = float(a.m[i]);
    return b;
}

std::vector<Mat3d> someRotations() {
    std::vector<Mat3d> rotations = {Mat3d{}, axisRotation({0, 0, 1}, 1), axisRotation({1, 0, 0}, 3.14159265358979)};
    for (int i = 0; i < 20; ++i)
        rotations.push_back(axisRotation({std::sin(1.0 + i), std::cos(2.0 * i), std::sin(3.0 + 5 * i)}, 0.37 * i));
    return rotations;
}

}  // namespace

TEST(ShRotation, MatchesGolden) {
    const auto golden = readGolden("sh_rotation.json");
    const double tolerance = golden.at("tol");
    for (const auto& test : golden.at("cases")) {
        Mat3d q;
        for (int i = 0; i < 9; ++i) q.m[i] = test.at("Q")[i / 3][i % 3];
        const ShRotationD r = makeShRotation(6, q);
        const double* block = r.blocks.data();
        for (int l = 0; l < 6; ++l)
            for (int m = 0; m < 2 * l + 1; ++m)
                for (int n = 0; n < 2 * l + 1; ++n)
                    EXPECT_NEAR(*block++, test.at("R_blocks")[l][m][n].get<double>(), tolerance)
                        << test.at("name") << " band " << l;
        const std::vector<double> f = doubles(test.at("f"));
        std::vector<double> rotated(36), back(36);
        apply(r, f, rotated);
        expectNear(rotated, doubles(test.at("Rf")), tolerance);
        applyTransposed(r, rotated, back);
        expectNear(back, f, tolerance);
    }
}

// y(Q s) = R y(s). The error measures 2.4e-14 in double and 3.3e-6 in single precision.
TEST(ShRotation, RotatesTheBasisForEveryOrder) {
    const Vec3d s = normalized(Vec3d{0.3, -0.5, 0.7});
    for (const Mat3d& q : someRotations())
        for (int order = 1; order <= kMaxOrder; ++order) {
            std::vector<double> y(coefficientCount(order)), rotated(y.size()), expected(y.size());
            evalBasisReference(order, s, y);
            evalBasisReference(order, q * s, expected);
            apply(makeShRotation(order, q), y, rotated);
            expectNear(rotated, expected, 1e-12);
            std::vector<float> in(y.begin(), y.end()), out(y.size());
            apply(makeShRotation(order, toSingle(q)), in, out);
            expectNear(std::vector<double>(out.begin(), out.end()), expected, 1e-5);
        }
}

TEST(ShRotation, KeepsTheEnergyOfEveryBandAndComposes) {
    std::vector<double> f(64), once(64), twice(64), direct(64);
    for (int i = 0; i < 64; ++i) f[i] = std::cos(1.3 * i * i);
    const auto rotations = someRotations();
    for (std::size_t k = 1; k < rotations.size(); ++k) {
        apply(makeShRotation(8, rotations[k]), f, once);
        for (int l = 0; l < 8; ++l) {
            double before = 0, after = 0;
            for (int m = -l; m <= l; ++m) {
                before += f[shIndex(l, m)] * f[shIndex(l, m)];
                after += once[shIndex(l, m)] * once[shIndex(l, m)];
            }
            EXPECT_NEAR(after, before, 1e-11);
        }
        apply(makeShRotation(8, rotations[k - 1]), once, twice);
        apply(makeShRotation(8, rotations[k - 1] * rotations[k]), f, direct);
        expectNear(twice, direct, 1e-11);
    }
}

namespace {

double distance(const Mat3& a, const Mat3& b) { return distanceBetween(a.m, b.m); }

double determinant(const Mat3& a) {
    return dot(cross(Vec3{a.m[0], a.m[1], a.m[2]}, Vec3{a.m[3], a.m[4], a.m[5]}), Vec3{a.m[6], a.m[7], a.m[8]});
}

}  // namespace

TEST(NearestRotation, UndoesStretchOnTheRight) {
    // In R S with S symmetric and positive definite, the polar factor is R, whatever the scale of the model.
    const Mat3 stretch{{2, 0.3f, 0.1f, 0.3f, 1, -0.2f, 0.1f, -0.2f, 0.5f}};
    for (const Mat3d& q : someRotations())
        for (float scale : {1e-12f, 1.0f, 1e12f}) {
            Mat3 a = toSingle(q) * stretch;
            for (float& value : a.m) value *= scale;
            EXPECT_LT(distance(nearestRotation(a), toSingle(q)), 2e-6);
        }
}

TEST(NearestRotation, IsARotationForAnyMatrix) {
    std::mt19937 random(5);
    const auto next = [&] { return float(random() % 2001) / 1000 - 1; };
    std::vector<Mat3> matrices = {{{0, 0, 0, 0, 0, 0, 0, 0, 0}},
                                  {{1, 0, 0, 0, 0, 0, 0, 0, 0}},
                                  {{-1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                  {{-1, 0, 0, 0, -1, 0, 0, 0, -1}},
                                  {{1, 2, 3, 2, 4, 6, 3, 6, 9}}};
    for (int i = 0; i < 200; ++i)
        matrices.push_back({{next(), next(), next(), next(), next(), next(), next(), next(), next()}});
    for (const Mat3& a : matrices) {
        const Mat3 r = nearestRotation(a);
        EXPECT_LT(distance(transposed(r) * r, Mat3{}), 2e-6);
        EXPECT_NEAR(determinant(r), 1, 2e-6);
        EXPECT_EQ(r, nearestRotation(a));
        // No rotation near it does better: the distance to `a` does not fall when r is turned a little.
        for (Vec3d axis : {Vec3d{1, 0, 0}, {0, 1, 0}, {0, 0, 1}})
            for (double angle : {-0.01, 0.01})
                EXPECT_GE(distance(toSingle(axisRotation(axis, angle)) * r, a), distance(r, a) - 1e-6);
    }
    EXPECT_EQ(nearestRotation(matrices[0]), Mat3{});
}

}  // namespace penumbra::test_sh_rotation
