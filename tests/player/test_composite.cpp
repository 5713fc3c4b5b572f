// Characters in photographs: the composite's formula, the ground's ratio against probe(), light from characters, the
// lens, grain.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <numbers>
#include <random>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/pack_asset.h"
#include "player/composite/compose_picture.h"
#include "player/composite/lens_resampler.h"
#include "player/composite/photograph_frames.h"
#include "player/composite/picture_stream.h"
#include "player/composite/plate_grain.h"
#include "player/composite/sun_pixels.h"
#include "player/scene/probe.h"
#include "sh/cosine_product.h"
#include "sh/light/dominant_light.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/zonal.h"
#include "tests/difference.h"
#include "tests/sh/golden.h"
#include "tests/synthetic_composition.h"

namespace penumbra::test_composite {
namespace {

namespace fs = std::filesystem;
using std::numbers::pi;

// lit = sum of Gamma_ijk L_i V_j c_k, c the clamped cosine about `normal` in 8 bands, by a quadrature that is exact for
// these 4 + 5 + 8 bands.
Vec3d litReference(const std::vector<double>& light, const std::vector<double>& visible, Vec3d normal) {
    Vec3d lit;
    std::vector<double> y(64), about(64);
    evalBasis(8, normal, about);
    std::vector<double> cosine(64);
    const std::vector<WeightedDirection> hemisphere = gaussHemisphere(32, 64);
    for (int l = 0; l < 8; ++l) {
        double zonal = 0;  // zonal coefficient of the cosine about z
        for (const WeightedDirection& d : hemisphere) {
            evalBasis(8, d.direction, y);
            zonal += d.weight * d.direction.z * y[std::size_t(l * (l + 1))];
        }
        for (int m = -l; m <= l; ++m)
            cosine[std::size_t(l * (l + 1) + m)] =
                zonal * std::sqrt(4 * pi / (2 * l + 1)) * about[std::size_t(l * (l + 1) + m)];
    }
    for (const WeightedDirection& up : hemisphere)
        for (const double side : {1.0, -1.0}) {
            evalBasis(8, Vec3d{up.direction.x, up.direction.y, side * up.direction.z}, y);
            double v = 0, c = 0;
            for (std::size_t j = 0; j < visible.size(); ++j) v += visible[j] * y[j];
            for (std::size_t k = 0; k < 64; ++k) c += cosine[k] * y[k];
            for (std::size_t i = 0; i < 16; ++i)
                for (int channel = 0; channel < 3; ++channel)
                    lit[channel] += up.weight * light[3 * i + std::size_t(channel)] * y[i] * v * c;
        }
    return lit;
}

std::vector<double> flat(const nlohmann::json& rows) {
    std::vector<double> out;
    for (const auto& row : rows)
        for (const auto& x : row) out.push_back(x.get<double>());
    return out;
}

// The reference, whose ratio is clamped to 1; ours is not, as light from characters may pass it.
TEST(Composite, FormulaIsTheGoldenOne) {
    const nlohmann::json golden = readGolden("shadow_catcher.json");
    for (const nlohmann::json& one : golden["cases"]) {
        const std::vector<double> light = flat(one["light"]), visible = doubles(one["cast_order5"]);
        const Vec3d normal = vec3(one["normal"]), lit = litReference(light, visible, normal);
        const std::vector<double> open = {std::sqrt(4 * pi)};
        const Vec3d free = litReference(light, open, normal);
        std::vector<double> ratio;
        for (int c = 0; c < 3; ++c) ratio.push_back(std::clamp(lit[c] / std::max(free[c], 1e-6), 0.0, 1.0));
        expectNear(std::vector<double>{lit.x, lit.y, lit.z}, doubles(one["lit"]), 1e-9);
        expectNear(ratio, doubles(one["ratio"]), 1e-9);
        const Vec3 out = composed(toFloat(vec3(one["character"])), one["alpha"].get<float>(),
                                  toFloat(vec3(one["background"])), toFloat({ratio[0], ratio[1], ratio[2]}));
        expectNear(std::vector<double>{out.x, out.y, out.z}, doubles(one["composite"]), 1e-6);
    }
}

TEST(CharacterLight, MeanRadianceOfOneColorIsThatColor) {
    std::vector<ShiningVertex> vertices;
    for (int i = 0; i < 200; ++i) {
        const double a = 0.1 * i, h = 0.01 * i;
        const Vec3 out{float(std::cos(a)), -0.2f, float(std::sin(a))};
        vertices.push_back({{0.2f * out.x, float(h), 0.2f * out.z}, out * 0.01f, {0.5f, 0.25f, 0.125f}});
    }
    std::vector<Emitter> emitters;
    emittersOf(vertices, 0.1f, emitters);
    EXPECT_LT(emitters.size(), vertices.size());
    Vec3 total, joined;
    for (const ShiningVertex& v : vertices) total += v.area;
    for (const Emitter& e : emitters) joined += e.area;
    EXPECT_LT(length(total - joined), 1e-5f);
    EXPECT_LT(length(meanRadiance(emitters, {1, 0, 0}, {0, 1, 0}) - Vec3{0.5f, 0.25f, 0.125f}), 1e-6f);
}

// Two plates of one size face the point under the same angle: the nearer one counts as much more as it looks larger.
TEST(CharacterLight, NearerEmittersCountBySolidAngle) {
    const std::vector<Emitter> emitters = {{{1, 1, 0}, Vec3{-1, -1, 0} * 1e-4f, {1, 0, 0}},
                                           {{-2, 2, 0}, Vec3{1, -1, 0} * 1e-4f, {0, 1, 0}}};
    const Vec3 mean = meanRadiance(emitters, {0, 0, 0}, {0, 1, 0});
    EXPECT_NEAR(mean.x / mean.y, 4, 1e-3);
    EXPECT_EQ(meanRadiance(emitters, {0, 5, 0}, {0, 1, 0}), Vec3{});  // both lie below its horizon
}

// A uniform light of radiance 1 and a sun.
LightFile sunnyLight() {
    LightFile light = synthetic::light(4, 0);
    light.name = "sunny";
    const SunD sun{normalized(Vec3d{0.6, 0.8, 0.3}), {3, 2.5, 2}, 0.02};
    const SunD negative{sun.direction, -sun.irradiance, 0};
    subtractSuns(std::span(&negative, 1), {}, light.sh);
    light.suns = {sun};
    light.factor = "exact";
    return light;
}

class PhotographTest : public testing::Test {
protected:
    fs::path folder = fs::path(testing::TempDir()) / ("photograph_" + std::to_string(getpid()));

    void SetUp() override {
        fs::create_directories(folder);
        LightFile faint = sunnyLight(), soft = sunnyLight();
        faint.name = "faint";
        for (double& coefficient : faint.sh) coefficient *= kFaint;
        for (SunD& sun : faint.suns) sun.irradiance = sun.irradiance * kFaint;
        soft.name = "soft";
        soft.suns.clear();
        soft.factor.clear();
        const std::array lights = {sunnyLight(), faint, soft};
        const std::array materials = {synthetic::lambert({0.6f, 0.3f, 0.1f})};
        writeWholeFile(folder / "tube.pnb",
                       packAsset(synthetic::composedTube({.rings = 12, .segments = 9, .joints = 6, .clusters = 4}),
                                 materials, lights, {.precision = AssetPrecision::kF32}, "{}", 1)
                           .bytes);
        std::ofstream(folder / "box.obj") << "v -0.3 0 -0.3\nv 0.3 0 -0.3\nv 0.3 0 0.3\nv -0.3 0 0.3\nv -0.3 0.4 -0.3\n"
                                             "v 0.3 0.4 -0.3\nv 0.3 0.4 0.3\nv -0.3 0.4 0.3\nf 1 2 3 4\nf 5 8 7 6\n"
                                             "f 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n";
    }
    void TearDown() override { fs::remove_all(folder); }

    static constexpr double kFaint = 1e-7;
    static constexpr const char* kTube = R"("characters": [{"asset": "tube.pnb", "position": [0, 0.1, 0]}])";
    std::unique_ptr<PosedScene> scene(const std::string& keys, const std::string& lens = "",
                                      const std::string& light = "sunny") const {
        const std::string camera = R"("camera": {"f": 150, "size": [160, 120])" + lens +
                                   R"(, "R": [[1, 0, 0], [0, -0.447213595, -0.894427191], [0, 0.894427191,
                                   -0.447213595]], "t": [0, 0, 4.47213595]}, "ground": {"catcher": true, "height": -0.2})";
        return std::make_unique<PosedScene>(parseScene(
            R"({"version": 1, "light": {"asset": "tube.pnb", "name": ")" + light + "\"}, " + camera + ", " + keys + "}",
            "s.json", folder));
    }
    static PhotographFrame frameOf(PosedScene& scene, bool bounce = true) {
        RenderOptions options;
        options.sun_map = 256;
        options.samples = 1;
        PhotographFrames frames(scene, options, 2);
        frames.setParts({.shadow = true, .bounce = bounce});
        PhotographFrame frame;
        frames.compute(0, {}, frame);
        return frame;
    }
};

// The ratio is the quotient of what probe() says with and without the tube. Measured: 0.004 on average, 0.03 at an edge
// of the sun's shadow.
TEST_F(PhotographTest, RatioIsThatOfProbe) {
    const auto posed = scene(kTube);
    const PhotographFrame frame = frameOf(*posed, false);
    const SceneView view = SceneCameras(posed->file()).view(0, posed->file().origin);
    const SceneSuns suns = sceneSuns(*posed, SunChoice::kOn, 256, 1);
    std::vector<ProbePoint> points;
    std::vector<std::size_t> pixels;
    for (int y = 3; y < 120; y += 7)
        for (int x = 2; x < 160; x += 5) {
            const Vec3d d = view.direction({double(x), double(y)}), eye = view.eye();
            if (d.y > -0.05) continue;
            points.push_back({toFloat(eye + d * ((eye.y + 0.2) / -d.y)), {0, 1, 0}});
            pixels.push_back(std::size_t(y * 160 + x));
        }
    const std::vector<ProbeValue> with = probe(*posed, points, 1, suns);
    Largest apart;
    double sum = 0, darkest = 1;
    const auto nobody = scene(R"("characters": [])");
    const std::vector<ProbeValue> without = probe(*nobody, points, 1, sceneSuns(*nobody, SunChoice::kOn, 256, 1));
    for (std::size_t i = 0; i < points.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double expected = with[i].irradiance[c] / without[i].irradiance[c];
            apart.add(std::abs(expected - double(frame.ratio[pixels[i]][c])));
            sum += std::abs(expected - double(frame.ratio[pixels[i]][c]));
            darkest = std::min(darkest, expected);
        }
    EXPECT_LT(darkest, 0.7);  // there is a shadow
    EXPECT_LT(apart, 0.08);
    EXPECT_LT(sum / double(3 * points.size()), 0.006);
}

// Light from the tube only ever adds, most where the tube is near, and in its color.
TEST_F(PhotographTest, CharactersThrowLightOntoTheGround) {
    const auto posed = scene(kTube);
    const PhotographFrame with = frameOf(*posed), without = frameOf(*posed, false);
    double most = 0;
    for (std::size_t i = 0; i < with.ratio.size(); ++i) {
        const Vec3 more = with.ratio[i] - without.ratio[i];
        EXPECT_GE(std::min({more.x, more.y, more.z}), -1e-6f);
        most = std::max(most, double(more.x));
        if (more.x > 0.01f) {
            EXPECT_GT(more.x, more.z);
        }
    }
    EXPECT_GT(most, 0.01);
}

TEST_F(PhotographTest, WithoutCharactersNothingIsAdded) {
    const auto posed = scene(R"("characters": [])");
    const PhotographFrame frame = frameOf(*posed);
    EXPECT_TRUE(frame.characters.pixels.empty());
    for (const Vec3 ratio : frame.ratio) ASSERT_LT(length(ratio - Vec3{1, 1, 1}), 1e-6f);
}

// A box in the photograph casts nothing that is not there already, and hides what stands behind it.
TEST_F(PhotographTest, RealPropsHideAndAddNoShadow) {
    const auto alone = scene(R"("characters": [], "props": [{"real": "box.obj", "position": [0, -0.2, 0]}])");
    for (const Vec3 ratio : frameOf(*alone).ratio) ASSERT_LT(length(ratio - Vec3{1, 1, 1}), 1e-5f);
    const auto free = scene(kTube),
               hidden = scene(std::string(kTube) + R"(, "props": [{"real": "box.obj", "position": [0, 0.1, 0.6]}])");
    const auto coverage = [](const PhotographFrame& frame) {
        double sum = 0;
        for (const float a : frame.characters.alpha) sum += double(a);
        return sum;
    };
    const double before = coverage(frameOf(*free)), after = coverage(frameOf(*hidden));
    EXPECT_GT(before, 100);
    EXPECT_LT(after, 0.9 * before);
    // A box three metres away leaves the tube's shadow as it is.
    const auto far = scene(std::string(kTube) + R"(, "props": [{"real": "box.obj", "position": [3, -0.2, 0]}])");
    const PhotographFrame with = frameOf(*free), beside = frameOf(*far);
    Largest apart;
    for (std::size_t i = 0; i < with.ratio.size(); ++i) apart.add(double(length(with.ratio[i] - beside.ratio[i])));
    EXPECT_LT(apart, 0.4);  // the maps are coarser; measured: 0.26 at an edge
    EXPECT_LT(std::ranges::min(beside.ratio, {}, &Vec3::x).x, 0.7f);
}

TEST_F(PhotographTest, WhoCastsNothingLeavesTheGroundAsItIs) {
    const auto posed = scene(R"("characters": [{"asset": "tube.pnb", "position": [0, 0.1, 0], "casts": "nothing"}])");
    for (const Vec3 ratio : frameOf(*posed).ratio) ASSERT_LT(length(ratio - Vec3{1, 1, 1}), 1e-6f);
}

// Exposures have any unit, and so has the light: the ratio has none.
TEST_F(PhotographTest, RatioIsThatOfALightOfAnyUnit) {
    const std::string keys = std::string(kTube) + R"(, "props": [{"real": "box.obj", "position": [0.5, -0.2, -0.3]}])";
    const PhotographFrame bright = frameOf(*scene(keys)), faint = frameOf(*scene(keys, "", "faint"));
    for (std::size_t i = 0; i < bright.ratio.size(); ++i) ASSERT_LT(length(bright.ratio[i] - faint.ratio[i]), 1e-3f);
    EXPECT_LT(std::ranges::min(faint.ratio, {}, &Vec3::x).x, 0.7f);
}

// A scene whose light has no sun can be given one that has, as that of a mirror ball.
TEST_F(PhotographTest, ASunMayComeToALightWithoutOne) {
    const auto soft = scene(kTube, "", "soft"), sunny = scene(kTube);
    const PhotographFrame expected = frameOf(*sunny);
    soft->addDarkSun();
    RenderOptions options;
    options.sun_map = 256;
    options.samples = 1;
    PhotographFrames frames(*soft, options, 2);
    PhotographFrame frame;
    frames.replaceLight(*sunny->light());
    frames.compute(0, {}, frame);
    Largest apart;
    for (std::size_t i = 0; i < frame.ratio.size(); ++i) apart.add(double(length(frame.ratio[i] - expected.ratio[i])));
    EXPECT_LT(apart, 1e-4);
}

TEST_F(PhotographTest, RefusesScenesWithoutACameraOrALight) {
    const auto open = [&](const std::string& text) {
        PosedScene posed(parseScene(text, "s.json", folder));
        PhotographFrames frames(posed, {}, 1);
    };
    EXPECT_THROW(open(R"({"version": 1, "characters": [{"asset": "tube.pnb"}]})"), InvalidInput);
    EXPECT_THROW(open(R"({"version": 1, "camera": {"f": 10, "size": [8, 8], "R": [[1,0,0],[0,1,0],[0,0,1]],
                          "t": [0, 0, 1]}})"),
                 InvalidInput);
}

// The adaptive search gives the visibility that a search in every pixel gives. Measured: 0.004 on average.
TEST(SunPixels, AreThoseOfEveryPoint) {
    const std::vector<Vec3> corners = {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}};
    const std::vector<std::uint32_t> triangles = {0, 1, 2, 0, 2, 3};
    SunCasters casters;
    casters.members.push_back({corners, triangles});
    SunMaps maps;
    drawSunMaps({{0.6f, 0.8f, 0}, {1, 1, 1}, 0.03f}, casters, 512, 1, maps);
    std::vector<Vec3> points;
    for (int y = 0; y < 101; ++y)
        for (int x = 0; x < 121; ++x) points.push_back({0.05f * float(x - 60), 0, 0.05f * float(y - 50)});
    const std::vector<char> sees(points.size(), 1);
    std::vector<Vec3> light(points.size());
    addSun({121, 101, 121, points, sees}, maps, {1, 2, 0}, 2, light);
    Largest apart;
    double sum = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const float share = maps.visibility(points[i], {0, 1, 0});
        apart.add(std::abs(light[i].x - share));
        sum += double(std::abs(light[i].x - share));
        EXPECT_EQ(light[i].y, 2 * light[i].x);
    }
    EXPECT_LT(apart, 0.1);
    EXPECT_LT(sum / double(points.size()), 0.004);
}

Plate grayPlate(int width, int height) {
    Plate plate{{width, height, {}}, {}};
    for (int i = 0; i < 3 * width * height; ++i) plate.codes.rgb.push_back(std::uint8_t(i % 256));
    return plate;
}

TEST(Composer, LeavesCodesWhereNothingIsAdded) {
    const Plate plate = grayPlate(32, 24);
    std::vector<Vec3> ratio(32 * 24, Vec3{1, 1, 1});
    for (const char* curve : {"srgb", "linear", "rec709"}) {
        const Composer composer(*knownResponse(curve), 0.5f);
        EXPECT_EQ(composer.compose(plate, {Image(), ratio}, {}, 1).rgb, plate.codes.rgb);
    }
}

// Half the light of a linear camera is half the code, and a character's radiance is shown times the exposure.
TEST(Composer, WorksInLinearLight) {
    const Plate plate = grayPlate(16, 16);
    std::vector<Vec3> ratio(256, Vec3{0.5f, 1, 1});
    Image character{16, 16, std::vector<Vec3>(256), std::vector<float>(256)};
    character.alpha[7] = 0.5f;
    character.pixels[7] = {0.2f, 0.2f, 0.2f};
    const TexturePicture out = Composer(*knownResponse("linear"), 2).compose(plate, {character, ratio}, {}, 1);
    EXPECT_EQ(out.rgb[3], std::uint8_t(plate.codes.rgb[3] * 0.5 + 0.5));
    EXPECT_EQ(out.rgb[22], std::uint8_t(0.4 * 255 + 0.5 * plate.codes.rgb[22] + 0.5));
}

TEST(PictureSink, AVideoHasPicturesOfOneSize) {
    const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "one_size.y4m";
    PictureSink sink(file, nullptr, 25);
    const auto picture = [](int width, int height) {
        return TexturePicture{width, height, std::vector<std::uint8_t>(std::size_t(3 * width * height), 90)};
    };
    sink.write(0, picture(6, 4));
    EXPECT_THROW(sink.write(1, picture(8, 4)), InvalidInput);
    EXPECT_THROW(sink.write(1, picture(6, 5)), InvalidInput);
    EXPECT_NO_THROW(sink.write(1, picture(6, 4)));
}

TEST(PlateGrain, IsMeasuredAndGiven) {
    std::mt19937 random(1);
    std::normal_distribution<double> noise(0, 4);
    TexturePicture plate{200, 200, {}};
    for (int i = 0; i < 200 * 200; ++i)
        for (int c = 0; c < 3; ++c)
            plate.rgb.push_back(std::uint8_t(std::lround(110 + 0.05 * (i % 200) + noise(random))));
    const PlateGrain grain = measureGrain(plate);
    EXPECT_NEAR(grain.deviation[0][3], 4, 0.3);
    EXPECT_NEAR(grain.deviation[1][7], 4, 0.6);  // a level that nothing has
    const std::vector<float> given = grainFor(grain, plate, 3);
    double square = 0;
    for (const float g : given) square += double(g) * double(g);
    EXPECT_NEAR(std::sqrt(square / double(given.size())), 4, 0.3);
    EXPECT_EQ(given, grainFor(grain, plate, 3));
    EXPECT_NE(given, grainFor(grain, plate, 4));
}

// A dot of the plain picture stands where the lens puts it.
TEST(LensResampler, BendsAsTheLensDoes) {
    const PinholeCamera camera{200, 99.5, 79.5, 200, 160, -0.16, 0.05};
    const LensResampler lens(camera);
    const PinholeCamera& plain = lens.plain();
    EXPECT_EQ(plain.k1, 0);
    for (const Vec3d ray : {Vec3d{0.4, 0.3, 1}, Vec3d{-0.45, 0.1, 1}, Vec3d{0, 0, 1}}) {
        Image drawn{plain.width, plain.height, {}, {}};
        drawn.pixels.resize(std::size_t(plain.width) * std::size_t(plain.height));
        drawn.alpha.resize(drawn.pixels.size());
        const PixelPoint at = *project(plain, ray);
        for (int y = 0; y < plain.height; ++y)
            for (int x = 0; x < plain.width; ++x)
                if (std::hypot(x - at.x, y - at.y) < 6) drawn.alpha[std::size_t(y * plain.width + x)] = 1;
        Image out;
        lens.resample({std::move(drawn), 0, 0}, 1, out);
        double sum = 0, sx = 0, sy = 0;
        for (int y = 0; y < 160; ++y)
            for (int x = 0; x < 200; ++x) {
                const double a = double(out.alpha[std::size_t(y * 200 + x)]);
                sum += a, sx += a * x, sy += a * y;
            }
        const PixelPoint expected = *project(camera, ray);
        EXPECT_NEAR(sx / sum, expected.x, 0.1);
        EXPECT_NEAR(sy / sum, expected.y, 0.1);
    }
    const PinholeCamera none{200, 99.5, 79.5, 200, 160};
    EXPECT_EQ(LensResampler(none).plain(), none);
}

}  // namespace
}  // namespace penumbra::test_composite
