#pragma once
#include <vector>

#include "formats/asset/asset_file.h"

namespace penumbra {

// A Lambertian material with the numbers that the shading kernel reads.
struct LambertMaterial {
    std::vector<float> slices;
    MaterialView view;
    explicit LambertMaterial(Vec3 albedo);
    LambertMaterial(const LambertMaterial&) = delete;  // the view points to the slices
};

}  // namespace penumbra
