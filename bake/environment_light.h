#pragma once
// A distant light that can be looked up and sampled: full-resolution pictures, SH coefficients, analytic lights.
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "bake/light_table.h"
#include "sh/analytic_light.h"

namespace penumbra {

class EnvironmentLight {
public:
    // Radiance 1 from everywhere.
    static EnvironmentLight white();
    // Piecewise constant over the pixels of a picture; fromImage() of a lat-long one.
    static EnvironmentLight fromMap(EnvironmentMap map);
    static EnvironmentLight fromImage(Image image);
    // Band limited: sh is [order^2, 3]; may be negative somewhere.
    static EnvironmentLight fromSh(int order, std::vector<double> sh);
    // Discs are sampled in their cones, smooth lights by a table of 256 x 128.
    static EnvironmentLight fromAnalytic(std::span<const AnalyticLight> lights);
    // The light's own projection put in its place, directional lights too; SH is cut to at most `order`.
    // Of a light that is not turned.
    EnvironmentLight bandLimited(int order) const;
    // Turned in the model frame: L'(s) = L(R^T s).
    EnvironmentLight turned(const Mat3d& rotation) const;

    Vec3d radiance(Vec3d direction) const;  // without directional()
    // A direction with density proportional to |luminance| (of each part of a sum), or none; u, v in [0, 1).
    LightSample sample(double u, double v) const;
    double density(Vec3d direction) const;
    // Deltas, which no sample hits: to be summed one by one.
    std::span<const DirectionalLight> directional() const { return directional_; }

private:
    struct Part {
        std::function<Vec3d(Vec3d)> radiance;
        std::function<std::vector<double>(int order)> project;  // [order^2, 3]
        std::optional<DiscLight> disc;                          // sampled in its cone, else by the table
        LightTable table;
        double power = 0, chance = 0;  // chance: share of the samples
    };
    void addSmooth(SmoothLight light, const MapShape& shape);
    void addDisc(const DiscLight& disc);
    void shareSamples();
    double ownDensity(Vec3d direction) const;  // before turning

    std::vector<Part> parts_;
    std::vector<DirectionalLight> directional_;
    int order_ = 0;  // of SH; 0: not band limited
    Mat3d rotation_{{1, 0, 0, 0, 1, 0, 0, 0, 1}};
};

// .h5 is a light of penumbra-fit light, anything else a picture of this layout ("": by its shape). IoError,
// InvalidInput.
EnvironmentLight readEnvironmentLight(const std::filesystem::path& path, std::string_view layout);

}  // namespace penumbra
