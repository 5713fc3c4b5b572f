#include <gtest/gtest.h>

#include <cmath>

#include "bake/reference/bake_reference.h"
#include "bake/reference/direct_light.h"
#include "sh/quadrature.h"
#include "tests/bake/shapes.h"

namespace penumbra::test_direct_light {

namespace {

using shapes::Shape;

// A sun of 9 pixels over a dim blue gradient.
Image sunAndSky() {
    Image image{64, 32, std::vector<Vec3>(64 * 32), {}};
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x) image.pixels[std::size_t(64 * y + x)] = Vec3{0.1f, 0.2f, 0.4f} * (1 + y / 16.0f);
    for (int y = 6; y < 9; ++y)
        for (int x = 20; x < 23; ++x) image.pixels[std::size_t(64 * y + x)] = {100, 90, 70};
    return image;
}

EnvironmentLight lightOf(Image lat_long) {
    return EnvironmentLight::fromMap({MapLayout::kLatLong, std::move(lat_long), 0, 0, {}});
}

}  // namespace

// --- Light ----------------------------------------------------------------------------------------------------------

TEST(EnvironmentLight, DensityIntegratesToOneAndFollowsLuminance) {
    for (const EnvironmentLight& light :
         {EnvironmentLight::white(), lightOf(sunAndSky()), lightOf(sunAndSky()).bandLimited(4)}) {
        double sum = 0;
        for (const WeightedDirection& d : gaussSphere(256, 512)) sum += d.weight * light.density(d.direction);
        EXPECT_NEAR(sum, 1, 0.01);  // the quadrature sees pixel edges: measured 2e-3
    }
}

TEST(EnvironmentLight, SamplesAgreeWithDensityAndRadiance) {
    // The mean of radiance / density over samples is the integral of radiance, exactly so where the light is grey.
    const EnvironmentLight light = lightOf(sunAndSky());
    Vec3d exact, estimate;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 64; ++x)
            exact += toDouble(sunAndSky().pixels[std::size_t(64 * y + x)]) *
                     (2 * std::numbers::pi / 64 *
                      (std::cos(std::numbers::pi * y / 32) - std::cos(std::numbers::pi * (y + 1) / 32)));
    for (int i = 0; i < 256; ++i)
        for (int j = 0; j < 256; ++j) {
            const LightSample s = light.sample((i + 0.5) / 256, (j + 0.5) / 256);
            EXPECT_NEAR(s.density, light.density(s.direction), 1e-9 * s.density);
            estimate += light.radiance(s.direction) / (s.density * 65536);
        }
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(estimate[c] / exact[c], 1, 0.02);
}

TEST(EnvironmentLight, WhiteStaysWhiteWhenBandLimited) {
    const EnvironmentLight light = EnvironmentLight::white().bandLimited(5);
    for (const Vec3d& d : fibonacciSphere(50)) EXPECT_NEAR(light.radiance(d).x, 1, 2e-4);
}

TEST(EnvironmentLight, CuttingShIsTheSameAsProjectingLess) {
    const EnvironmentLight image = lightOf(sunAndSky());
    const EnvironmentLight cut = image.bandLimited(6).bandLimited(3), direct = image.bandLimited(3);
    for (const Vec3d& d : fibonacciSphere(20)) EXPECT_EQ(cut.radiance(d), direct.radiance(d));
}

// A clamped cosine about +y is the picture. Band-limited to order 8 it is the sum of its zonal harmonics.
TEST(EnvironmentLight, BandLimitedCosineMatchesItsZonalSeries) {
    Image image{256, 128, {}, {}};
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 256; ++x) {
            const float cosine = float(std::max(0.0, std::cos(std::numbers::pi * (y + 0.5) / 128)));
            image.pixels.push_back({cosine, cosine, cosine});
        }
    const EnvironmentLight light = lightOf(image).bandLimited(3);
    // 1/4 + cos/2 + 5/16 (3 cos^2 - 1) / 2: bands 0, 1, 2 of max(0, cos).
    for (const Vec3d& d : fibonacciSphere(50))
        EXPECT_NEAR(light.radiance(d).x, 0.25 + 0.5 * d.y + 5.0 / 32 * (3 * d.y * d.y - 1), 3e-4);
}

// --- Shading --------------------------------------------------------------------------------------------------------

namespace {

const Shape kFarAway = shapes::sphere({100, 0, 0}, 0.01, 4);

SurfacePoint pointFacing(Vec3d normal, Vec3d to_eye) { return {{0, 0, 0}, shadingFrame(normal), to_eye}; }

}  // namespace

TEST(ShadingFrame, IsRightHandedWithTheNormalAsItsThirdRow) {
    for (const Vec3d& n : fibonacciSphere(40)) {
        const Mat3d frame = shadingFrame(n);
        const Mat3d unit = frame * transposed(frame);
        for (int i = 0; i < 9; ++i) EXPECT_NEAR(unit.m[std::size_t(i)], i % 4 == 0, 1e-12);
        EXPECT_NEAR(length(frame * n - Vec3d{0, 0, 1}), 0, 1e-12);
        EXPECT_NEAR(
            dot(cross(Vec3d{frame(0, 0), frame(0, 1), frame(0, 2)}, {frame(1, 0), frame(1, 1), frame(1, 2)}), n), 1,
            1e-12);
    }
}

TEST(DirectLight, WhiteFurnaceShowsLambertAsItsColour) {
    const OcclusionScene scene(kFarAway.positions, kFarAway.triangles);
    const SampledBrdf brdf = sampledBrdf(rgbBrdf(parseBrdf("lambert:color=0.2/0.5/0.8")));
    const Vec3d l =
        directLight({scene, false}, pointFacing({0.6, 0, 0.8}, {0, 0, 1}), EnvironmentLight::white(), brdf, 1024, 1);
    EXPECT_NEAR(l.x, 0.2, 0.002);
    EXPECT_NEAR(l.y, 0.5, 0.005);
    EXPECT_NEAR(l.z, 0.8, 0.008);
}

namespace {

// Integrates over directions by quadrature. Half of the sphere is hidden.
Vec3d lightBesideWall(const SurfacePoint& point, const EnvironmentLight& light, const RgbBrdf& brdf) {
    Vec3d sum;
    const int width = 512, height = 256;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Vec3d d = latLongDirection((x + 0.5) / width, (y + 0.5) / height);
            const Vec3d wi = point.frame * d;
            if (d.x < 0 || wi.z <= 0) continue;
            const double solid_angle =
                2 * std::numbers::pi / width *
                (std::cos(std::numbers::pi * y / height) - std::cos(std::numbers::pi * (y + 1) / height));
            sum += light.radiance(d) * brdf.eval(wi, viewDirection(point)) * (wi.z * solid_angle);
        }
    return sum;
}

}  // namespace

// Tests every BRDF under a sun and under the sun's SH, with 65536 samples. Measured errors are below 0.5%.
TEST(DirectLight, MatchesQuadratureForEveryBrdf) {
    const Shape wall = shapes::square({-0.5, 0, 0}, {1, 0, 0}, 1000);
    const OcclusionScene scene(wall.positions, wall.triangles);
    const EnvironmentLight sun = lightOf(sunAndSky());
    const Vec3d normal = normalized(Vec3d{0.2, 0.9, -0.3}), to_eye = normalized(Vec3d{0.5, 0.5, 0.6});
    const SurfacePoint point = pointFacing(normal, to_eye);
    for (const EnvironmentLight& light : {sun, sun.bandLimited(4)})
        for (const std::string& name : brdfNames()) {
            const SampledBrdf brdf = sampledBrdf(rgbBrdf(parseBrdf(name)));
            const Vec3d exact = lightBesideWall(point, light, brdf.brdf);
            const Vec3d l = directLight({scene, false}, point, light, brdf, 1 << 16, 7);
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(l[c] / exact[c], 1, 0.01) << name << " channel " << c;
        }
}

TEST(AmbientVisibility, IsHalfBesideAWallAndOverGround) {
    const Shape wall = shapes::square({-0.5, 0, 0}, {1, 0, 0}, 1000);
    const OcclusionScene scene(wall.positions, wall.triangles), open(kFarAway.positions, kFarAway.triangles);
    EXPECT_NEAR(ambientVisibility({scene, false}, pointFacing({0, 0, 1}, {0, 0, 1}), 4096, 1), 0.5, 0.005);
    EXPECT_NEAR(ambientVisibility({open, true}, pointFacing({0, 0, 1}, {0, 0, 1}), 4096, 1), 0.5, 0.005);
    EXPECT_EQ(ambientVisibility({open, true}, pointFacing({0, -1, 0}, {0, 0, 1}), 64, 1), 0);
    EXPECT_EQ(ambientVisibility({open, false}, pointFacing({0, -1, 0}, {0, 0, 1}), 64, 1), 1);
}

// --- Pictures -------------------------------------------------------------------------------------------------------

namespace {

struct BallPicture {
    Mesh mesh;
    VisibilityFrame frame;
    Camera camera;

    explicit BallPicture(int rings) {
        const Shape ball = shapes::sphere({1, 2, 3}, 1, rings);
        mesh.triangles = ball.triangles;
        mesh.rest_positions = frame.positions = ball.positions;
        for (Vec3 p : ball.positions) frame.normals.push_back(p - Vec3{1, 2, 3});
        camera = makeCamera("", frame.positions, 1);
    }
    Image render(ReferenceOptions options, const EnvironmentLight& light, int threads = 2) const {
        options.width = options.height = 48;
        return renderReference({mesh, frame, false}, camera, light, options, threads, ProgressStyle::kNone);
    }
};

}  // namespace

// A coarse ball lies in a white furnace. Every covered pixel is 1 up to the silhouette, as facets cast no shadow on
// themselves.
TEST(Reference, BallInWhiteFurnaceIsWhite) {
    const BallPicture ball(16);
    for (const ReferenceChannel channel : {ReferenceChannel::kShaded, ReferenceChannel::kAmbient}) {
        const Image image =
            ball.render({.channel = channel, .samples = 256, .camera_rays = 1}, EnvironmentLight::white());
        double covered = 0;
        for (std::size_t i = 0; i < image.pixels.size(); ++i) {
            covered += image.alpha[i];
            EXPECT_NEAR(image.pixels[i].x, image.alpha[i], 0.02) << "pixel " << i % 48 << ' ' << i / 48;
        }
        // The ball fills the frame: it covers a disc of pi/4 of the picture, less what 32 facets around it cut off.
        EXPECT_NEAR(covered / (48 * 48), std::numbers::pi / 4, 0.03);
    }
}

TEST(Reference, NormalsPointAtTheCameraInTheMiddle) {
    const Image image =
        BallPicture(64).render({.channel = ReferenceChannel::kNormals, .camera_rays = 1}, EnvironmentLight::white());
    const Vec3 middle = image.pixels[24 * 48 + 24], left = image.pixels[24 * 48 + 2], top = image.pixels[2 * 48 + 24];
    EXPECT_NEAR(middle.z, 1, 0.01);
    EXPECT_LT(left.x, 0.2);
    EXPECT_GT(top.y, 0.8);
}

// A light from +x lights only the right side of the picture, since yaw 0 looks along -z.
TEST(Reference, LightComesFromWhereItIs) {
    Image image{2, 1, {{0, 0, 0}, {0, 0, 0}}, {}};
    image.width = 8;
    image.height = 4;
    image.pixels.assign(32, {});
    for (int y = 1; y < 3; ++y) image.pixels[std::size_t(8 * y + 3)] = image.pixels[std::size_t(8 * y + 4)] = {1, 1, 1};
    const Image picture = BallPicture(32).render({.samples = 64}, lightOf(image));
    EXPECT_GT(picture.pixels[24 * 48 + 44].x, 10 * picture.pixels[24 * 48 + 10].x + 0.1f);
}

TEST(Reference, SamePixelsForAnyThreadCount) {
    const BallPicture ball(8);
    const EnvironmentLight light = lightOf(sunAndSky());
    const Image one = ball.render({.samples = 16}, light, 1);
    for (const int threads : {2, 8}) EXPECT_EQ(ball.render({.samples = 16}, light, threads).pixels, one.pixels);
}

TEST(Reference, BackgroundFillsWhatIsNotCovered) {
    const Image image =
        BallPicture(8).render({.camera_rays = 1, .background = Vec3{0, 0, 2}}, EnvironmentLight::white());
    EXPECT_EQ(image.pixels[0], (Vec3{0, 0, 2}));
    EXPECT_EQ(image.alpha[0], 1);
}

}  // namespace penumbra::test_direct_light
