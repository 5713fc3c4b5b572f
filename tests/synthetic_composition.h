#pragma once
// Makes the tube of synthetic_model.h a composed model. Every joint has a part, a ball around it, whose field follows
// from a closed form.
#include <algorithm>

#include "sh/far/far_visibility.h"
#include "tests/synthetic_model.h"

namespace penumbra::synthetic {

struct CompositionOptions {
    int local_steps = 1;
    float radius = 0.22f;    // of the balls
    std::int32_t cells = 4;  // points along each axis of a box
    float fade = 0.04f;
    bool residual = true;
};

// V - 1 of a ball as SH over the sphere: a cap of half angle asin(radius / distance) is blocked. From inside it is half
// the sphere, as from the ball's surface.
inline std::vector<float> ballField(Vec3 offset, float radius) {
    const double distance = length(offset);
    const double c = distance > radius ? std::sqrt(1 - radius * radius / (distance * distance)) : 0;
    std::array<double, kFieldOrder + 2> p{1, c};
    for (std::size_t l = 2; l < p.size(); ++l)
        p[l] = (double(2 * l - 1) * c * p[l - 1] - double(l - 1) * p[l - 2]) / double(l);
    std::vector<float> y(kFieldCoefficients), out(kFieldCoefficients);
    evalBasis(kFieldOrder, distance > 0 ? offset * float(-1 / distance) : Vec3{0, 0, -1}, std::span<float>(y));
    for (int l = 0; l < kFieldOrder; ++l) {
        const double integral = l == 0 ? 1 - c : (p[std::size_t(l - 1)] - p[std::size_t(l + 1)]) / (2 * l + 1);
        for (int i = l * l; i < (l + 1) * (l + 1); ++i)
            out[std::size_t(i)] = float(-2 * std::numbers::pi * integral * y[std::size_t(i)]);
    }
    return out;
}

// Adds the field of a ball around `center`.
inline void addBall(PartFields& fields, std::uint32_t joint, Vec3 center, const CompositionOptions& o) {
    PartField part;
    part.joint = joint;
    part.center = center;
    part.radius = o.radius;
    for (int b = 0; b < 2; ++b) {
        const float half = b == 0 ? 1.25f * o.radius : 2.5f * o.radius;
        part.boxes[std::size_t(b)] = {
            center - Vec3{half, half, half}, center + Vec3{half, half, half}, {o.cells, o.cells, o.cells}};
    }
    const std::vector<Vec3> points = fieldPoints(part);
    const std::size_t fine = part.boxes[0].pointCount(), boxes = fine + part.boxes[1].pointCount();
    std::vector<float> values;
    for (Vec3 point : points) {
        const Vec3 offset = point - center;
        const float scale = dot(offset, offset) + 0.25f * o.radius * o.radius;
        for (float x : ballField(offset, o.radius)) values.push_back(scale * x);
    }
    const auto level = [&](std::size_t p) { return std::size_t(p >= fine) + std::size_t(p >= boxes); };
    const auto scaleOf = [&](std::size_t i) -> float& {
        return part.scale[level(i / kFieldCoefficients)][std::size_t(bandOfIndex(int(i % kFieldCoefficients)))];
    };
    for (std::size_t i = 0; i < values.size(); ++i) scaleOf(i) = std::max(scaleOf(i), std::abs(values[i]) / 127);
    std::vector<std::int8_t> bytes, distances;
    for (std::size_t i = 0; i < values.size(); ++i)
        bytes.push_back(scaleOf(i) > 0 ? std::int8_t(std::lround(values[i] / scaleOf(i))) : std::int8_t(0));
    part.distance_scale = o.radius / 64;
    for (std::size_t p = 0; p < fine; ++p)
        distances.push_back(std::int8_t(
            std::clamp(std::lround((length(points[p] - center) - o.radius) / part.distance_scale), -127L, 127L)));
    fields.parts.push_back(part);
    fields.values.push_back(bytes);
    fields.distances.push_back(distances);
}

// The part of a vertex is the joint that moves it most; parts are as far from one another as their joints.
inline void addComposition(Model& model, const TubeOptions& tube, const CompositionOptions& options = {}) {
    Composition composition;
    composition.local_steps = options.local_steps;
    composition.fields.fade = options.fade;
    for (int j = 0; j < tube.joints; ++j)
        addBall(composition.fields, std::uint32_t(j), model.joint_centers[std::size_t(j)], options);
    for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
        composition.part_of_vertex.push_back(
            model.skin.joints[2 * v + std::size_t(model.skin.weights[2 * v + 1] > model.skin.weights[2 * v])]);
    for (int a = 0; a < tube.joints; ++a)
        for (int b = 0; b < tube.joints; ++b) composition.steps.push_back(std::uint8_t(std::abs(a - b)));
    if (options.residual) {
        composition.residual = model.clusters;
        Noise noise(23);
        for (ClusterModel& cluster : composition.residual) {
            for (float& x : cluster.mean) x = 0.02f * noise();
            for (float& x : cluster.basis) x *= 0.4f;
            for (float& x : cluster.weights) x = noise();
        }
    }
    model.composition = composition;
}

// Makes all parts within local_steps of a part its near parts, nearest first, as many as there is room for, with gains
// at random.
inline void addNearParts(Model& model, std::size_t count) {
    Composition& composition = *model.composition;
    const std::size_t parts = composition.fields.parts.size();
    composition.near_count = count;
    composition.near_parts.assign(parts * count, kNoPart);
    for (std::size_t a = 0; a < parts; ++a) {
        std::size_t next = a * count;
        for (int steps = 1; steps <= composition.local_steps; ++steps)
            for (std::size_t b = 0; b < parts && next < (a + 1) * count; ++b)
                if (b != a && composition.steps[a * parts + b] == steps)
                    composition.near_parts[next++] = std::uint16_t(b);
    }
    Noise noise(31);
    for (std::size_t i = 0; i < composition.part_of_vertex.size() * count; ++i)
        composition.near_gains.push_back(std::uint8_t(std::clamp(127 * (1 + noise()), 0.0f, 255.0f)));
}

// Adds a ball that stands still beside a composed model, as an occluder of its bake does. All parts see it.
inline void addStillBall(Model& model, Vec3 center, const CompositionOptions& options = {}) {
    Composition& composition = *model.composition;
    const std::size_t before = composition.fields.parts.size(), after = before + 1;
    addBall(composition.fields, kStillJoint, center, options);
    std::vector<std::uint8_t> steps(after * after, 255);
    for (std::size_t a = 0; a < before; ++a)
        std::copy_n(composition.steps.begin() + std::ptrdiff_t(a * before), before,
                    steps.begin() + std::ptrdiff_t(a * after));
    steps.back() = 0;
    composition.steps = steps;
}

inline Model composedTube(const TubeOptions& tube = {.joints = 5}, const CompositionOptions& options = {}) {
    Model model = tubeModel(tube);
    addComposition(model, tube, options);
    return model;
}

}  // namespace penumbra::synthetic
