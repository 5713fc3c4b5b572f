#pragma once
// A distant light that can be looked up and sampled: a picture at full resolution, SH coefficients, or analytic
// lights.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "bake/reference/light_table.h"
#include "sh/light/analytic_light.h"

namespace penumbra {

class EnvironmentLight {
public:
    // A light of radiance 1 from everywhere.
    static EnvironmentLight white();
    // A light that is constant over each pixel of a picture.
    static EnvironmentLight fromMap(EnvironmentMap map);
    // A band-limited light. sh is [order^2, 3]; its radiance may be negative somewhere.
    static EnvironmentLight fromSh(int order, std::vector<double> sh);
    // A sum of analytic lights. Discs are sampled in their cones, smooth lights by a table of 256 x 128.
    static EnvironmentLight fromAnalytic(std::span<const AnalyticLight> lights);
    // Returns the light's own SH projection in its place, directional lights included. A light of SH is cut to at
    // most `order`. The light must not be turned.
    EnvironmentLight bandLimited(int order) const;
    // Returns the light turned in the model frame: L'(s) = L(R^T s).
    EnvironmentLight turned(const Mat3d& rotation) const;

    Vec3d radiance(Vec3d direction) const;  // in linear RGB; without directional()
    // Draws a direction with a density proportional to |luminance| (of each part of a sum), or none. u, v in [0, 1).
    LightSample sample(double u, double v) const;
    double density(Vec3d direction) const;
    // Lights without extent, which no sample hits. The caller has to sum them one by one.
    std::span<const DirectionalLight> directional() const { return directional_; }

private:
    // One term of the sum: a picture, a smooth light or a disc.
    struct Part {
        std::function<Vec3d(Vec3d)> radiance;
        std::function<std::vector<double>(int order)> project;  // [order^2, 3]
        std::optional<DiscLight> disc;                          // set: sampled in its cone; unset: sampled by the table
        LightTable table;
        double power = 0, chance = 0;  // chance: the part's share of the samples
    };
    void addSmooth(SmoothLight light, const MapShape& shape);
    void addDisc(const DiscLight& disc);
    void shareSamples();
    double ownDensity(Vec3d direction) const;  // density of a direction before turning

    std::vector<Part> parts_;
    std::vector<DirectionalLight> directional_;
    int order_ = 0;  // order of SH; 0: not band limited
    Mat3d rotation_{{1, 0, 0, 0, 1, 0, 0, 0, 1}};
};

// Reads a light. A .h5 file holds a light of penumbra-fit light. Anything else is a picture, which is read as `options`
// say; `notes` becomes what the reader tells of it. Throws IoError, InvalidInput, Unsupported and BadOption.
EnvironmentLight readEnvironmentLight(const std::filesystem::path& path, const PictureOptions& options,
                                      PictureNotes& notes);

}  // namespace penumbra
