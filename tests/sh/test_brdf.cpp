#include <algorithm>
#include <map>
#include <numbers>
#include <stdexcept>

#include "sh/brdf/brdf.h"
#include "sh/brdf/fresnel.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/quadrature.h"
#include "tests/sh/eval_slice.h"
#include "tests/sh/golden.h"

namespace penumbra::test_brdf {
namespace {

std::string messageOf(const std::string& text) {
    try {
        parseBrdf(text);
    } catch (const std::invalid_argument& error) {
        return error.what();
    }
    return "";
}

TEST(Brdf, TextRoundTrips) {
    for (const char* text :
         {"lambert", "lambert:color=0.5/0.25/1", "phong", "phong:exponent=50", "ward:ay=0.1", "oren-nayar:sigma=0.3",
          "blinn-phong", "cook-torrance:m=0.1,ior=2", "ward-gmd:ax=0.3,ay=0.3", "ashikhmin-shirley:rd=0",
          "ggx:alpha=0.1,f0=0.04,color=0.5", "mirror:f0=0.5"}) {
        const BrdfSpec spec = parseBrdf(text);
        EXPECT_EQ(parseBrdf(toString(spec)), spec) << text;
    }
    EXPECT_EQ(toString(parseBrdf("ggx")), "ggx:alpha=0.3,f0=0.9");
    EXPECT_EQ(toString(parseBrdf("lambert:color=0.5")), "lambert:color=0.5/0.5/0.5");
}

TEST(Brdf, BadTextNamesWhatIsWrong) {
    EXPECT_EQ(messageOf("ggx:alpha=3"), "ggx alpha must be a number from 0.01 to 1, not '3'");
    for (const char* text :
         {"", "gloss", "ggx:", "ggx:alpha", "ggx:alpha=", "ggx:=1", "ggx:alpha=0.3,", "ggx:alpha=nan", "ggx:alpha=0.3x",
          "ggx:alpha=0.3,alpha=0.3", "ggx:ax=0.1", "lambert:color=1/2", "lambert:color=1/2/3/4", "lambert:color=-1/0/0",
          "lambert:color=1//2"})
        EXPECT_NE(messageOf(text), "") << text;
}

// Lobes about the mirror direction leave out the cosine, so they are reciprocal only with it.
TEST(Brdf, EveryModelIsReciprocalAndDarkBelowTheHorizon) {
    for (const std::string& name : brdfNames()) {
        const BrdfFunction model = brdfFunction(parseBrdf(name));
        const bool is_lobe = isMirrorLobe(modelOf(parseBrdf(name)));
        const auto f = [&](Vec3d i, Vec3d o) { return model(i, o) * (is_lobe ? i.z : 1); };
        const std::vector<Vec3d> directions = fibonacciSphere(40);
        for (Vec3d a : directions)
            for (Vec3d b : directions) {
                const double ab = f(a, b), ba = f(b, a);
                EXPECT_NEAR(ab, ba, 1e-12 * std::max(1.0, ab)) << name;
                EXPECT_GE(ab, 0) << name;
                EXPECT_TRUE((a.z > 0 && b.z > 0) || ab == 0) << name;
            }
    }
}

// Checks the symmetry that a model claims on its own values.
TEST(Brdf, RgbBrdfIsTheModelTimesItsColour) {
    for (const std::string& name : brdfNames()) {
        const BrdfSpec spec = parseBrdf(name + ":color=0.5/1/2");
        const RgbBrdf brdf = rgbBrdf(spec);
        EXPECT_EQ(brdf.name, toString(spec));
        for (Vec3d a : fibonacciSphere(20))
            for (Vec3d b : fibonacciSphere(20)) {
                const Vec3d f = brdf.eval(a, b);
                EXPECT_EQ(f, (Vec3d{0.5, 1, 2} * brdfFunction(spec)(a, b))) << name;
                for (const Vec3d flip : {Vec3d{-1, 1, 1}, Vec3d{1, -1, 1}})
                    EXPECT_NEAR(brdf.eval(flip * a, flip * b).y, f.y, 1e-12 * std::max(1.0, f.y)) << name;
            }
    }
    EXPECT_EQ(rgbBrdf(parseBrdf("ward")).symmetry, BrdfSymmetry::kOrthotropic);
    EXPECT_EQ(rgbBrdf(parseBrdf("ward:ax=0.3,ay=0.3")).symmetry, BrdfSymmetry::kIsotropic);
}

double albedo(const BrdfSpec& spec, Vec3d view) {
    double sum = 0;
    for (const auto& [direction, weight] : gaussHemisphere(64, 128))
        sum += weight * direction.z * brdfFunction(spec)(direction, view);
    return sum;
}

// Closed forms at normal view: Lambert and Phong of any exponent reflect all light, and the others tend to 1 for a
// narrow lobe.
TEST(Brdf, AlbedosAtNormalViewMatchClosedForms) {
    const Vec3d normal{0, 0, 1};
    EXPECT_NEAR(albedo(parseBrdf("lambert"), normal), 1, 1e-12);
    for (const char* text : {"phong:exponent=0", "phong:exponent=1", "phong:exponent=10", "phong:exponent=50"})
        EXPECT_NEAR(albedo(parseBrdf(text), normal), 1, 1e-12) << text;
    EXPECT_NEAR(albedo(parseBrdf("ggx:alpha=0.1,f0=1"), normal), 1, 0.02);  // 0.988: masked light is lost
    EXPECT_NEAR(albedo(parseBrdf("ward-gmd:ax=0.1,ay=0.1"), normal), 1, 0.03);
    EXPECT_NEAR(albedo(parseBrdf("ward:ax=0.1,ay=0.1"), normal), 1, 0.03);
}

// Blinn-Phong's normalisation is exact. The quadrature resolves an exponent of 1000 to 1e-10.
TEST(Brdf, BlinnPhongReflectsAllAtNormalView) {
    for (const char* text :
         {"blinn-phong:exponent=0", "blinn-phong:exponent=1", "blinn-phong:exponent=50", "blinn-phong:exponent=1000"})
        EXPECT_NEAR(albedo(parseBrdf(text), {0, 0, 1}), 1, 1e-9) << text;
}

// The closed form is A + 2B/pi (sin t (t - sin t cos t) / 2 + tan t (1 - sin^3 t) / 3) at view angle t. The quadrature
// sees the kinks at opposite azimuths and at equal heights: measured 2e-4.
TEST(Brdf, OrenNayarAlbedoMatchesItsClosedForm) {
    for (const double sigma : {0.0, 0.3, 1.0})
        for (const double t : {0.0, 0.4, 1.0, 1.4}) {
            const double s2 = sigma * sigma, a = 1 - 0.5 * s2 / (s2 + 0.33), b = 0.45 * s2 / (s2 + 0.09);
            const double sine = std::sin(t), inner = sine * (t - sine * std::cos(t)) / 2;
            const double exact = a + 2 * b / std::numbers::pi * (inner + std::tan(t) * (1 - sine * sine * sine) / 3);
            BrdfSpec spec = parseBrdf("oren-nayar");
            spec.parameters["sigma"] = sigma;
            EXPECT_NEAR(albedo(spec, {sine, 0, std::cos(t)}), exact, 6e-4) << sigma << " " << t;
        }
}

// A narrow Beckmann lobe reflects what Fresnel's formula says: at normal incidence, at 60 degrees, and of nearly a
// mirror.
TEST(Brdf, NarrowCookTorranceReflectsAsFresnelSays) {
    const BrdfSpec glass = parseBrdf("cook-torrance:m=0.05,ior=1.5"), metal = parseBrdf("cook-torrance:m=0.05,ior=100");
    EXPECT_NEAR(albedo(glass, {0, 0, 1}), 0.04, 0.0004);
    EXPECT_NEAR(albedo(glass, {std::sqrt(0.75), 0, 0.5}), dielectricFresnel(0.5, 1.5), 0.002);  // 0.0892
    EXPECT_NEAR(albedo(metal, {0, 0, 1}), std::pow(99.0 / 101, 2), 0.01);
}

// Closed forms exist at normal incidence, at Brewster's angle (where only the perpendicular half is reflected), at
// grazing incidence and without a boundary.
TEST(Fresnel, DielectricMatchesClosedForms) {
    const double n = 1.5, brewster = std::cos(std::atan(n));
    EXPECT_NEAR(dielectricFresnel(1, n), 0.04, 1e-15);
    EXPECT_NEAR(dielectricFresnel(brewster, n), std::pow((n * n - 1) / (n * n + 1), 2) / 2, 1e-15);
    EXPECT_NEAR(dielectricFresnel(1e-9, n), 1, 1e-8);
    EXPECT_NEAR(dielectricFresnel(0.3, 1), 0, 1e-15);
}

TEST(Brdf, IsotropyIsThatOfTheFunction) {
    const Vec3d a = normalized(Vec3d{0.3, -0.4, 0.6}), b = normalized(Vec3d{-0.5, 0.1, 0.7});
    const auto turned = [](Vec3d v) { return Vec3d{0.8 * v.x - 0.6 * v.y, 0.6 * v.x + 0.8 * v.y, v.z}; };
    for (const char* text : {"lambert", "phong", "ggx", "ward", "ward:ax=0.3,ay=0.3", "ward-gmd", "ward-gmd:ax=0.5",
                             "ashikhmin-shirley", "ashikhmin-shirley:nu=50"}) {
        const BrdfSpec spec = parseBrdf(text);
        const double before = brdfFunction(spec)(a, b), after = brdfFunction(spec)(turned(a), turned(b));
        EXPECT_EQ(isIsotropic(spec), std::abs(before - after) < 1e-12 * before) << text;
    }
}

// Two directions at the same angle from the normal, one along x and one along y, differ in the lobe alone. Their half
// vectors with the normal lie at the angle d.
TEST(Brdf, AnisotropicLobesHaveTheirWidthsAlongXAndY) {
    const double d = 0.2, tangent = std::tan(d);
    const Vec3d o{0, 0, 1}, along_x{std::sin(2 * d), 0, std::cos(2 * d)}, along_y{0, along_x.x, along_x.z};
    const auto logRatio = [&](const char* text) {
        const BrdfFunction f = brdfFunction(parseBrdf(text));
        return std::log(f(along_x, o) / f(along_y, o));
    };
    for (const char* ward : {"ward:ax=0.2,ay=0.5", "ward-gmd:ax=0.2,ay=0.5"})
        EXPECT_NEAR(logRatio(ward), -tangent * tangent * (1 / 0.04 - 1 / 0.25), 1e-12) << ward;
    EXPECT_NEAR(logRatio("ashikhmin-shirley:nu=10,nv=50,rd=0"), (10 - 50) * std::log(std::cos(d)), 1e-12);
}

// slice36 has order-6 coefficients of f cos for three views, by quadrature that is good to 3e-3.
TEST(Brdf, SlicesMatchGolden) {
    const auto golden = readGolden("rpo.json");
    const std::map<std::string, std::string> specs = {{"lambert", "lambert"},
                                                      {"phong10", "phong:exponent=10"},
                                                      {"ggx_.3", "ggx:alpha=0.3,f0=0.9"},
                                                      {"ward_gmd_.2_.5", "ward-gmd:ax=0.2,ay=0.5"}};
    for (const auto& test : golden.at("cases")) {
        const BrdfFunction f = brdfFunction(parseBrdf(specs.at(test.at("brdf"))));
        for (std::size_t v = 0; v < 3; ++v) {
            const Vec3d view = vec3(golden.at("views")[v]);
            std::vector<double> slice(36), y(36);
            for (const auto& [direction, weight] : gaussHemisphere(160, 320)) {
                evalBasis(6, direction, y);
                for (std::size_t i = 0; i < 36; ++i) slice[i] += weight * direction.z * f(direction, view) * y[i];
            }
            expectNear(slice, doubles(test.at("slice36")[v]), 3e-3);
        }
    }
}

TEST(Reflectance, EvenIndicesAreThoseEvenInZ) {
    for (int order = 1; order <= kMaxOrder; ++order) {
        const std::vector<int> even = evenIndices(order);
        EXPECT_EQ(int(even.size()), order * (order + 1) / 2);
        const Vec3d up = normalized(Vec3d{0.2, 0.5, 0.4}), down{up.x, up.y, -up.z};
        std::vector<double> a(coefficientCount(order)), b(a.size());
        evalBasis(order, up, a);
        evalBasis(order, down, b);
        for (int i = 0; i < coefficientCount(order); ++i)
            EXPECT_NEAR(b[i], std::count(even.begin(), even.end(), i) ? a[i] : -a[i], 1e-14) << i;
    }
}

TEST(Reflectance, SliceIsTheMatrixProduct) {
    std::vector<float> slices(25 * 15), f(25), even(15);
    for (std::size_t i = 0; i < slices.size(); ++i) slices[i] = std::sin(float(i));
    const Vec3 view = normalized(Vec3{0.1f, -0.7f, 0.5f});
    evalSlice(slices, 5, 5, view, f);
    std::vector<double> y(25);
    evalBasis(5, toDouble(view), y);
    for (int i = 0; i < 25; ++i) {
        double sum = 0;
        for (int e = 0; e < 15; ++e) sum += double(slices[i * 15 + e]) * y[evenIndices(5)[e]];
        EXPECT_NEAR(f[i], sum, 1e-5);
    }
}

}  // namespace
}  // namespace penumbra::test_brdf
