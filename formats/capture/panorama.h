#pragma once
// A lat-long picture of the light at one place that is being put together from photographs.
#include <vector>

#include "formats/image/image_file.h"
#include "sh/vec3.h"

namespace penumbra {

// Rows and directions as in image_file.h (latLongDirection), in the scene's frame.
struct Panorama {
    int width = 0, height = 0;    // width = 2 height
    std::vector<Vec3> radiance;   // [height, width]
    std::vector<Vec3> uncertain;  // [height, width], the part of the radiance that is only a lower bound
    std::vector<float> seen;      // [height, width], the part of the pixel that a photograph shows, 0..1
    std::vector<float> dark;      // [height, width], the part of it that is too dark in every exposure
};
Panorama makePanorama(int width);
// Returns the solid angle of a pixel of this row, exactly.
double steradiansOfRow(const Panorama& panorama, int row);

// The light that a photograph shows in one direction. `uncertain` and `dark` as above.
struct SeenLight {
    Vec3 radiance, uncertain;
    float dark = 0, weight = 0;  // weight 0: not seen
};

// How z = 0 in the marker's frame continues: as a level ground, or not at all, so that everything counts as far away.
enum class Ground { kLevel, kNone };

struct HoleReport {
    double share = 0;    // part of the sphere that was filled
    double largest = 0;  // part that the largest hole has
    int holes = 0;
};
// Fills pixels of which less than half are seen. A hole of less than 5% of the sphere gets the mean of the seen pixels
// within 20 degrees of its border (measured from its middle). Above a level ground, what lies above the horizon gets
// that of the sky, and what lies below that of the ground. A larger hole gets the mean of all that is seen. Throws
// std::invalid_argument where nothing is seen.
HoleReport fillHoles(Panorama& panorama, Ground ground);

// The light that falls onto a surface with this normal (scene's frame, unit): the integral of L max(0, n.w).
Vec3d irradianceOn(const Panorama& panorama, Vec3d normal);
// The part of that which is only a lower bound.
Vec3d uncertainIrradianceOn(const Panorama& panorama, Vec3d normal);

struct RaiseReport {
    Vec3d wanted, found;            // irradiance of the paper, and of the panorama before
    Vec3d factor{1, 1, 1};          // factor by which clipped pixels were raised
    bool nothing_to_raise = false;  // a channel has too little light, and no clipped pixel to give it to
};
// Multiplies what is only a lower bound so that a surface with this normal gets the irradiance `wanted`. Channels that
// have enough stay as they are.
RaiseReport raiseClipped(Panorama& panorama, Vec3d normal, Vec3d wanted);

}  // namespace penumbra
