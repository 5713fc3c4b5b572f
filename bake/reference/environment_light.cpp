#include "bake/reference/environment_light.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/image/project_map.h"
#include "formats/stage/light_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

double luminance(Vec3d rgb) { return std::abs(0.2126 * rgb.x + 0.7152 * rgb.y + 0.0722 * rgb.z); }

}  // namespace

// Gives each part the share of the samples that it has of the power.
void EnvironmentLight::shareSamples() {
    double whole = 0;
    for (const Part& part : parts_) whole += part.power;
    for (Part& part : parts_) part.chance = whole > 0 ? part.power / whole : 1.0 / double(parts_.size());
}

void EnvironmentLight::addSmooth(SmoothLight light, const MapShape& shape) {
    std::vector<double> power;
    for (int y = 0; y < shape.height; ++y)
        for (int x = 0; x < shape.width; ++x) {
            const Vec3d direction = mapDirection(shape, x + 0.5, y + 0.5);
            power.push_back(dot(direction, direction) > 0 ? luminance(light.radiance(direction)) : 0);
        }
    Part part{std::move(light.radiance), std::move(light.project), {}, makeLightTable(shape, power), 0, 0};
    part.power = part.table.power;
    parts_.push_back(std::move(part));
}

void EnvironmentLight::addDisc(const DiscLight& disc) {
    Part part;
    part.radiance = [disc](Vec3d d) { return disc.covers(d) ? disc.radiance : Vec3d{}; };
    part.project = [disc](int order) { return projectLights({{}, {disc}, {}}, order); };
    part.disc = disc;
    part.power = luminance(disc.radiance) * disc.solidAngle();
    parts_.push_back(std::move(part));
}

EnvironmentLight EnvironmentLight::white() { return fromAnalytic(parseLights("uniform")); }

EnvironmentLight EnvironmentLight::fromMap(EnvironmentMap picture) {
    EnvironmentLight light;
    const auto map = std::make_shared<const EnvironmentMap>(std::move(picture));
    const auto pixel = [map](MapPixel at) {
        return toDouble(map->image.pixels[std::size_t(at.y) * std::size_t(map->image.width) + std::size_t(at.x)]);
    };
    std::vector<double> power;
    for (Vec3 p : map->image.pixels) power.push_back(luminance(toDouble(p)));
    Part part{[map, pixel](Vec3d d) { return pixel(mapPixel(map->shape(), d)); },
              [map](int order) { return projectMap(*map, order, 0).sh; },
              {},
              makeLightTable(map->shape(), power),
              0,
              1};
    part.power = part.table.power;
    light.parts_.push_back(std::move(part));
    return light;
}

EnvironmentLight EnvironmentLight::fromSh(int order, std::vector<double> sh) {
    assert(sh.size() == 3 * std::size_t(coefficientCount(order)));
    EnvironmentLight light;
    light.order_ = order;
    const auto radiance = [order, sh](Vec3d direction) {
        double basis[coefficientCount(kMaxOrder)];
        const auto count = std::size_t(coefficientCount(order));
        evalBasis(order, direction, std::span(basis, count));
        Vec3d sum;
        for (std::size_t i = 0; i < count; ++i) sum += Vec3d{sh[3 * i], sh[3 * i + 1], sh[3 * i + 2]} * basis[i];
        return sum;
    };
    const auto project = [sh](int asked) {
        return std::vector<double>(sh.begin(), sh.begin() + 3 * coefficientCount(asked));
    };
    light.addSmooth({radiance, project, false}, {MapLayout::kLatLong, 128, 64});
    light.shareSamples();
    return light;
}

EnvironmentLight EnvironmentLight::fromAnalytic(std::span<const AnalyticLight> lights) {
    EnvironmentLight light;
    LightParts parts = partsOf(lights);
    for (SmoothLight& smooth : parts.smooth) {
        const int rows = smooth.constant ? 1 : 128;  // with one pixel, all draws of a set are stratified together
        light.addSmooth(std::move(smooth), {MapLayout::kLatLong, rows > 1 ? 2 * rows : 1, rows});
    }
    for (const DiscLight& disc : parts.discs) light.addDisc(disc);
    light.directional_ = std::move(parts.directional);
    light.shareSamples();
    return light;
}

EnvironmentLight EnvironmentLight::bandLimited(int order) const {
    const int kept = order_ > 0 ? std::min(order, order_) : order;
    std::vector<double> sum = projectLights({directional_, {}, {}}, kept);
    for (const Part& part : parts_) {
        const std::vector<double> sh = part.project(kept);
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += sh[i];
    }
    return fromSh(kept, std::move(sum));
}

EnvironmentLight EnvironmentLight::turned(const Mat3d& rotation) const {
    EnvironmentLight light = *this;
    light.rotation_ = rotation * rotation_;
    for (DirectionalLight& delta : light.directional_) delta.direction = rotation * delta.direction;
    return light;
}

Vec3d EnvironmentLight::radiance(Vec3d direction) const {
    const Vec3d own = transposed(rotation_) * direction;
    Vec3d sum;
    for (const Part& part : parts_) sum += part.radiance(own);
    return sum;
}

namespace {

// Draws uniformly over the cone around the disc's axis. For that, 1 - cos must be uniform.
LightSample sampleDisc(const DiscLight& disc, double u, double v) {
    const double solid_angle = disc.solidAngle(), rise = u * solid_angle / (2 * std::numbers::pi), cosine = 1 - rise,
                 sine = std::sqrt(rise * (2 - rise)), q = 2 * std::numbers::pi * v;
    const Vec3d side = normalized(
                    cross(disc.direction, std::abs(disc.direction.x) < 0.6 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0})),
                other = cross(disc.direction, side);
    return {disc.direction * cosine + (side * std::cos(q) + other * std::sin(q)) * sine, 1 / solid_angle};
}

}  // namespace

LightSample EnvironmentLight::sample(double u, double v) const {
    // u first chooses a part, and what is left of u is again uniform in [0, 1).
    double before = 0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        const Part& part = parts_[i];
        if (i + 1 < parts_.size() && u >= before + part.chance) {
            before += part.chance;
            continue;
        }
        const double left = part.chance > 0 ? std::clamp((u - before) / part.chance, 0.0, 1.0) : 0;
        LightSample found = part.disc ? sampleDisc(*part.disc, left, v) : sampleTable(part.table, left, v);
        if (parts_.size() > 1 && found.density > 0) found.density = ownDensity(found.direction);
        found.direction = rotation_ * found.direction;
        return found;
    }
    return {};
}

double EnvironmentLight::density(Vec3d direction) const { return ownDensity(transposed(rotation_) * direction); }

double EnvironmentLight::ownDensity(Vec3d direction) const {
    double sum = 0;
    for (const Part& part : parts_) {
        if (part.disc)
            sum += part.disc->covers(direction) ? part.chance / part.disc->solidAngle() : 0;
        else
            sum += part.chance * densityOf(part.table, direction);
    }
    return sum;
}

EnvironmentLight readEnvironmentLight(const std::filesystem::path& path, const PictureOptions& options,
                                      PictureNotes& notes) {
    if (path.extension() != ".h5") {
        EnvironmentMap map = readEnvironmentMap(path, options);
        notes = std::move(map.notes);
        return EnvironmentLight::fromMap(std::move(map));
    }
    if (const char* given = givenOption(options)) throw BadOption(given, "is for pictures, not for " + path.string());
    const LightFile file = readLight(path);
    return EnvironmentLight::fromSh(file.order, file.sh);
}

}  // namespace penumbra
