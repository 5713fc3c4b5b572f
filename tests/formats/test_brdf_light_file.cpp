#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "formats/common/errors.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "sh/reflectance.h"
#include "tests/formats/round_trip.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_brdf_light_file {
namespace {

using samples::bytesOf;
using samples::Folder;
using samples::sampleBrdf;
using samples::sampleLight;
using samples::sampleLobes;
using samples::sampleOperators;

BrdfFile again(const BrdfFile& brdf) { return samples::roundTrip(brdf, writeBrdf, readBrdf); }
LightFile again(const LightFile& light) { return samples::roundTrip(light, writeLight, readLight); }

TEST(BrdfFile, RoundTripIsExactAndDeterministic) {
    const BrdfFile brdf = sampleBrdf(), back = again(brdf);
    EXPECT_EQ(back.name, brdf.name);
    EXPECT_EQ(back.slice_order, 3);
    EXPECT_EQ(back.view_order, 2);
    EXPECT_EQ(back.even_index, brdf.even_index);
    EXPECT_EQ(back.slices, brdf.slices);
    EXPECT_EQ(back.errors, brdf.errors);
    EXPECT_EQ(toJson(back.provenance), toJson(brdf.provenance));
}

TEST(BrdfFile, OperatorsRoundTrip) {
    BrdfFile brdf = sampleBrdf();
    EXPECT_EQ(again(brdf).operators.count, 0);
    brdf.operators = sampleOperators();
    EXPECT_EQ(again(brdf).operators, brdf.operators);
    EXPECT_EQ(again(brdf).slices, brdf.slices);
    brdf.operators.source = "literal";  // its view functions are its own
    brdf.operators.view_index = {0, 1, 2};
    EXPECT_EQ(again(brdf).operators, brdf.operators);
}

TEST(BrdfFile, LobesRoundTrip) {
    BrdfFile brdf = sampleBrdf();
    brdf.lobes = {lobeOf(parseBrdf("lambert:color=0.5/0.25/0.1")), lobeOf(parseBrdf("ward:ax=0.01"))};
    brdf.lobe_error = 0.25;
    EXPECT_EQ(again(brdf).lobes, brdf.lobes);
    EXPECT_EQ(again(brdf).lobe_error, 0.25);
}

TEST(BrdfFile, WrongLobesAreRefused) {
    const Folder folder("wrong_lobes");
    const auto path = folder.path / "m.brdf.h5";
    const auto expectRefused = [&](const char* what, const auto& damage) {
        BrdfFile brdf = sampleBrdf();
        damage(brdf);
        writeBrdf(path, brdf);
        try {
            readBrdf(path);
            FAIL() << what << " was read";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("m.brdf.h5"), testing::HasSubstr(what)));
        }
    };
    expectRefused("/lobes/model", [](BrdfFile& b) { b.lobes[0].model = BrdfModel(kBrdfModels); });
    expectRefused("/lobes/model: 0 lobes; 1..4", [](BrdfFile& b) { b.lobes.clear(); });
    expectRefused("5 lobes", [](BrdfFile& b) { b.lobes.resize(5); });
    expectRefused("lobe 0 (ggx)", [](BrdfFile& b) { b.lobes[0].parameters[0] = 2; });
    expectRefused("lobe 0 (ggx)", [](BrdfFile& b) { b.lobes[0].color.x = -1; });
    expectRefused("/lobes: error", [](BrdfFile& b) { b.lobe_error = -1; });
}

BrdfFile liveFile() {
    BrdfFile brdf = sampleBrdf();
    brdf.slice_order = brdf.view_order = 1;
    brdf.even_index = {0};
    brdf.slices.clear();
    brdf.lobes = {lobeOf(parseBrdf("phong-live:exponent=20"))};
    return brdf;
}

TEST(BrdfFile, LiveMaterialsAndMembranesRoundTrip) {
    EXPECT_TRUE(again(liveFile()).isLive());
    EXPECT_EQ(again(liveFile()).lobes, liveFile().lobes);
    BrdfFile film = sampleBrdf();
    EXPECT_FALSE(again(film).membrane);
    film.membrane = Membrane{{0.5f, 0.25f, 0}, {0.25f, 0.5f, 1}, true};
    EXPECT_EQ(again(film).membrane, film.membrane);
    EXPECT_EQ(again(film).slices, film.slices);
}

BrdfFile steppedFile() {
    BrdfFile brdf = sampleBrdf();
    brdf.lobes = {lobeOf(parseBrdf("ggx:alpha=0.2"))};
    BrdfSteps steps{0, {0.1, 0.2, 0.4}, {}, 0.01};
    for (const double scale : {0.5, 1.0, 2.0})
        for (const double value : brdf.slices) steps.slices.push_back(scale * value);
    brdf.steps = steps;
    return brdf;
}

TEST(BrdfFile, StepsRoundTrip) {
    EXPECT_EQ(again(steppedFile()).steps, steppedFile().steps);
    EXPECT_EQ(again(steppedFile()).slices, steppedFile().slices);
}

// Two of three lobes follow the steps, and the surface glows.
BrdfFile principledFile() {
    BrdfFile brdf = steppedFile();
    brdf.lobes = {lobeOf(parseBrdf("principled-diffuse")), lobeOf(parseBrdf("ggx-f0:roughness=0.2")),
                  lobeOf(parseBrdf("ggx-f90:roughness=0.2"))};
    brdf.steps->lobes = 0b110;
    brdf.emission = {4, 2, 0};
    return brdf;
}

TEST(BrdfFile, StepsOfSeveralLobesAndEmissionRoundTrip) {
    const BrdfFile read = again(principledFile());
    EXPECT_EQ(read.steps, principledFile().steps);
    EXPECT_EQ(read.emission, principledFile().emission);
    EXPECT_EQ(again(steppedFile()).emission, Vec3{});
}

TEST(BrdfFile, WrongStepsAreRefused) {
    const Folder folder("wrong_steps");
    const auto path = folder.path / "m.brdf.h5";
    const auto expectRefused = [&](const char* what, const auto& damage) {
        BrdfFile brdf = steppedFile();
        damage(brdf);
        writeBrdf(path, brdf);
        try {
            readBrdf(path);
            FAIL() << what << " was read";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("m.brdf.h5"), testing::HasSubstr(what)));
        }
    };
    expectRefused("/steps/values: not ascending", [](BrdfFile& b) { b.steps->values[1] = 0.1; });
    expectRefused("/steps/values: out of the range of alpha", [](BrdfFile& b) { b.steps->values[0] = 0; });
    expectRefused("/steps/values: do not enclose", [](BrdfFile& b) {
        b.steps->values[0] = 0.3;
        b.steps->values[1] = 0.35;
    });
    expectRefused("parameter", [](BrdfFile& b) { b.steps->parameter = 2; });
    expectRefused("/steps: error", [](BrdfFile& b) { b.steps->error = -1; });
    expectRefused("/steps: the material is not one lobe", [](BrdfFile& b) { b.lobe_error = 0.1; });
    expectRefused("/steps: the material is not one lobe", [](BrdfFile& b) { b.membrane = Membrane(); });
    expectRefused("/steps: lambert has no parameter", [](BrdfFile& b) { b.lobes = {lobeOf({})}; });
    expectRefused("/steps: lobes names lobes", [](BrdfFile& b) { b.steps->lobes = 2; });
    expectRefused("/steps: lobes names lobes", [](BrdfFile& b) { b.steps->lobes = 0; });
    expectRefused("/steps: the lobes have no parameter in common", [](BrdfFile& b) {
        b = principledFile();
        b.lobes[2].parameters[0] = 0.3f;
    });
    expectRefused("/steps: the lobes have no parameter in common", [](BrdfFile& b) {
        b = principledFile();
        b.steps->lobes = 0b111;
    });
    expectRefused("/emission/radiance: is not 0 or more", [](BrdfFile& b) { b.emission = {0, -1, 0}; });
    expectRefused("1 steps; 2..33", [](BrdfFile& b) {
        b.steps->values = {0.2};
        b.steps->slices.resize(b.slices.size());
    });
}

TEST(BrdfFile, WrongMembranesAreRefused) {
    const Folder folder("films");
    const auto path = folder.path / "m.brdf.h5";
    for (const Membrane& wrong : {Membrane{{-0.1f, 0, 0}, {}}, Membrane{{0.5f, 0.5f, 0.5f}, {0.2f, 0.2f, 0.6f}}}) {
        BrdfFile film = sampleBrdf();
        film.membrane = wrong;
        writeBrdf(path, film);
        EXPECT_THROW(readBrdf(path), InvalidInput);
    }
}

// Our own writer writes files with one thing wrong at a time.
TEST(BrdfFile, WrongOperatorsAreRefused) {
    const Folder folder("wrong_operators");
    const auto path = folder.path / "m.brdf.h5";
    const auto expectRefused = [&](const char* what, const auto& damage) {
        BrdfFile brdf = sampleBrdf();
        brdf.operators = sampleOperators();
        damage(brdf.operators);
        writeBrdf(path, brdf);
        try {
            readBrdf(path);
            FAIL() << what << " was read";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("m.brdf.h5"), testing::HasSubstr(what)));
        }
    };
    expectRefused("source", [](BrdfOperators& o) { o.source = "guess"; });
    expectRefused("view_index", [](BrdfOperators& o) { o.view_index = {0, 1, 2}; });
    expectRefused("not ascending", [](BrdfOperators& o) { o.source = "literal", o.view_index = {0, 2, 2}; });
    expectRefused("view_index", [](BrdfOperators& o) { o.source = "literal", o.view_index = {0, 2, 64}; });
    expectRefused("view_index", [](BrdfOperators& o) { o.view_index.pop_back(), o.w.resize(2 * 2 * 3); });
    expectRefused("order", [](BrdfOperators& o) { o.order = 9, o.u.resize(2 * 81 * 3); });
}

TEST(LightFile, RoundTripIsExactAndDeterministic) {
    const LightFile light = sampleLight(), back = again(light);
    EXPECT_EQ(back.name, light.name);
    EXPECT_EQ(back.order, 2);
    EXPECT_EQ(back.sh, light.sh);
    EXPECT_EQ(back.residual, light.residual);
    EXPECT_EQ(toJson(back.provenance), toJson(light.provenance));
}

TEST(LightFile, LobesRoundTrip) {
    LightFile light = sampleLight();
    light.lobes = sampleLobes();
    light.window = {1, 0.625};
    const LightFile read = again(light);
    EXPECT_EQ(read.window, light.window);
    const LightLobesFit& back = read.lobes;
    EXPECT_EQ(back.mode, "joint");
    EXPECT_EQ(back.directions, light.lobes.directions);
    EXPECT_EQ(back.coefficients, light.lobes.coefficients);
    EXPECT_EQ(back.residual, 0.0625);
    EXPECT_EQ(back.irradiance_error, 1.0 / 3);
}

TEST(LightFile, BadLobesAreRefused) {
    const Folder folder("bad_lobes");
    const auto path = folder.path / "e.light.h5";
    LightFile light = sampleLight();
    const auto expectRefused = [&](const LightLobesFit& lobes, const char* named) {
        light.lobes = lobes;
        writeLight(path, light);
        try {
            readLight(path);
            FAIL() << named << " was read";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(named));
        }
    };
    LightLobesFit lobes = sampleLobes();
    lobes.directions[1] = {0.6, -0.8, 0.1};
    expectRefused(lobes, "row 1");
    lobes = sampleLobes();
    lobes.mode = "best";
    expectRefused(lobes, "best");
    lobes = sampleLobes();
    lobes.residual = -1;
    expectRefused(lobes, "residual");
}

// Tries every prefix of a file. HDF5 itself notices most of them, because the root says how long the file is.
template <class Read>
void expectEveryTruncationFails(const std::filesystem::path& whole_path, const Read& read) {
    const std::string whole = bytesOf(whole_path);
    const auto cut = whole_path.parent_path() / "cut.h5";
    for (std::size_t n = 0; n < whole.size(); n += n < 128 ? 1 : 61) {
        samples::writeBytes(cut, whole.substr(0, n));
        EXPECT_THROW(read(cut), InvalidInput) << "first " << n << " of " << whole.size() << " bytes";
    }
}

LightFile factoredLight() {
    LightFile light = sampleLight();
    light.factor = "hand-over";
    light.suns = {{{0.6, 0, 0.8}, {5, 4, 3}, 0.01}, {{0, 1, 0}, {0, 0, 1}, 0}};
    light.picture = {4, 2, std::vector<float>(24, 0.25f)};
    return light;
}

TEST(LightFile, SunsRoundTrip) {
    LightFile light = factoredLight();
    const LightFile back = again(light);
    EXPECT_EQ(back.factor, "hand-over");
    ASSERT_EQ(back.suns.size(), 2u);
    EXPECT_EQ(back.suns[0].direction, light.suns[0].direction);
    EXPECT_EQ(back.suns[0].irradiance, light.suns[0].irradiance);
    EXPECT_EQ(back.suns[0].radius, 0.01);
    EXPECT_EQ(back.picture.width, 4);
    EXPECT_EQ(back.picture.height, 2);
    EXPECT_EQ(back.picture.pixels, light.picture.pixels);
    light.suns.clear(), light.picture = {};
    EXPECT_EQ(again(light).factor, "hand-over");
    EXPECT_TRUE(again(light).suns.empty());
}

TEST(LightFile, BadSunsAreRefused) {
    const Folder folder("bad_suns");
    const auto path = folder.path / "e.light.h5";
    const auto expectRefused = [&](const char* named, const auto& damage) {
        LightFile light = factoredLight();
        damage(light);
        writeLight(path, light);
        try {
            readLight(path);
            FAIL() << named << " was read";
        } catch (const InvalidInput& error) {
            EXPECT_THAT(error.what(), testing::HasSubstr(named));
        }
    };
    expectRefused("not of length 1", [](LightFile& l) { l.suns[1].direction = {0, 2, 0}; });
    expectRefused("row 1 has a negative irradiance", [](LightFile& l) { l.suns[1].irradiance.y = -1; });
    expectRefused("radius", [](LightFile& l) { l.suns[0].radius = 2; });
    expectRefused("1 to 8 suns, not 9", [](LightFile& l) { l.suns.resize(9, l.suns[0]); });
    expectRefused("factor", [](LightFile& l) { l.factor = "best"; });
    expectRefused("/light/picture", [](LightFile& l) { l.picture.pixels[3] = -1; });
    expectRefused("/light/picture", [](LightFile& l) { l.picture.pixels[3] = 1e6f; });
    expectRefused("/light/picture", [](LightFile& l) { l.picture = {2, 4, l.picture.pixels}; });
}

// A reader refuses radiance that shading could not sum. The message names the file and the field.
TEST(LightFile, NumbersThatAreTooLargeAreNamed) {
    const Folder folder("bright");
    const auto path = folder.path / "e.light.h5";
    const auto refusal = [&](const auto& damage) {
        LightFile light = factoredLight();
        light.lobes = sampleLobes();
        damage(light);
        writeLight(path, light);
        try {
            readLight(path);
            return std::string();
        } catch (const InvalidInput& error) {
            return std::string(error.what());
        }
    };
    EXPECT_EQ(refusal([](LightFile& l) { l.sh[5] = -1e33; }), "");
    const std::string limit = " holds 1.06e+39; at most 1e+33 is allowed of a light";
    EXPECT_EQ(refusal([](LightFile& l) { l.sh[5] = 1.06e39; }), path.string() + ": /light/sh:" + limit);
    EXPECT_EQ(refusal([](LightFile& l) { l.suns[0].irradiance.z = 1.06e39; }),
              path.string() + ": /light/suns:" + limit);
    EXPECT_EQ(refusal([](LightFile& l) { l.lobes.coefficients[1] = 1.06e39; }),
              path.string() + ": /light/lobes/coefficients:" + limit);
}

TEST(BrdfFile, RejectsTruncation) {
    const Folder folder("brdf_cut");
    BrdfFile brdf = sampleBrdf();
    brdf.operators = sampleOperators();
    writeBrdf(folder.path / "m.brdf.h5", brdf);
    expectEveryTruncationFails(folder.path / "m.brdf.h5", readBrdf);
}

TEST(LightFile, RejectsTruncation) {
    const Folder folder("light_cut");
    writeLight(folder.path / "e.light.h5", sampleLight());
    expectEveryTruncationFails(folder.path / "e.light.h5", readLight);
}

TEST(BrdfFile, OtherKindsAreNamed) {
    const Folder folder("kinds");
    writeLight(folder.path / "e.light.h5", sampleLight());
    try {
        readBrdf(folder.path / "e.light.h5");
        FAIL() << "a light was read as a BRDF";
    } catch (const InvalidInput& error) {
        EXPECT_THAT(error.what(),
                    testing::AllOf(testing::HasSubstr("e.light.h5"), testing::HasSubstr("penumbra.light")));
    }
    EXPECT_THROW(readLight(folder.path / "none.h5"), IoError);
}

TEST(BrdfFile, NaNIsNotWritten) {
    const Folder folder("nan");
    BrdfFile brdf = sampleBrdf();
    brdf.slices[5] = std::nan("");
    EXPECT_THROW(writeBrdf(folder.path / "m.brdf.h5", brdf), std::runtime_error);
    EXPECT_FALSE(std::filesystem::exists(folder.path / "m.brdf.h5"));
}

TEST(BrdfFile, OtherViewFunctionsAreRefused) {
    const Folder folder("even");
    writeBrdf(folder.path / "m.brdf.h5", sampleBrdf());
    std::string bytes = bytesOf(folder.path / "m.brdf.h5");
    const std::string even("\0\0\0\0\1\0\0\0\3\0\0\0", 12);  // 0, 1, 3
    ASSERT_NE(bytes.find(even), std::string::npos);
    bytes[bytes.find(even) + 8] = 2;
    samples::writeBytes(folder.path / "m.brdf.h5", bytes);
    EXPECT_THROW(readBrdf(folder.path / "m.brdf.h5"), InvalidInput);
}

TEST(BrdfFile, NaNIsRefused) {
    const Folder folder("nan");
    BrdfFile brdf = sampleBrdf();
    brdf.slices[5] = 0.123456789;
    writeBrdf(folder.path / "m.brdf.h5", brdf);
    std::string bytes = bytesOf(folder.path / "m.brdf.h5");
    const double nan = std::nan("");
    const std::string from(reinterpret_cast<const char*>(&brdf.slices[5]), 8);
    bytes.replace(bytes.find(from), 8, reinterpret_cast<const char*>(&nan), 8);
    samples::writeBytes(folder.path / "m.brdf.h5", bytes);
    EXPECT_THROW(readBrdf(folder.path / "m.brdf.h5"), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_brdf_light_file
