// Pictures of lights as renderers and photographers write them: colours, layers, windows, repairs.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChromaticities.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMultiPartOutputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfOutputPart.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/image/color_space.h"
#include "formats/image/factor_light.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_light_pictures {
namespace {

using testing::HasSubstr;

std::filesystem::path scratch(const std::string& name) {
    static const samples::Folder folder("light_pictures");
    return folder.path / name;
}

std::string refusalOf(const auto& read) {
    try {
        read();
        return "";
    } catch (const std::exception& error) {
        return error.what();
    }
}

EnvironmentMap readMap(const std::string& name, const PictureOptions& options = {}) {
    return readEnvironmentMap(scratch(name), options);
}

// --- Colours ---------------------------------------------------------------------------------------------------------

constexpr Primaries kAcesCg{{0.713, 0.293}, {0.165, 0.830}, {0.128, 0.044}, {0.32168, 0.33767}};
const std::vector<Primaries> kSevenPrimaries = {
    kAcesCg,
    {{0.7347, 0.2653}, {0, 1}, {0.0001, -0.077}, {0.32168, 0.33767}},               // ACES2065-1
    {{0.708, 0.292}, {0.170, 0.797}, {0.131, 0.046}, {0.3127, 0.3290}},             // Rec.2020
    {{0.680, 0.320}, {0.265, 0.690}, {0.150, 0.060}, {0.314, 0.351}},               // P3 of cinemas
    {{0.640, 0.330}, {0.290, 0.600}, {0.150, 0.060}, {1 / 3.0, 1 / 3.0}},           // Radiance
    {{0.7347, 0.2653}, {0.1596, 0.8404}, {0.0366, 0.0001}, {0.34567, 0.35850}},     // ProPhoto
    {{0.6484, 0.3309}, {0.3212, 0.5979}, {0.1559, 0.0661}, {0.345708, 0.358541}}};  // a camera profile, D50

TEST(ColorSpace, WhiteStaysWhite) {
    for (const Primaries& primaries : kSevenPrimaries) {
        const std::optional<Mat3d> matrix = toRec709(primaries);
        ASSERT_TRUE(matrix);
        const Vec3d white = *matrix * Vec3d{1, 1, 1};
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(white[c], 1, 1e-12) << describePrimaries(primaries);
    }
    EXPECT_FALSE(toRec709(kRec709Primaries));
    EXPECT_FALSE(toRec709(primariesOf("srgb-linear")));
}

// The published matrix of ACEScg to linear Rec.709 with Bradford's adaptation.
TEST(ColorSpace, AcesCgIsAsPublished) {
    const Mat3d m = *toRec709(primariesOf("ACEScg"));
    const double published[9] = {1.70505, -0.62179, -0.08326, -0.13026, 1.14080, -0.01055, -0.02400, -0.12897, 1.15297};
    for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(m.m[i], published[i], 1e-4) << i;
    EXPECT_TRUE(samePrimaries(primariesOf("Rec.2020"), primariesOf("rec2020")));
    EXPECT_THROW(primariesOf("adobe"), std::invalid_argument);
    EXPECT_THROW(toRec709({{0.3, 0.3}, {0.4, 0.4}, {0.5, 0.5}, {0.3127, 0.329}}), std::invalid_argument);
    EXPECT_THROW(toRec709({{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3, 0}}), std::invalid_argument);
    EXPECT_THROW(toRec709({{NAN, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3127, 0.329}}), std::invalid_argument);
}

// An .hdr of 2 x 1 pixels, each (1, 0.5, 0.25).
Vec3 hdrPixel(const std::string& header, const PictureOptions& options = {},
              const std::string& format = "FORMAT=32-bit_rle_rgbe") {
    const std::string data("\x80\x40\x20\x81\x80\x40\x20\x81", 8);
    const std::string text = "#?RADIANCE\n" + header + format + "\n\n-Y 1 +X 2\n" + data;
    return decodeImage(std::as_bytes(std::span(text)), "p.hdr", options).pixels[0];
}

void expectNear(Vec3 a, Vec3 b) {
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], 2e-6);
}

TEST(LightPictures, HdrHeadersAreUnderstood) {
    const Vec3 plain{1, 0.5f, 0.25f};
    expectNear(hdrPixel("EXPOSURE=+2\n"), 0.5f * plain);
    expectNear(hdrPixel("EXPOSURE=\t2\nEXPOSURE= 4 \n"), 0.125f * plain);
    expectNear(hdrPixel("COLORCORR=2 1 0.5\n"), {0.5f, 0.5f, 0.5f});
    expectNear(hdrPixel("COLORCORR=2 1 0.5\nEXPOSURE=2\nCOLORCORR=+1 2 1\n"), {0.25f, 0.125f, 0.25f});
    expectNear(hdrPixel("", {}, "FORMAT= 32-bit_rle_rgbe \t"), plain);
    const std::string rec2020 = "PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.3290\n";
    const Vec3 converted = toFloat(*toRec709(primariesOf("rec2020")) * toDouble(plain));
    expectNear(hdrPixel(rec2020), converted);
    PictureOptions as_rec2020;
    as_rec2020.colorspace = "rec2020";
    expectNear(hdrPixel("", as_rec2020), converted);
    expectNear(hdrPixel("", {}, "FORMAT=32-bit_rle_xyze"), toFloat(xyzToRec709() * toDouble(plain)));
    EXPECT_THROW(hdrPixel("", as_rec2020, "FORMAT=32-bit_rle_xyze"), BadOption);
    EXPECT_THROW(hdrPixel("COLORCORR=2 1\n"), InvalidInput);
    EXPECT_THROW(hdrPixel("COLORCORR=2 1 0\n"), InvalidInput);
    EXPECT_THROW(hdrPixel("EXPOSURE=-1\n"), InvalidInput);
    EXPECT_THROW(hdrPixel("PRIMARIES=0 0 0 0 0 0 0 0\n"), InvalidInput);
    EXPECT_THROW(hdrPixel("PRIMARIES=0.6 0.3\n"), InvalidInput);
    EXPECT_THROW(hdrPixel("", {}, "FORMAT=32-bit_rle_cmyk"), Unsupported);
    PictureOptions layer;
    layer.layer = "beauty";
    EXPECT_THROW(hdrPixel("", layer), BadOption);
}

// --- OpenEXR ---------------------------------------------------------------------------------------------------------

struct Channel {
    std::string name;
    std::vector<float> values;
};

// A channel of numbers that only it has.
Channel channel(const std::string& name, int pixels, float start) {
    Channel out{name, {}};
    for (int i = 0; i < pixels; ++i) out.values.push_back(start + float(i % 16) / 16);
    return out;
}

Imf::FrameBuffer bufferOf(Imf::Header& header, std::vector<Channel>& channels) {
    Imf::FrameBuffer buffer;
    const Imath::Box2i window = header.dataWindow();
    const std::size_t width = std::size_t(window.max.x - window.min.x + 1);
    for (Channel& one : channels) {
        header.channels().insert(one.name, Imf::Channel(Imf::FLOAT));
        buffer.insert(one.name, Imf::Slice::Make(Imf::FLOAT, one.values.data(), window, 4, 4 * width));
    }
    return buffer;
}

void writeChannels(const std::string& name, Imf::Header header, std::vector<Channel> channels) {
    const Imf::FrameBuffer buffer = bufferOf(header, channels);
    Imf::OutputFile file(scratch(name).c_str(), header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(header.dataWindow().max.y - header.dataWindow().min.y + 1);
}

struct Part {
    std::string name;
    std::vector<Channel> channels;
};

void writeParts(const std::string& name, std::vector<Part> parts) {
    std::vector<Imf::Header> headers;
    std::vector<Imf::FrameBuffer> buffers;
    for (Part& part : parts) {
        headers.emplace_back(8, 4);
        headers.back().setName(part.name);
        headers.back().setType(Imf::SCANLINEIMAGE);
        buffers.push_back(bufferOf(headers.back(), part.channels));
    }
    Imf::MultiPartOutputFile file(scratch(name).c_str(), headers.data(), int(headers.size()), false, 0);
    for (int i = 0; i < int(parts.size()); ++i) {
        Imf::OutputPart part(file, i);
        part.setFrameBuffer(buffers[std::size_t(i)]);
        part.writePixels(4);
    }
}

// The reds that a picture begins with tell which channel they are.
float firstRed(const std::string& name, const std::string& layer = "") {
    PictureOptions options;
    options.layer = layer;
    return readMap(name, options).image.pixels[0].x;
}

TEST(LightPictures, LayersAreChosenOrListed) {
    const auto rgb = [](const std::string& before, float start) {
        return std::vector<Channel>{channel(before + "R", 32, start), channel(before + "G", 32, start),
                                    channel(before + "B", 32, start)};
    };
    const auto both = [](std::vector<Channel> a, const std::vector<Channel>& b) {
        a.insert(a.end(), b.begin(), b.end());
        return a;
    };
    writeChannels("layer.exr", {8, 4},
                  both(rgb("beauty.", 3),
                       {channel("Z", 32, 9), channel("N.X", 32, 9), channel("N.Y", 32, 9), channel("N.Z", 32, 9)}));
    EXPECT_EQ(firstRed("layer.exr"), 3);
    EXPECT_EQ(firstRed("layer.exr", "beauty"), 3);
    writeChannels("own.exr", {8, 4}, both(rgb("", 1), rgb("diffuse.", 2)));
    EXPECT_EQ(firstRed("own.exr"), 1);
    EXPECT_EQ(firstRed("own.exr", "diffuse"), 2);
    EXPECT_THAT(refusalOf([] { firstRed("own.exr", "glossy"); }),
                testing::AllOf(HasSubstr("no layer 'glossy'"), HasSubstr("diffuse")));
    writeChannels("several.exr", {8, 4}, both(rgb("View.Combined.", 1), rgb("View.Diff.", 2)));
    EXPECT_THAT(refusalOf([] { readMap("several.exr"); }),
                testing::AllOf(HasSubstr("View.Combined"), HasSubstr("View.Diff"), HasSubstr("layer")));
    EXPECT_EQ(firstRed("several.exr", "View.Diff"), 2);
    writeChannels("depth.exr", {8, 4}, {channel("Z", 32, 1), channel("N.X", 32, 1), channel("N.Y", 32, 1)});
    EXPECT_THAT(refusalOf([] { readMap("depth.exr"); }), testing::AllOf(HasSubstr("Z"), HasSubstr("N (X, Y)")));

    writeParts("parts.exr", {{"depth", {channel("Z", 32, 9)}}, {"rgba", rgb("", 4)}});
    EXPECT_EQ(firstRed("parts.exr"), 4);
    writeParts("aovs.exr", {{"beauty", rgb("", 5)}, {"albedo", rgb("", 6)}});
    EXPECT_THAT(refusalOf([] { readMap("aovs.exr"); }), testing::AllOf(HasSubstr("beauty"), HasSubstr("albedo")));
    EXPECT_EQ(firstRed("aovs.exr", "albedo"), 6);
    writeParts("prefixed.exr", {{"V.Combined", rgb("V.Combined.", 7)}, {"V.Depth", {channel("V.Depth.Z", 32, 9)}}});
    EXPECT_EQ(firstRed("prefixed.exr"), 7);
}

// Luminance is grey; with chroma of half the resolution, smooth colours come back.
TEST(LightPictures, LuminanceAndChroma) {
    writeChannels("y.exr", {8, 4}, {channel("Y", 32, 2), channel("A", 32, 1)});
    const EnvironmentMap gray = readMap("y.exr");
    EXPECT_EQ(gray.image.pixels[5], (Vec3{2 + 5 / 16.0f, 2 + 5 / 16.0f, 2 + 5 / 16.0f}));
    EXPECT_EQ(gray.image.alpha.size(), 32u);
    {
        std::vector<Imf::Rgba> pixels;
        for (int i = 0; i < 64 * 32; ++i) pixels.emplace_back(1.5f, 0.5f, 0.25f, 1.0f);
        Imf::RgbaOutputFile file(scratch("yc.exr").c_str(), 64, 32, Imf::WRITE_YC);
        file.setFrameBuffer(pixels.data(), 1, 64);
        file.writePixels(32);
    }
    const Image colors = readMap("yc.exr").image;
    ASSERT_EQ(colors.pixels.size(), 64u * 32);
    for (Vec3 p : colors.pixels)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(p[c], (Vec3{1.5f, 0.5f, 0.25f})[c], 0.02);
}

TEST(LightPictures, ChromaticitiesAreConvertedAfterRingingIsLookedFor) {
    Imf::Header header(8, 4);
    Imf::addChromaticities(header, {{0.713f, 0.293f}, {0.165f, 0.830f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}});
    writeChannels("aces.exr", header, {channel("R", 32, 5), channel("G", 32, 0), channel("B", 32, 0)});
    const EnvironmentMap map = readMap("aces.exr");
    const Vec3d red = *toRec709(kAcesCg) * Vec3d{5, 0, 0};
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(map.image.pixels[0][c], red[c], 1e-5);
    EXPECT_LT(map.image.pixels[0].y, 0);  // a red that Rec.709 cannot show
    EXPECT_EQ(map.negative_pixels, 0u);
    EXPECT_THAT(map.notes.lines, testing::Contains(HasSubstr("acescg")));
    // Suns and pictures of such a light are never negative.
    const LightSuns suns = factorLight(map, {2, FactorMode::kHandOver, 8}, 1);
    for (const SunD& sun : suns.suns) EXPECT_GE(std::min({sun.irradiance.x, sun.irradiance.y, sun.irradiance.z}), 0);
    for (float value : suns.picture.pixels) EXPECT_GE(value, 0);
    // An option that says otherwise is obeyed, and told.
    PictureOptions rec709;
    rec709.colorspace = "srgb-linear";
    const EnvironmentMap as_is = readMap("aces.exr", rec709);
    EXPECT_EQ(as_is.image.pixels[0], (Vec3{5, 0, 0}));
    EXPECT_THAT(as_is.notes.warnings, testing::Contains(HasSubstr("acescg")));
}

// --- Windows ---------------------------------------------------------------------------------------------------------

Imf::Header windows(const Imath::Box2i& display, const Imath::Box2i& data) {
    Imf::Header header;
    header.displayWindow() = display;
    header.dataWindow() = data;
    return header;
}

std::vector<Channel> rgbOf(int pixels) {
    return {channel("R", pixels, 1), channel("G", pixels, 1), channel("B", pixels, 1)};
}

TEST(LightPictures, WindowsAreCutOrFilled) {
    const Imath::Box2i sphere({0, 0}, {31, 15});
    // 1. Cropped: columns 4 .. 11 of rows 2 .. 5.
    writeChannels("crop.exr", windows(sphere, {{4, 2}, {11, 5}}), rgbOf(32));
    EXPECT_THAT(refusalOf([] { readMap("crop.exr"); }),
                testing::AllOf(HasSubstr("8 x 4 at (4, 2)"), HasSubstr("32 x 16"), HasSubstr("fill")));
    PictureOptions fill;
    fill.fill = Vec3{0.5f, 0.25f, 0};
    const EnvironmentMap filled = readMap("crop.exr", fill);
    ASSERT_EQ(filled.image.width, 32);
    EXPECT_EQ(filled.image.pixels[0], *fill.fill);
    EXPECT_EQ(filled.image.pixels[2 * 32 + 4], (Vec3{1, 1, 1}));
    EXPECT_EQ(filled.image.pixels[5 * 32 + 11].x, 1 + 15 / 16.0f);
    EXPECT_EQ(filled.image.pixels[5 * 32 + 12], *fill.fill);
    EXPECT_THAT(filled.notes.lines, testing::Contains(HasSubstr("93.8% of the pixels are filled")));
    // 2. More than the frame has.
    writeChannels("overscan.exr", windows(sphere, {{-1, -1}, {32, 16}}), rgbOf(34 * 18));
    const EnvironmentMap cut = readMap("overscan.exr");
    ASSERT_EQ(cut.image.width, 32);
    EXPECT_EQ(cut.image.pixels[0].x, 1 + (35 % 16) / 16.0f);
    // 3. A whole picture in a frame that has no layout's shape.
    writeChannels("padded.exr", windows({{0, 0}, {31, 19}}, sphere), rgbOf(512));
    EXPECT_EQ(readMap("padded.exr").image.height, 16);
    EXPECT_EQ(readMap("padded.exr", fill).image.height, 16);
    // 4. A photograph has the size of its frame.
    EXPECT_THROW(readImage(scratch("padded.exr")), Unsupported);
    EXPECT_EQ(readImage(scratch("overscan.exr")).height, 16);
    // 5. Nothing of the file is in its frame.
    writeChannels("beside.exr", windows(sphere, {{40, 2}, {47, 5}}), rgbOf(32));
    EXPECT_THAT(readMap("beside.exr", fill).notes.warnings, testing::Contains(HasSubstr("every pixel is filled")));
    EXPECT_THAT(filled.notes.warnings, testing::IsEmpty());
}

// X, Y and Z may be places, too.
TEST(LightPictures, ChannelsOfXyzAreNoColours) {
    std::vector<Channel> channels = rgbOf(32 * 16);
    channels[0].name = "X", channels[1].name = "Y", channels[2].name = "Z";
    writeChannels("xyz.exr", {32, 16}, channels);
    EXPECT_THAT(refusalOf([] { readMap("xyz.exr"); }),
                testing::AllOf(HasSubstr("it holds X, Y, Z. "), HasSubstr("CIE XYZ"), HasSubstr("--colorspace")));
}

// --- Repair ----------------------------------------------------------------------------------------------------------

TEST(LightPictures, RepairTakesTheMeanOfNeighbours) {
    std::vector<Channel> channels = rgbOf(32 * 16);
    const std::vector<float> before = channels[0].values;
    const float nan = std::nanf("");
    channels[0].values[32 * 5 + 7] = nan;
    channels[1].values[32 * 9 + 0] = INFINITY;  // the row continues at its other end, so the neighbours are there
    for (int y = 12; y < 15; ++y)
        for (int x = 20; x < 23; ++x) channels[2].values[std::size_t(32 * y + x)] = nan;
    writeChannels("nan.exr", {32, 16}, channels);
    EXPECT_THAT(refusalOf([] { readMap("nan.exr"); }), testing::AllOf(HasSubstr("(7, 5)"), HasSubstr("repair")));
    PictureOptions repair;
    repair.repair = true;
    const EnvironmentMap map = readMap("nan.exr", repair);
    const auto at = [&](int x, int y) { return before[std::size_t(32 * y + (x + 32) % 32)]; };
    const auto mean = [&](int x, int y) {
        float sum = 0;
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) sum += i == 0 && j == 0 ? 0 : at(x + i, y + j);
        return sum / 8;
    };
    EXPECT_NEAR(map.image.pixels[32 * 5 + 7].x, mean(7, 5), 1e-6);
    EXPECT_NEAR(map.image.pixels[32 * 9].y, mean(0, 9), 1e-6);
    EXPECT_TRUE(std::isfinite(map.image.pixels[32 * 13 + 21].z));
    EXPECT_EQ(map.notes.repaired_pixels, 11u);
    EXPECT_NEAR(map.notes.repaired_share, 11 / 512.0, 1e-12);
    EXPECT_THAT(map.notes.lines, testing::Contains(HasSubstr("11 pixels")));
    for (Channel& one : channels) one.values.assign(512, nan);
    writeChannels("all_nan.exr", {32, 16}, channels);
    EXPECT_THROW(readMap("all_nan.exr", repair), InvalidInput);
}

// --- Damage ----------------------------------------------------------------------------------------------------------

TEST(LightPictures, RejectsEveryTruncation) {
    writeParts("cut.exr", {{"depth", {channel("Z", 32, 9)}},
                           {"rgba", {channel("R", 32, 1), channel("G", 32, 1), channel("B", 32, 1)}}});
    std::ifstream in(scratch("cut.exr"), std::ios::binary);
    const std::string whole((std::istreambuf_iterator<char>(in)), {});
    ASSERT_NO_THROW(decodeImage(std::as_bytes(std::span(whole)), "cut"));
    for (std::size_t n = 0; n < whole.size(); ++n) {
        const std::string cut = whole.substr(0, n);
        EXPECT_THROW(decodeImage(std::as_bytes(std::span(cut)), "cut"), InvalidInput) << "first " << n;
    }
}

}  // namespace
}  // namespace penumbra::test_light_pictures
