#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

#include "formats/brdf/brdf_readers.h"
#include "formats/brdf/half_difference_table.h"
#include "formats/common/errors.h"
#include "sh/brdf/fresnel.h"
#include "sh/quadrature.h"
#include "tests/difference.h"
#include "tests/formats/brdf_samples.h"
#include "tests/refusal.h"

namespace penumbra::test_brdf_source {
namespace {

using testing::HasSubstr;

RgbBrdf brdfOf(const char* spec) { return rgbBrdf(parseBrdf(spec)); }

std::vector<Vec3d> upperDirections(int n) {
    std::vector<Vec3d> upper;
    for (Vec3d d : fibonacciSphere(n))
        if (d.z > 0.05) upper.push_back(d);
    return upper;
}

// Returns the largest |f - expected| relative to the largest expected value.
double largestDifference(const RgbBrdf& brdf, const RgbBrdf& expected, const std::vector<Vec3d>& directions) {
    Largest difference, largest;
    for (Vec3d a : directions)
        for (Vec3d b : directions)
            for (int c = 0; c < 3; ++c) {
                const double exact = expected.eval(a, b)[c];
                difference.add(std::abs(brdf.eval(a, b)[c] - exact));
                largest.add(exact);
            }
    return difference / largest;
}

// --- Half-difference angles -----------------------------------------------------------------------------------------

TEST(HalfDifference, AnglesAndDirectionsRoundTrip) {
    for (double h : {0.0, 0.01, 0.4, 1.5})
        for (double d : {0.01, 0.7, 1.5})
            for (double p : {0.0, 0.3, 1.57}) {
                const auto [wi, wo] = directionsOf({h, d, p});
                const HalfDifference back = halfDifference(wi, wo), reciprocal = halfDifference(wo, wi);
                EXPECT_NEAR(back.theta_h, h, 1e-12);
                EXPECT_NEAR(back.theta_d, d, 1e-12);
                EXPECT_NEAR(back.phi_d, h > 0 ? p : back.phi_d, 1e-11);
                EXPECT_NEAR(reciprocal.phi_d, back.phi_d, 1e-11);
                EXPECT_NEAR(dot(wi, wo), std::cos(2 * d), 1e-12);
            }
}

TEST(HalfDifference, DoNotChangeWithRotationAboutTheNormalOrMirroring) {
    const Vec3d a = normalized(Vec3d{0.3, -0.4, 0.6}), b = normalized(Vec3d{-0.5, 0.1, 0.7});
    const auto turned = [](Vec3d v) { return Vec3d{0.8 * v.x - 0.6 * v.y, 0.6 * v.x + 0.8 * v.y, v.z}; };
    const auto mirrored = [](Vec3d v) { return Vec3d{v.x, -v.y, v.z}; };
    const HalfDifference angles = halfDifference(a, b);
    for (const HalfDifference& other :
         {halfDifference(turned(a), turned(b)), halfDifference(mirrored(a), mirrored(b))}) {
        EXPECT_NEAR(other.theta_h, angles.theta_h, 1e-12);
        EXPECT_NEAR(other.theta_d, angles.theta_d, 1e-12);
        EXPECT_NEAR(other.phi_d, angles.phi_d, 1e-12);
    }
}

// --- MERL -----------------------------------------------------------------------------------------------------------

class Merl : public testing::Test {
protected:
    static const std::string& file() {
        static const std::string bytes = samples::merlFile(brdfOf("ggx:alpha=0.3,f0=0.9,color=1/0.5/0.25"));
        return bytes;
    }
};

// 90 x 90 x 180 cells resolve this lobe to 1.1% of its height. (At the horizon, where cells have no neighbour above
// it, the error is 4 times as much; the directions here stay 3 degrees above.)
TEST_F(Merl, ValuesAreThoseThatWereMeasured) {
    const BrdfReading reading = decodeMerl(file(), "x");
    EXPECT_EQ(reading.brdf.symmetry, BrdfSymmetry::kIsotropic);
    EXPECT_EQ(reading.figures.at("unmeasured"), 0);
    EXPECT_LT(largestDifference(reading.brdf, brdfOf("ggx:alpha=0.3,f0=0.9,color=1/0.5/0.25"), upperDirections(60)),
              0.02);
    EXPECT_EQ(reading.brdf.eval({0, 0, 1}, {0, 0.6, -0.8}), Vec3d{});
}

// A constant stays exactly that with a third of its cells gone, as the mirror image of a missing cell stands in for
// it.
TEST_F(Merl, CellsWithoutMeasurementAreFilledFromTheirNeighbours) {
    std::string bytes = samples::merlFile(brdfOf("lambert"));
    for (std::size_t cell = 0; cell < samples::kMerlCells; ++cell)
        if (cell / 180 % 3 == 0) samples::setMerl(bytes, cell % 3, cell, -0.5);
    for (std::size_t cell = 0; cell < samples::kMerlCells; cell += 180)  // only one of the two images
        samples::setMerl(bytes, 1, cell, -1);
    const BrdfReading reading = decodeMerl(bytes, "x");
    EXPECT_GT(reading.figures.at("unmeasured"), 0);
    EXPECT_LT(reading.figures.at("unmeasured"), samples::kMerlCells / 5);
    EXPECT_LT(largestDifference(reading.brdf, brdfOf("lambert"), upperDirections(40)), 1e-6);
}

TEST_F(Merl, BadFilesAreRefusedWithTheFieldThatIsWrong) {
    EXPECT_THAT(refusalBy([&] { decodeMerl(file().substr(0, 7), "x.binary"); }), HasSubstr("x.binary: 7 bytes"));
    EXPECT_THAT(refusalBy([&] { decodeMerl(file().substr(0, file().size() - 1), "x"); }), HasSubstr("34992011 bytes"));
    EXPECT_THAT(refusalBy([&] { decodeMerl(file() + "x", "x"); }), HasSubstr("34992013 bytes"));
    std::string bytes = file();
    bytes[0] = 91;
    EXPECT_THAT(refusalBy([&] { decodeMerl(bytes, "x"); }), HasSubstr("91 x 90 x 180"));
    bytes = file();
    samples::setMerl(bytes, 1, (3 * 90 + 4) * 180 + 5, std::nan(""));
    EXPECT_THAT(refusalBy([&] { decodeMerl(bytes, "x"); }),
                HasSubstr("channel G of cell theta_h 3, theta_d 4, phi_d 5 is NaN"));
    samples::setMerl(bytes, 1, (3 * 90 + 4) * 180 + 5, -std::numeric_limits<double>::infinity());
    EXPECT_THAT(refusalBy([&] { decodeMerl(bytes, "x"); }), HasSubstr("infinite"));
    samples::setMerl(bytes, 1, (3 * 90 + 4) * 180 + 5, 1e200);
    EXPECT_THAT(refusalBy([&] { decodeMerl(bytes, "x"); }), HasSubstr("larger than any"));
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t cell = 0; cell < samples::kMerlCells; ++cell) samples::setMerl(bytes, c, cell, -1);
    EXPECT_THAT(refusalBy([&] { decodeMerl(bytes, "x"); }), HasSubstr("no cell"));
}

// --- Scattered measurements -----------------------------------------------------------------------------------------

// A grey paint keeps its value everywhere, whatever the spectral weights are: regression reproduces constants.
TEST(Scattered, AConstantGreyIsExact) {
    const RgbBrdf lambert = brdfOf("lambert");
    const BrdfReading reading = decodeScattered(samples::scatteredFile(lambert, 6, 7), "x", 1);
    EXPECT_EQ(reading.figures.at("samples"), 6 * 6 * 7);
    EXPECT_EQ(reading.figures.at("clamped"), 0);
    EXPECT_LT(largestDifference(reading.brdf, lambert, upperDirections(40)), 2e-6);  // six digits in the file
}

// A glossy grey paint is seen in 3,888 places. The relative rms error, weighted by both cosines, was measured as
// 0.108.
TEST(Scattered, AGlossyPaintIsFollowed) {
    const RgbBrdf paint = brdfOf("ggx:alpha=0.4,f0=0.5");
    const RgbBrdf read = decodeScattered(samples::scatteredFile(paint, 18, 12), "x", 0).brdf;
    double error = 0, total = 0;
    for (Vec3d a : upperDirections(600))
        for (Vec3d b : upperDirections(600)) {
            if (a.z < 0.2 || b.z < 0.2) continue;
            error += a.z * b.z * std::pow(read.eval(a, b).y - paint.eval(a, b).y, 2);
            total += a.z * b.z * std::pow(paint.eval(a, b).y, 2);
        }
    EXPECT_LT(std::sqrt(error / total), 0.15);
}

TEST(Scattered, SameTableForAnyThreadCount) {
    const std::string text = samples::scatteredFile(brdfOf("phong:exponent=8"), 6, 7);
    const RgbBrdf one = decodeScattered(text, "x", 1).brdf;
    for (int threads : {2, 8}) {
        const RgbBrdf other = decodeScattered(text, "x", threads).brdf;
        for (Vec3d a : upperDirections(20))
            for (Vec3d b : upperDirections(20)) ASSERT_EQ(other.eval(a, b), one.eval(a, b));
    }
}

// The paint reflects only around 520 nm. It is more saturated than Rec.709's green, so that red and blue would be
// negative.
TEST(Scattered, ColoursOutsideRec709AreClampedAndCounted) {
    std::string text = "5\n400 510 520 530 700\n";
    for (int k = 0; k < 20; ++k) text += "0.1 0 0." + std::to_string(k + 10) + " 0 0 0 0.3 0 0\n";
    const BrdfReading reading = decodeScattered(text, "x", 1);
    EXPECT_EQ(reading.figures.at("outside_rec709"), 40);
    EXPECT_EQ(reading.figures.at("clamped"), 0);
    const Vec3d f = reading.brdf.eval(samples::direction(0.1, 0), samples::direction(0.15, 0));
    EXPECT_EQ(f.x, 0);
    EXPECT_EQ(f.z, 0);
    EXPECT_GT(f.y, 0.01);
}

TEST(Scattered, BadFilesAreRefusedWithTheLineThatIsWrong) {
    const std::string good = samples::scatteredFile(brdfOf("lambert"), 6, 7);
    const auto message = [](const std::string& text) { return refusalBy([&] { decodeScattered(text, "x.brdf", 1); }); };
    EXPECT_EQ(message(good), "accepted");
    EXPECT_THAT(message(""), HasSubstr("number of wavelengths"));
    EXPECT_THAT(message("1\n500\n"), HasSubstr("2..1000"));
    EXPECT_THAT(message("2\n500 500\n"), HasSubstr("x.brdf: line 2: wavelength 1"));
    EXPECT_THAT(message("2\n500 600\n0.1 0 0.1 0 0.3 nan\n"), HasSubstr("'nan'"));
    EXPECT_THAT(message("2\n500 600\n0.1 0 1.6 0 0.3 0.3\n"), HasSubstr("theta o"));
    EXPECT_THAT(message("2\n500 600\n-0.1 0 1 0 0.3 0.3\n"), HasSubstr("theta i"));
    EXPECT_THAT(message("2\n500 600\n0.1 0 1 0 0.3 1e9\n"), HasSubstr("larger than any"));
    EXPECT_THAT(message("2\n500 600\n0.1 0 1 0 0.3 0.3\n"), HasSubstr("fewer than 16"));
    EXPECT_THAT(message(good.substr(0, good.size() - 12)), HasSubstr("ends before"));
    EXPECT_THAT(message(std::string("\x7f"
                                    "ELF\0\0",
                                    6)),
                HasSubstr("number of wavelengths"));
}

TEST(Scattered, NegativeValuesAreClampedAndCounted) {
    std::string text = "2\n500 600\n";
    for (int k = 0; k < 20; ++k) text += "0.1 0 0." + std::to_string(k + 10) + " 0 -0.001 0.3\n";
    EXPECT_EQ(decodeScattered(text, "x", 1).figures.at("clamped"), 20);
}

// --- Fits -----------------------------------------------------------------------------------------------------------

constexpr const char* kFits =
    "material,kD_r,kD_g,kD_b,A_r,A_g,A_b,B,C,ior\n"
    "matte,0.5,0.25,0.125,0,0,0,1,1,1.5\r\n"
    "shiny,0,0,0,3,2,1,100,1.5,1.5\n";

// Tests kD / pi alone; then normal incidence, where the lobe is at its height A, nothing is shadowed and F = 0.04;
// then a half vector at 0.2 rad, computed by hand.
TEST(Fits, ValuesAreThoseOfTheFormula) {
    const RgbBrdf matte = decodeFits(kFits, "x", "matte").brdf, shiny = decodeFits(kFits, "x", "shiny").brdf;
    const double pi = std::numbers::pi;
    const Vec3d normal{0, 0, 1}, tilted = samples::direction(0.4, 1);
    EXPECT_NEAR(matte.eval(normal, tilted).x, 0.5 / pi, 1e-15);
    EXPECT_NEAR(matte.eval(normal, tilted).z, 0.125 / pi, 1e-15);
    EXPECT_NEAR(shiny.eval(normal, normal).x, 3 * 0.04 / pi, 1e-12);
    const double lobe = 2 / std::pow(1 + 100 * (1 - std::cos(0.2)), 1.5);
    EXPECT_NEAR(shiny.eval(normal, tilted).y, lobe * dielectricFresnel(std::cos(0.2), 1.5) / (pi * std::cos(0.4)),
                1e-12);
    EXPECT_EQ(shiny.eval(normal, {0, 0.6, -0.8}), Vec3d{});
    EXPECT_NEAR(shiny.eval(normal, tilted).z, shiny.eval(tilted, normal).z, 1e-15);
}

TEST(Fits, BadFilesAndNamesAreRefused) {
    const auto message = [](const std::string& text) { return refusalBy([&] { decodeFits(text, "x.csv", "matte"); }); };
    const std::string fits = kFits, header = fits.substr(0, fits.find('\n') + 1);
    EXPECT_THAT(message("material,kD\n"), HasSubstr("line 1"));
    EXPECT_THAT(message(header), HasSubstr("no material"));
    EXPECT_THAT(message(fits + "a,1,2\n"), HasSubstr("x.csv: line 4: has 3 columns"));
    EXPECT_THAT(message(fits + "a,-1,0,0,0,0,0,1,1,1\n"), HasSubstr("kD_r is -1"));
    EXPECT_THAT(message(fits + "a,0,0,0,0,0,0,1,nan,1\n"), HasSubstr("C"));
    EXPECT_THAT(message(fits + "a,0,0,0,0,0,0,1,1,0.5\n"), HasSubstr("ior is 0.5"));
    EXPECT_THAT(message(fits + "matte,0,0,0,0,0,0,1,1,1\n"), HasSubstr("twice"));
    EXPECT_THROW(decodeFits(kFits, "x", ""), UsageError);
    EXPECT_THROW(decodeFits(kFits, "x", "mat"), UsageError);
}

// --- Our own table --------------------------------------------------------------------------------------------------

TEST(BrdfTable, ValuesAreThoseThatWereWritten) {
    // There are 24 x 24 x 25, 12 x 10 x 12 x 36 and 12 x 24 x 12 x 24 nodes. The bounds are what linear interpolation
    // leaves.
    const RgbBrdf gloss = brdfOf("phong:exponent=6,color=1/0.5/0.25"), brushed = brdfOf("ward-gmd:ax=0.6,ay=0.9");
    const BrdfReading iso = decodeBrdfTable(samples::isotropicTable(gloss, 24, 25), "x"),
                      ortho = decodeBrdfTable(samples::anisotropicTable(brushed, "orthotropic", 12, 10, 36), "x"),
                      general = decodeBrdfTable(samples::anisotropicTable(brushed, "general", 12, 24, 24), "x");
    std::vector<Vec3d> directions;
    for (Vec3d d : upperDirections(80))
        if (d.z > 0.3) directions.push_back(d);
    EXPECT_LT(largestDifference(iso.brdf, gloss, directions), 0.05);
    EXPECT_LT(largestDifference(ortho.brdf, brushed, directions), 0.1);
    EXPECT_LT(largestDifference(general.brdf, brushed, directions), 0.12);
    EXPECT_EQ(iso.brdf.symmetry, BrdfSymmetry::kIsotropic);
    EXPECT_EQ(ortho.brdf.symmetry, BrdfSymmetry::kOrthotropic);
    EXPECT_EQ(general.brdf.symmetry, BrdfSymmetry::kGeneral);
    EXPECT_EQ(iso.brdf.eval({0, 0, 1}, {0, 0.6, -0.8}), Vec3d{});
}

// The function is linear in every angle, so multilinear interpolation is exact between the outermost nodes, and over
// the seam at 2 pi.
TEST(BrdfTable, InterpolationIsExactForAFunctionThatIsLinearInTheAngles) {
    const RgbBrdf linear{"", BrdfSymmetry::kIsotropic, [](Vec3d wi, Vec3d wo) {
                             const double cosine =
                                 (wi.x * wo.x + wi.y * wo.y) / std::hypot(wi.x, wi.y) / std::hypot(wo.x, wo.y);
                             const double difference = std::acos(std::clamp(cosine, -1.0, 1.0));
                             return Vec3d{std::acos(wi.z), std::acos(wo.z), difference};
                         }};
    const RgbBrdf table = decodeBrdfTable(samples::isotropicTable(linear, 5, 4), "x").brdf;
    for (double phi : {-3.1, -1.0, 0.2, 2.0, 3.1}) {
        const Vec3d f = table.eval(samples::direction(0.5, 0.7), samples::direction(0.9, 0.7 + phi));
        EXPECT_NEAR(f.x, 0.5, 1e-6);
        EXPECT_NEAR(f.y, 0.9, 1e-6);
        EXPECT_NEAR(f.z, std::abs(phi), 3e-6);
    }
}

// |phi| is linear between nodes at 0 and pi, so it is exact over the seam, for both azimuths.
TEST(BrdfTable, AzimuthsCloseTheCircle) {
    const auto azimuth = [](Vec3d w) { return std::abs(std::atan2(w.y, w.x)); };
    const RgbBrdf tent{"", BrdfSymmetry::kGeneral, [&](Vec3d wi, Vec3d wo) {
                           return Vec3d{azimuth(wi), azimuth(wo), 1};
                       }};
    const RgbBrdf table = decodeBrdfTable(samples::anisotropicTable(tent, "general", 2, 4, 6), "x").brdf;
    for (double phi : {-3.0, -0.1, 0.1, 2.0, 3.1}) {
        const Vec3d f = table.eval(samples::direction(0.5, phi), samples::direction(0.9, 0.3 - phi));
        EXPECT_NEAR(f.x, std::abs(phi), 3e-6);
        EXPECT_NEAR(f.y, azimuth(samples::direction(1, 0.3 - phi)), 3e-6);
    }
}

TEST(BrdfTable, EveryTruncationIsRefused) {
    const std::string whole = samples::isotropicTable(brdfOf("phong"), 2, 3);
    ASSERT_NO_THROW(decodeBrdfTable(whole, "x"));
    for (std::size_t n = 0; n + 9 < whole.size(); ++n)  // the last number may lose digits
        EXPECT_THROW(decodeBrdfTable(whole.substr(0, n), "x"), InvalidInput) << "first " << n << " bytes";
}

TEST(BrdfTable, BadFilesAreRefusedWithTheLineThatIsWrong) {
    const auto message = [](const std::string& text) { return refusalBy([&] { decodeBrdfTable(text, "x.txt"); }); };
    const std::string head = "penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i 2\ntheta_o 2\nphi 2\n";
    const std::string seven = "1 1 1\n1 1 1\n1 1 1\n1 1 1\n1 1 1\n1 1 1\n1 1 1\n";
    EXPECT_EQ(message(head + seven + "0 0 0 # the last\n"), "accepted");
    EXPECT_THAT(message(head + seven + "0 -1 0"), HasSubstr("line 13: channel G of cell 7 is negative"));
    EXPECT_THAT(message(head + seven + "0 nan 0"), HasSubstr("'nan'"));
    EXPECT_THAT(message(head + seven + "0 1e7 0"), HasSubstr("above 1e6"));
    EXPECT_THAT(message(head + seven + "0 0 0 0"), HasSubstr("more values"));
    EXPECT_THAT(message("penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i 9\ntheta_o 9\nphi 9\n1 1 1"),
                HasSubstr("too short"));
    EXPECT_THAT(message("penumbra-brdf-table 2\n"), HasSubstr("version"));
    EXPECT_THAT(message("penumbra-brdf-table 1\nsymmetry round\n"), HasSubstr("'round'"));
    EXPECT_THAT(message("penumbra-brdf-table 1\nsymmetry isotropic\ntheta_i 1\n"), HasSubstr("2..1024"));
    EXPECT_THAT(
        message("penumbra-brdf-table 1\nsymmetry general\ntheta_i 1024\nphi_i 1024\ntheta_o 1024\nphi_o 1024\n"),
        HasSubstr("16777216"));
}

// --- Any source -----------------------------------------------------------------------------------------------------

TEST(BrdfSource, SourcesThatMakeNoSenseAreRefused) {
    EXPECT_THROW(readBrdfSource({}, 1), UsageError);
    EXPECT_THROW(readBrdfSource({.analytic = "ggx", .table = "x"}, 1), UsageError);
    EXPECT_THROW(readBrdfSource({.analytic = "ggx", .material = "chrome"}, 1), UsageError);
    EXPECT_THROW(readBrdfSource({.analytic = "gloss"}, 1), UsageError);
    EXPECT_THROW(readBrdfSource({.table = "/no/such/file"}, 1), IoError);
    EXPECT_THROW(readBrdfSource({.merl = "/"}, 1), IoError);
}

TEST(BrdfSource, FilesAreToldApartByWhatIsInThem) {
    const std::filesystem::path path = testing::TempDir() + "any_brdf";
    const auto read = [&](const std::string& text, const std::string& material = "") {
        std::ofstream(path, std::ios::binary) << text;
        return readBrdfSource({.table = path, .material = material}, 1);
    };
    EXPECT_EQ(read(samples::scatteredFile(brdfOf("lambert"), 6, 7)).brdf.name, "any_brdf");
    EXPECT_EQ(read(samples::isotropicTable(brdfOf("lambert"), 2, 2)).figures.at("samples"), 8);
    EXPECT_EQ(read(kFits, "shiny").brdf.name, "any_brdf:shiny");
    EXPECT_THROW(read(samples::isotropicTable(brdfOf("lambert"), 2, 2), "shiny"), UsageError);
    try {
        read(std::string("tensor_file\0\1\0", 14));
        FAIL() << "a .bsdf was read";
    } catch (const Unsupported& error) {
        EXPECT_THAT(error.what(), testing::AllOf(HasSubstr(".bsdf"), HasSubstr("RGL"), HasSubstr(".binary")));
    }
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace penumbra::test_brdf_source
