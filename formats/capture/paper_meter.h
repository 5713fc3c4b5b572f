#pragma once
// The white paper around a printed tag as a light meter: a diffuse surface of radiance L and reflectance R receives
// the irradiance E = pi L / R.
#include <cstddef>
#include <span>

#include "formats/capture/posed_picture.h"

namespace penumbra {

// The white margin around a tag is as wide as one of its modules, and its middle is measured.
struct PaperTag {
    double side = 0;  // side of the black square, metres
    int modules = 8;  // modules along its side: 8 for 36h11, 7 for 25h9, 6 for 16h5 and for 4x4_50
};

struct PaperMeasure {
    Vec3d radiance;            // median of the places below; 0 without any
    std::size_t places = 0;    // measured places
    std::size_t clipped = 0;   // places that were clipped in every exposure
    std::size_t pictures = 0;  // pictures that show the paper
    bool found() const { return places > clipped; }
};
// Measures the paper of the tag in the middle of the marker's frame. A picture counts where the margin is at least 3
// pixels wide, and the camera looks at the paper at 15 degrees or more.
PaperMeasure measurePaper(std::span<const PosedPicture> shots, const PaperTag& tag);

constexpr double paperIrradiance(double radiance, double reflectance) {
    return 3.14159265358979323846 * radiance / reflectance;
}

}  // namespace penumbra
