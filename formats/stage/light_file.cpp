#include "formats/stage/light_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <span>
#include <string>

#include "formats/common/errors.h"
#include "formats/common/light_picture.h"
#include "formats/common/write_file.h"
#include "formats/stage/stage_parts.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

void writeLobes(hid_t file, int order, const LightLobesFit& lobes) {
    const std::size_t count = lobes.directions.size();
    assert(count <= kMaxFileLobes && lobes.coefficients.size() == count * std::size_t(order) * 3);
    std::vector<double> directions;
    for (Vec3d d : lobes.directions) directions.insert(directions.end(), {d.x, d.y, d.z});
    writeDoubles(file, "/light/lobes/directions", directions, {count, 3});
    writeDoubles(file, "/light/lobes/coefficients", lobes.coefficients, {count, hsize_t(order), 3});
    writeTextAttribute(file, "/light/lobes", "mode", lobes.mode);
    writeNumberAttribute(file, "/light/lobes", "residual", lobes.residual);
    writeNumberAttribute(file, "/light/lobes", "irradiance_error", lobes.irradiance_error);
}

void writeFactor(hid_t file, const LightFile& light) {
    std::vector<double> suns;
    for (const SunD& s : light.suns)
        suns.insert(suns.end(), {s.direction.x, s.direction.y, s.direction.z, s.irradiance.x, s.irradiance.y,
                                 s.irradiance.z, s.radius});
    writeTextAttribute(file, "/light", "factor", light.factor);
    if (!suns.empty()) writeDoubles(file, "/light/suns", suns, {light.suns.size(), 7});
    const LightPicture& picture = light.picture;
    if (picture.width > 0)
        writeFloats(file, "/light/picture", picture.pixels, {hsize_t(picture.height), hsize_t(picture.width), 3});
}

}  // namespace

void writeLight(const std::filesystem::path& path, const LightFile& light) {
    const hsize_t count = hsize_t(coefficientCount(light.order));
    assert(light.sh.size() == count * 3);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kLightFormat, light.order, light.provenance);
    writeTextAttribute(file, "/", "name", light.name);
    writeDoubles(file, "/light/sh", light.sh, {count, 3});
    writeNumberAttribute(file, "/light", "residual", light.residual);
    if (!light.window.empty()) writeDoubles(file, "/light/window", light.window, {hsize_t(light.order)});
    if (!light.lobes.directions.empty()) writeLobes(file, light.order, light.lobes);
    if (!light.factor.empty()) writeFactor(file, light);
    closeHdf5(file);
    partial.commit();
}

namespace {

double readError(const Hdf5Reader& in, const std::string& object, const std::string& attribute) {
    const double value = readNumberAttribute(in, object, attribute);
    if (value < 0) throw InvalidInput(in.name + ": " + object + " " + attribute + ": negative");
    return value;
}

void requireLightNumbers(const Hdf5Reader& in, const char* dataset, std::span<const double> values) {
    for (const double value : values)
        if (std::abs(value) > kMaxLightNumber) {
            char numbers[80];
            std::snprintf(numbers, sizeof numbers, "holds %.3g; at most %.0e is allowed of a light", value,
                          kMaxLightNumber);
            throw InvalidInput(in.name + ": " + dataset + ": " + numbers);
        }
}

LightLobesFit readLobes(const Hdf5Reader& in, int order) {
    const std::string group = "/light/lobes";
    const auto fail = [&](const std::string& what) { throw InvalidInput(in.name + ": " + group + what); };
    LightLobesFit lobes;
    std::vector<hsize_t> shape{0, 3};
    const std::vector<double> directions = readDoubles(in, group + "/directions", shape);
    if (shape[0] < 1 || shape[0] > kMaxFileLobes)
        fail("/directions: 1 to " + std::to_string(kMaxFileLobes) + " lobes, not " + std::to_string(shape[0]));
    for (std::size_t d = 0; d < shape[0]; ++d) {
        lobes.directions.push_back({directions[3 * d], directions[3 * d + 1], directions[3 * d + 2]});
        if (!(std::abs(length(lobes.directions[d]) - 1) < 1e-6))
            fail("/directions: row " + std::to_string(d) + " is not of length 1");
    }
    std::vector<hsize_t> coefficient_shape{shape[0], hsize_t(order), 3};
    lobes.coefficients = readDoubles(in, group + "/coefficients", coefficient_shape);
    requireLightNumbers(in, "/light/lobes/coefficients", lobes.coefficients);
    lobes.mode = readTextAttribute(in, group, "mode");
    if (lobes.mode != "greedy" && lobes.mode != "joint" && lobes.mode != "fixed")
        fail(" mode: \"" + lobes.mode + "\" is not greedy, joint or fixed");
    lobes.residual = readError(in, group, "residual");
    lobes.irradiance_error = readError(in, group, "irradiance_error");
    return lobes;
}

std::vector<SunD> readSuns(const Hdf5Reader& in) {
    std::vector<hsize_t> shape{0, 7};
    const std::vector<double> rows = readDoubles(in, "/light/suns", shape);
    requireLightNumbers(in, "/light/suns", rows);
    const auto fail = [&](const std::string& what) { throw InvalidInput(in.name + ": /light/suns: " + what); };
    if (shape[0] < 1 || shape[0] > kMaxSuns)
        fail("1 to " + std::to_string(kMaxSuns) + " suns, not " + std::to_string(shape[0]));
    std::vector<SunD> suns;
    for (std::size_t i = 0; i < shape[0]; ++i) {
        const double* row = &rows[7 * i];
        const SunD& sun = suns.emplace_back(SunD{{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6]});
        const std::string which = "row " + std::to_string(i);
        if (!(std::abs(length(sun.direction) - 1) < 1e-6)) fail(which + " has a direction that is not of length 1");
        if (!(std::min({row[3], row[4], row[5]}) >= 0)) fail(which + " has a negative irradiance");
        if (!(sun.radius >= 0 && sun.radius < 1.6)) fail(which + " has a radius that is not in [0, 1.6)");
    }
    return suns;
}

LightPicture readPicture(const Hdf5Reader& in) {
    LightPicture picture;
    std::vector<hsize_t> shape{0, 0, 3};
    picture.pixels = readFloats(in, "/light/picture", shape);
    const auto fail = [&](const std::string& what) { throw InvalidInput(in.name + ": /light/picture: " + what); };
    if (shape[1] > kMaxLightPicture || shape[1] < 2 || shape[1] != 2 * shape[0])
        fail("not twice as wide as high, or wider than " + std::to_string(kMaxLightPicture));
    constexpr float kLargestHalf = 65504;
    for (const float value : picture.pixels)
        if (!(value >= 0 && value <= kLargestHalf)) fail("has a number that is not in [0, 65504]");
    picture.width = int(shape[1]), picture.height = int(shape[0]);
    return picture;
}

// Reads the suns and the picture of a factored light. Any of its three parts tells one.
void readFactor(const Hdf5Reader& in, LightFile& light) {
    const bool has_suns = exists(in, "/light/suns"), has_picture = exists(in, "/light/picture");
    if (!has_suns && !has_picture && !hasAttribute(in, "/light", "factor")) return;
    light.factor = readTextAttribute(in, "/light", "factor");
    if (light.factor != "hand-over" && light.factor != "paper" && light.factor != "exact")
        throw InvalidInput(in.name + ": /light factor: \"" + light.factor + "\" is not hand-over, paper or exact");
    if (has_suns) light.suns = readSuns(in);
    if (has_picture) light.picture = readPicture(in);
}

}  // namespace

LightFile readLight(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    LightFile light;
    light.order = readRoot(in, kLightFormat, light.provenance);
    light.name = readTextAttribute(in, "/", "name");
    std::vector<hsize_t> shape{hsize_t(coefficientCount(light.order)), 3};
    light.sh = readDoubles(in, "/light/sh", shape);
    requireLightNumbers(in, "/light/sh", light.sh);
    light.residual = readError(in, "/light", "residual");
    if (exists(in, "/light/window")) {
        std::vector<hsize_t> bands{hsize_t(light.order)};
        light.window = readDoubles(in, "/light/window", bands);
    }
    if (exists(in, "/light/lobes")) light.lobes = readLobes(in, light.order);
    readFactor(in, light);
    return light;
}

}  // namespace penumbra
