#pragma once
// A distant light that can be looked up and sampled: a full-resolution lat-long picture, or SH coefficients.
#include <filesystem>
#include <vector>

#include "formats/image_file.h"

namespace penumbra {

struct LightSample {
    Vec3d direction;
    double density = 0;  // per steradian
};

class EnvironmentLight {
public:
    // Radiance 1 from everywhere.
    static EnvironmentLight white();
    // Piecewise constant over the pixels of a lat-long picture.
    static EnvironmentLight fromImage(Image image);
    // Band limited: sh is [order^2, 3]; may be negative somewhere.
    static EnvironmentLight fromSh(int order, std::vector<double> sh);
    // The picture's own projection, with exact solid angles, put in its place; SH is cut to at most `order`.
    EnvironmentLight bandLimited(int order) const;

    Vec3d radiance(Vec3d direction) const;
    // A direction with density proportional to |luminance|; u, v in [0, 1).
    LightSample sample(double u, double v) const;
    double density(Vec3d direction) const;

private:
    void makeTable(const std::vector<double>& luminance);

    Image image_;  // pixels empty for SH
    int order_ = 0;
    std::vector<double> sh_;  // [order^2, 3]
    int width_ = 0, height_ = 0;
    std::vector<double> cumulative_;  // [height * width + 1]: power of all pixels before, row by row; the last is 1
};

// .h5 is a light of penumbra-fit light, anything else a lat-long picture. IoError, InvalidInput.
EnvironmentLight readEnvironmentLight(const std::filesystem::path& path);

}  // namespace penumbra
