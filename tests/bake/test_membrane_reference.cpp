// Tests membranes in reference pictures against the closed form of a flat sheet.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "bake/reference/bake_reference.h"

namespace penumbra::test_membrane_reference {
namespace {

// A square in the plane y = 0 whose front is above, seen from `pitch` degrees.
Vec3 middleOf(const EnvironmentLight& light, double pitch, const Membrane& membrane) {
    Mesh mesh;
    mesh.rest_positions = {{-1, 0, -1}, {-1, 0, 1}, {1, 0, 1}, {1, 0, -1}};
    mesh.rest_positions.insert(mesh.rest_positions.end(), mesh.rest_positions.begin(), mesh.rest_positions.end());
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    mesh.two_sided = true;
    VisibilityFrame frame;
    frame.positions = mesh.rest_positions;
    frame.normals = {{0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, 1, 0}, {0, -1, 0}, {0, -1, 0}, {0, -1, 0}, {0, -1, 0}};
    ReferenceOptions options;
    options.width = options.height = 3;
    options.samples = 16384;
    options.camera_rays = 1;
    options.membranes = {membrane};
    const Camera camera = makeCamera("pitch=" + std::to_string(pitch), frame.positions, 1, 0);
    const Image image = renderReference({mesh, frame, false}, camera, light, options, 2, ProgressStyle::kNone);
    return image.pixels[4];
}

// Under L(s) = 1 + k.s a surface has E/pi = 1 + 2/3 k.n.
TEST(MembraneReference, MixesTheSidesOfAFlatSheet) {
    const Membrane membrane{{0.5f, 0.2f, 0}, {0.3f, 0.6f, 1}};
    const double full = std::sqrt(4 * std::numbers::pi), slope = std::sqrt(4 * std::numbers::pi / 3);
    std::vector<double> sh(12);
    for (std::size_t c = 0; c < 3; ++c) sh[c] = full, sh[3 + c] = -0.6 * slope;  // y(1,-1) = -sqrt(3/4pi) y
    const EnvironmentLight light = EnvironmentLight::fromSh(2, sh);
    for (const double pitch : {60.0, -60.0}) {
        const Vec3 seen = middleOf(light, pitch, membrane);
        const double own = pitch > 0 ? 1.4 : 0.6, other = 2 - own;
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(double(seen[c]), double(membrane.rho[c]) * own + double(membrane.tau[c]) * other, 0.01)
                << pitch << " channel " << c;
    }
}

}  // namespace
}  // namespace penumbra::test_membrane_reference
