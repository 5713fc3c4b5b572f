#include "player/scene/probe.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "player/papers/folded_light.h"
#include "player/papers/sphere_cast.h"
#include "runtime/cast/ground_shadow.h"
#include "sh/far/far_kernel.h"
#include "sh/far/far_tables.h"
#include "sh/quadrature.h"
#include "sh/sh_basis.h"
#include "sh/tangent.h"

namespace penumbra {

namespace {

constexpr std::string_view kHeader = "x,y,z,nx,ny,nz";

ProbePoint parsePoint(std::string_view line, const std::string& where) {
    std::array<double, 6> numbers;
    const char* at = line.data();
    const char* const end = at + line.size();
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        const auto [next, problem] = std::from_chars(at, end, numbers[i]);
        const bool last = i + 1 == numbers.size();
        if (problem != std::errc() || !std::isfinite(float(numbers[i])) ||
            (last ? next != end : next == end || *next != ','))
            throw InvalidInput(where + ": must be 6 numbers, " + std::string(kHeader));
        at = next + 1;
    }
    const Vec3d normal{numbers[3], numbers[4], numbers[5]};
    const double size = length(normal);
    if (!(size > 1e-6 && size < 1e6)) throw InvalidInput(where + ": the normal has length " + std::to_string(size));
    return {toFloat(Vec3d{numbers[0], numbers[1], numbers[2]}), toFloat(normal * (1 / size))};
}

// Sums over directions above the horizon, in a local frame.
class Integrals {
public:
    // `suns` outlives this object.
    Integrals(const PosedScene& scene, const SceneSuns& suns)
        : directions_(gaussHemisphere(16, 32)), folded_(scene.castWay().mode, scene.light(), scene.lightRotation()) {
        light_ = scene.light();
        if (light_) light_sh_ = suns.suns.empty() ? light_->sh : std::span<const float>(suns.remainder);
        to_light_ = transposed(scene.lightRotation());
        std::vector<double> y(kFieldCoefficients);
        const std::vector<int> even = evenIndices(kFieldOrder);
        for (const WeightedDirection& d : directions_) {
            evalBasis(kFieldOrder, d.direction, y);
            std::array<double, kFarCoefficients>& row = rows_.emplace_back();
            for (std::size_t i = 0; i < row.size(); ++i) row[i] = y[std::size_t(even[i])];
        }
    }

    // From what is visible, mirrored at the point's horizon.
    ProbeValue value(const float* mirrored, const ProbePoint& point, Vec3 tangent) const {
        return integrate(point, tangent, [&](std::size_t d, std::span<const double>) {
            double v = 0;
            for (std::size_t i = 0; i < kFarCoefficients; ++i) v += mirrored[i] * rows_[d][i];
            return v;
        });
    }

    // From V_c over the whole sphere, in the frame of the scene.
    ProbeValue value(std::span<const float> cast, const ProbePoint& point, Vec3 tangent) const {
        ProbeValue out = integrate(point, tangent, [&](std::size_t, std::span<const double> y) {
            double v = 0;
            for (std::size_t i = 0; i < cast.size(); ++i) v += cast[i] * y[i];
            return v;
        });
        out.irradiance = folded_.irradiance(cast, point.normal).value_or(out.irradiance);
        return out;
    }

private:
    std::vector<WeightedDirection> directions_;
    std::vector<std::array<double, kFarCoefficients>> rows_;  // the mirrored functions in each direction
    const LightView* light_ = nullptr;
    std::span<const float> light_sh_;  // without suns that have maps
    Mat3d to_light_;
    FoldedLight folded_;  // only of modes that fold

    // `visible(d, y)` is V in direction d, whose SH in the scene are y.
    ProbeValue integrate(const ProbePoint& point, Vec3 tangent, const auto& visible) const {
        const Vec3d n = toDouble(point.normal), t = toDouble(tangent), b = cross(n, t);
        ProbeValue out;
        out.ambient = 0;
        std::array<double, kProbeOrder * kProbeOrder> y;
        for (std::size_t d = 0; d < directions_.size(); ++d) {
            const Vec3d local = directions_[d].direction, s = t * local.x + b * local.y + n * local.z;
            evalBasis(kProbeOrder, s, y);
            const double weight = directions_[d].weight * visible(d, y);
            out.ambient += weight * local.z / std::numbers::pi;
            for (std::size_t i = 0; i < y.size(); ++i) out.moments[i] += weight * y[i];
            if (light_) out.irradiance += radiance(s) * (weight * local.z);
        }
        return out;
    }

    Vec3d radiance(Vec3d s) const {
        std::vector<double> y(std::size_t(light_->order * light_->order));
        evalBasis(light_->order, to_light_ * s, y);
        Vec3d sum;
        for (std::size_t i = 0; i < y.size(); ++i)
            for (int c = 0; c < 3; ++c) sum[c] += y[i] * light_sh_[3 * i + std::size_t(c)];
        return sum;
    }
};

// The points of one piece of work.
struct ProbeBatch {
    std::array<Vec3, kMaxReceivers> positions, normals, tangents;
    std::array<float, kMaxReceivers * kFarCoefficients> mirrored;
    std::size_t count = 0;

    explicit ProbeBatch(std::span<const ProbePoint> points) : count(points.size()) {
        for (std::size_t i = 0; i < count; ++i) {
            positions[i] = points[i].position;
            normals[i] = points[i].normal;
            tangents[i] = tangentOf(points[i].normal, {1, 0, 0});
        }
    }
    CastReceivers receivers() const {
        return {{positions.data(), count}, {normals.data(), count}, {tangents.data(), count}};
    }
    // Multiplies by what the ground leaves visible.
    void shadowGround(const PosedScene& scene) {
        if (!scene.field() && !scene.groundCasts()) return;
        std::array<float, kMaxReceivers * kFarCoefficients> others;
        const CastReceivers at = receivers();
        if (scene.field())
            scene.field()->visibleFrom(at, others);
        else
            groundVisibility(at.normals, at.tangents, std::span(others).first(count * kFarCoefficients));
        fastestFarPath().compose(productConstants(kFieldOrder), others.data(), nullptr, count, kFarCoefficients,
                                 mirrored.data());
    }
    void evaluate(const CastShadow& cast, CasterChoice choice) {
        cast.evaluate(receivers(), choice, {mirrored.data(), count * kFarCoefficients});
    }
    // Returns E of each point.
    std::vector<float> ambient() const {
        std::array<float, kFarCoefficients> weights;
        ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), weights);
        std::vector<float> e(count);
        for (std::size_t i = 0; i < count; ++i)
            for (std::size_t k = 0; k < kFarCoefficients; ++k) e[i] += weights[k] * mirrored[i * kFarCoefficients + k];
        return e;
    }
};

// The shares of a white sky that are hidden from a point.
struct HiddenAtPoint {
    float by_casters, by_ground;
};

// Returns the irradiance that a point receives from casters and the ground.
Vec3d received(const ProbePoint& point, HiddenAtPoint hidden, std::span<const Emitter> emitters,
               const GroundGlow* ground) {
    Vec3 radiance = meanRadiance(emitters, point.position, point.normal) * std::max(hidden.by_casters, 0.0f);
    if (ground) radiance += ground->radianceAt(point.position, point.normal) * std::max(hidden.by_ground, 0.0f);
    return toDouble(radiance) * std::numbers::pi;
}

void addCasters(const PosedScene& scene, ProbeBatch& batch, std::span<ProbeValue> values) {
    for (std::size_t m = 0; m < scene.members().size(); ++m) {
        if (scene.members()[m]->caster == kNobody) continue;
        batch.evaluate(scene.cast(), {.only = scene.members()[m]->caster});
        const std::vector<float> e = batch.ambient();
        for (std::size_t i = 0; i < batch.count; ++i)
            if (1 - e[i] > kCasterMatters) values[i].casters.push_back(m);
    }
}

void addSuns(const SceneSuns& suns, std::span<const ProbePoint> points, std::span<ProbeValue> values) {
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t s = 0; s < suns.suns.size(); ++s) {
            const Sun& sun = suns.suns[s];
            const float visible = suns.maps[s].visibility(points[i].position, points[i].normal);
            values[i].sun_visibility[s] = visible;
            values[i].irradiance +=
                toDouble(sun.irradiance) * double(visible * std::max(dot(points[i].normal, sun.direction), 0.0f));
        }
}

}  // namespace

std::vector<ProbePoint> parseProbePoints(const std::string& text, const std::string& name) {
    std::vector<ProbePoint> points;
    std::size_t number = 0;
    for (std::size_t begin = 0; begin < text.size(); ++number) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        std::string_view line(text.data() + begin, end - begin);
        if (line.ends_with('\r')) line.remove_suffix(1);
        begin = end + 1;
        const std::string where = name + ", line " + std::to_string(number + 1);
        if (number == 0) {
            if (line != kHeader) throw InvalidInput(where + ": must be " + std::string(kHeader));
        } else if (!line.empty()) {
            points.push_back(parsePoint(line, where));
        }
    }
    if (number == 0) throw InvalidInput(name + ": is empty");
    return points;
}

std::vector<ProbeValue> probe(const PosedScene& scene, std::span<const ProbePoint> given, int threads,
                              const SceneSuns& suns, const SentLight& sent) {
    std::vector<ProbePoint> moved(given.begin(), given.end());
    for (ProbePoint& point : moved) point.position = toFloat(toDouble(point.position) - scene.file().origin);
    const std::span<const ProbePoint> points = moved;
    const Integrals integrals(scene, suns);
    std::vector<Emitter> emitters;
    emittersOf(sent.members, emitters);
    std::vector<ProbeValue> values(points.size());
    parallelFor((points.size() + kMaxReceivers - 1) / kMaxReceivers, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kMaxReceivers, count = std::min(kMaxReceivers, points.size() - first);
        ProbeBatch batch(points.subspan(first, count));
        const std::span<ProbeValue> out = std::span(values).subspan(first, count);
        if (scene.castWay().mode == CastMode::kProduct) {
            batch.evaluate(scene.cast(), {});
            const std::vector<float> past_casters = batch.ambient();
            batch.shadowGround(scene);
            const std::vector<float> past_all = batch.ambient();
            for (std::size_t i = 0; i < count; ++i) {
                out[i] =
                    integrals.value(batch.mirrored.data() + i * kFarCoefficients, points[first + i], batch.tangents[i]);
                out[i].received = received(points[first + i], {1 - past_casters[i], past_casters[i] - past_all[i]},
                                           emitters, sent.ground);
            }
        } else {
            const int order = castOrderOf(scene.castWay().mode);
            const std::size_t row = std::size_t(coefficientCount(order));
            std::vector<float> cast;
            castOverSphere(scene.cast(), {}, order, batch.receivers(), 1, cast);
            for (std::size_t i = 0; i < count; ++i)
                out[i] = integrals.value(std::span(cast).subspan(i * row, row), points[first + i], batch.tangents[i]);
        }
        addCasters(scene, batch, out);
        addSuns(suns, points.subspan(first, count), out);
    });
    return values;
}

namespace {

// RFC 4180.
std::string csvField(const std::string& text) {
    if (text.find_first_of(",\"\n\r") == text.npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
    return quoted + "\"";
}

}  // namespace

std::string probeCsv(const PosedScene& scene, std::span<const ProbePoint> points, std::span<const ProbeValue> values,
                     std::size_t suns) {
    std::string text = std::string(kHeader) + ",E,irradiance_r,irradiance_g,irradiance_b,casters";
    for (int i = 0; i < kProbeOrder * kProbeOrder; ++i) text += ",sh_" + std::to_string(i);
    for (std::size_t s = 0; s < suns; ++s) text += ",sun_visibility_" + std::to_string(s + 1);
    text += ",received_r,received_g,received_b\n";
    std::array<char, 32> buffer;
    const auto add = [&](double x, const char* format) {
        text.append(buffer.data(), std::size_t(std::snprintf(buffer.data(), buffer.size(), format, x)));
    };
    for (std::size_t p = 0; p < points.size(); ++p) {
        for (const Vec3 v : {points[p].position, points[p].normal})
            for (int axis = 0; axis < 3; ++axis) add(v[axis], "%.9g,");
        add(values[p].ambient, "%.6g,");
        for (int c = 0; c < 3; ++c) add(values[p].irradiance[c], "%.6g,");
        std::string casters;
        for (const std::size_t m : values[p].casters)
            casters += (casters.empty() ? "" : ";") + scene.members()[m]->file->name;
        text += csvField(casters);
        for (const double m : values[p].moments) add(m, ",%.6g");
        for (std::size_t s = 0; s < suns; ++s) add(double(values[p].sun_visibility[s]), ",%.6g");
        for (int c = 0; c < 3; ++c) add(values[p].received[c], ",%.6g");
        text += '\n';
    }
    return text;
}

}  // namespace penumbra
