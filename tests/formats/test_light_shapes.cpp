// Shapes of pictures of lights: cubes, pictures nearly 2:1, and large ones that are read in bands.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfEnvmap.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "formats/common/errors.h"
#include "formats/image/cube_faces.h"
#include "formats/image/picture_light.h"
#include "tests/difference.h"
#include "tests/formats/stage_samples.h"

namespace penumbra::test_light_shapes {
namespace {

std::filesystem::path scratch(const std::string& name) {
    static const samples::Folder folder("light_shapes");
    return folder.path / name;
}

using Planes = std::array<std::vector<float>, 3>;

void writeFloats(const std::string& name, Imf::Header header, Planes& planes) {
    const Imath::Box2i window = header.dataWindow();
    const std::size_t width = std::size_t(window.max.x + 1);
    Imf::FrameBuffer buffer;
    for (std::size_t c = 0; c < 3; ++c) {
        const char* channel = c == 0 ? "R" : c == 1 ? "G" : "B";
        header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
        buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, planes[c].data(), window, 4, 4 * width));
    }
    Imf::OutputFile file(scratch(name).c_str(), header, 0);
    file.setFrameBuffer(buffer);
    file.writePixels(window.max.y + 1);
}

// --- Cubes, and pictures nearly 2:1 ----------------------------------------------------------------------------------

// A light that no turn or mirror leaves as it is.
Vec3 skyAt(Vec3d d) { return {float(2 + d.x + d.x * d.y), float(2 + d.y), float(2 + d.z + d.x * d.z)}; }

std::vector<double> latLongSh() {
    Image image{256, 128, {}, {}};
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 256; ++x) image.pixels.push_back(skyAt(latLongDirection((x + 0.5) / 256, (y + 0.5) / 128)));
    return projectMap(makeEnvironmentMap(std::move(image), "latlong", "sky"), 4, 1).sh;
}

void expectSameLight(const EnvironmentMap& map, double tolerance) {
    const std::vector<double> expected = latLongSh(), got = projectMap(map, 4, 1).sh;
    Largest worst;
    for (std::size_t i = 0; i < got.size(); ++i) worst.add(std::abs(got[i] - expected[i]));
    EXPECT_LT(worst, tolerance);
}

// OpenEXR's own function says where its faces look; a lat-long's middle is its +Z and ours +x.
TEST(LightShapes, CubesOfOpenExrAreTurnedAsItsLatLongs) {
    constexpr int kSize = 32;
    Planes channels;
    const Imath::Box2i window({0, 0}, {kSize - 1, 6 * kSize - 1});
    for (int y = 0; y < 6 * kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
            const auto face = Imf::CubeMapFace(y / kSize);
            // Their pixels stand on the edges of a face; ours fill it.
            const auto inside = [](double s) { return float((s + 0.5) / kSize * (kSize - 1)); };
            const Imath::V2f at(inside(x), float(y / kSize * kSize) + inside(y % kSize));
            const Imath::Box2i of_face = Imf::CubeMap::dataWindowForFace(face, window);
            // pixelPosition() inverts: find the position in the face that lands on `at`.
            Imath::V2f best, least(1e9f, 0);
            const Imath::V2f relative = at - Imath::V2f(of_face.min);
            for (const Imath::V2f& p :
                 {relative, Imath::V2f(relative.y, relative.x), Imath::V2f(kSize - 1 - relative.x, relative.y),
                  Imath::V2f(relative.x, kSize - 1 - relative.y), Imath::V2f(relative.y, kSize - 1 - relative.x),
                  Imath::V2f(kSize - 1 - relative.y, relative.x),
                  Imath::V2f(kSize - 1 - relative.x, kSize - 1 - relative.y),
                  Imath::V2f(kSize - 1 - relative.y, kSize - 1 - relative.x)}) {
                const float off = (Imf::CubeMap::pixelPosition(face, window, p) - at).length();
                if (off < least.x) least.x = off, best = p;
            }
            const Imath::V3f theirs = Imf::CubeMap::direction(face, window, best).normalized();
            const Vec3 color = skyAt({theirs.z, theirs.y, -theirs.x});
            for (int c = 0; c < 3; ++c) channels[std::size_t(c)].push_back(color[c]);
        }
    Imf::Header header(kSize, 6 * kSize);
    writeFloats("strip.exr", header, channels);
    expectSameLight(readEnvironmentMap(scratch("strip.exr"), {}), 0.01);
    Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
    writeFloats("envmap.exr", header, channels);
    expectSameLight(readEnvironmentMap(scratch("envmap.exr"), {}), 0.01);
    PictureOptions latlong;
    latlong.layout = "latlong";
    EXPECT_THROW(readEnvironmentMap(scratch("envmap.exr"), latlong), InvalidInput);
    Imf::addEnvmap(header, Imf::Envmap(7));
    writeFloats("unknown_envmap.exr", header, channels);
    EXPECT_THROW(readEnvironmentMap(scratch("unknown_envmap.exr"), {}), InvalidInput);
}

TEST(LightShapes, SixFilesAreACross) {
    constexpr int kSize = 32;
    const MapShape cross{MapLayout::kHorizontalCross, 4 * kSize, 3 * kSize};
    const std::array<std::pair<const char*, std::array<int, 2>>, 6> faces = {
        {{"px", {2, 1}}, {"nx", {0, 1}}, {"py", {1, 0}}, {"ny", {1, 2}}, {"pz", {1, 1}}, {"nz", {3, 1}}}};
    std::vector<std::filesystem::path> files;
    for (const auto& [name, cell] : faces) {
        Image face{kSize, kSize, {}, {}};
        for (int y = 0; y < kSize; ++y)
            for (int x = 0; x < kSize; ++x)
                face.pixels.push_back(skyAt(mapDirection(cross, cell[0] * kSize + x + 0.5, cell[1] * kSize + y + 0.5)));
        files.push_back(scratch(std::string("sky_") + name + ".exr"));
        writeExr(files.back(), face);
    }
    std::swap(files[0], files[4]);
    expectSameLight(readEnvironmentMap(files, {}), 0.01);
    PictureOptions cube;
    cube.layout = "cube";
    expectSameLight(readEnvironmentMap(scratch("sky_ny.exr"), cube), 0.01);
    EXPECT_EQ(filesOfPicture(scratch("sky_ny.exr"), cube).size(), 6u);
    EXPECT_EQ(filesOfPicture(scratch("sky_ny.exr"), {}).size(), 1u);
    files[1] = files[2];
    EXPECT_THROW(readEnvironmentMap(files, {}), InvalidInput);  // the same face twice
    files.pop_back();
    EXPECT_THROW(readEnvironmentMap(files, {}), InvalidInput);
    EXPECT_EQ(faceOfName("room_left.hdr"), 1);
    EXPECT_EQ(faceOfName("posz.hdr"), 4);
    EXPECT_FALSE(faceOfName("complex.hdr"));  // x is no px here
}

TEST(LightShapes, OnePixelOffTwoToOneIsLatLong) {
    for (const auto& [width, height] : {std::pair(255, 128), {257, 128}, {256, 127}, {256, 129}}) {
        Image image{width, height, {}, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                image.pixels.push_back(skyAt(latLongDirection((x + 0.5) / width, (y + 0.5) / height)));
        const EnvironmentMap map = makeEnvironmentMap(std::move(image), "", "nearly");
        EXPECT_EQ(map.layout, MapLayout::kLatLong);
        EXPECT_EQ(map.notes.lines.size(), 1u);
        expectSameLight(map, 0.001);
    }
}

// --- Large pictures --------------------------------------------------------------------------------------------------

// Read in bands, a picture has the projection and the flux that it has as a whole, for every shape of its rows.
TEST(PictureLight, BandsAgreeWithTheWholePicture) {
    std::mt19937 random(7);
    std::exponential_distribution<float> radiance(0.2f);
    for (const auto& [width, height] : {std::pair(64, 32), {63, 32}, {66, 33}, {128, 65}}) {
        Image image{width, height, {}, {}};
        for (int i = 0; i < width * height; ++i)
            image.pixels.push_back({radiance(random), radiance(random), radiance(random)});
        image.pixels[std::size_t(width * 7 + 5)] = {9000, 8000, 7000};  // a sun
        writeExr(scratch("large.exr"), image);
        const std::filesystem::path file = scratch("large.exr");
        PictureLightChoice choice;
        choice.large = {0, 16};
        const PictureLight bands = readPictureLight({&file, 1}, {}, choice);
        const PictureLight whole = readPictureLight({&file, 1}, {}, {});
        ASSERT_TRUE(bands.whole) << width << " x " << height;
        ASSERT_FALSE(whole.whole);
        EXPECT_EQ(bands.shape.width, width);
        EXPECT_EQ(bands.map.image.width, 16);
        const MapProjection a = bands.project(6, 1), b = whole.project(6, 1), boxes = projectMap(bands.map, 1, 1);
        const double most = std::abs(b.sh[0]);
        for (std::size_t i = 0; i < b.sh.size(); ++i) EXPECT_NEAR(a.sh[i], b.sh[i], 2e-6 * most) << i;
        EXPECT_NEAR(a.energy, b.energy, 1e-5 * b.energy);
        for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(boxes.sh[c], b.sh[c], 2e-6 * most);
    }
}

// Pictures whose faults need neighbouring pixels are read as a whole.
TEST(PictureLight, LargePicturesWithFaultsAreReadWhole) {
    const std::filesystem::path file = scratch("faults.exr");
    Image image{64, 32, std::vector<Vec3>(64 * 32, Vec3{1, 1, 1}), {}};
    image.pixels[700] = {1, -0.1f, 1};
    writeExr(file, image);
    PictureLightChoice choice;
    choice.large = {0, 16};
    const PictureLight negative = readPictureLight({&file, 1}, {}, choice);
    EXPECT_EQ(negative.map.image.width, 64);
    EXPECT_EQ(negative.map.negative_pixels, 1u);
    // Pixels that ring are mended in the picture and stay in the sum.
    EnvironmentMap file_pixels;
    file_pixels.image = readImage(file);
    const MapProjection expected = projectMap(file_pixels, 4, 1), got = negative.project(4, 1);
    for (std::size_t i = 0; i < expected.sh.size(); ++i) EXPECT_NEAR(got.sh[i], expected.sh[i], 1e-12) << i;
    image.pixels[700].y = std::nanf("");
    writeExr(file, image);
    EXPECT_THROW(readPictureLight({&file, 1}, {}, choice), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_light_shapes
