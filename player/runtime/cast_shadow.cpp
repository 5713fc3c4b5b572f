// Casts the parts of characters onto receivers.
//
// Problem: 100 characters of 30 parts stand in a scene, and every receiver asks what all of them hide from it.
//
// Naive: look every part up at every receiver.
//
// Here: receivers go by 64 neighbours at a time. A part whose bounding sphere is too small from everywhere in the
// sphere around them counts nowhere there (heightOf(), sh/far/far_lookup.h), so it is left out, and a whole character
// is left out where its largest part would be. What is left goes through the kernel of composed models.
#include "player/runtime/cast_shadow.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace penumbra {

namespace {

// b after a.
Affine after(const Affine& a, const Affine& b) {
    Affine out;
    const Mat3 linear = b.linear() * a.linear();
    const Vec3 moved = b.point(a.translation());
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) out.m[std::size_t(4 * i + j)] = linear.m[std::size_t(3 * i + j)];
        out.m[std::size_t(4 * i + 3)] = moved[i];
    }
    return out;
}

// Whether a sphere of radius `part` blocks so little of the sphere around a point at `distance` that no part in it can
// count; as heightOf() has it.
bool countsNowhere(float part, float distance, float least) {
    return distance > 0 && part * part < 4 * least * (distance * distance - part * part);
}

struct Sphere {
    Vec3 centre;
    float radius = 0;
};

Sphere sphereAround(std::span<const Vec3> points) {
    Vec3 low = points.front(), high = low;
    for (const Vec3 p : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    Sphere sphere{(low + high) * 0.5f};
    for (const Vec3 p : points) sphere.radius = std::max(sphere.radius, length(p - sphere.centre));
    return sphere;
}

}  // namespace

CastShadow::CastShadow(std::span<const Evaluator* const> casters) {
    for (const Evaluator* evaluator : casters) {
        assert(evaluator->composed());
        const FarTables& tables = evaluator->farTables();
        casters_.push_back(
            {&tables, true, tables_.size(), std::vector<Affine>(evaluator->bones().size()), FarPose(tables), {}, 0, 0});
        tables_.insert(tables_.end(), tables.tables(), tables.tables() + tables.partCount());
        if (tables_.size() > std::numeric_limits<std::uint16_t>::max())
            throw std::length_error("the casters of a scene have more than 65535 parts");
    }
    posed_.resize(tables_.size());
}

void CastShadow::hide(std::size_t caster) { casters_[caster].hidden = true; }

void CastShadow::pose(std::size_t index, std::span<const Affine> bones, const Affine& to_scene) {
    Caster& caster = casters_[index];
    assert(bones.size() == caster.bones.size());
    caster.hidden = false;
    for (std::size_t j = 0; j < bones.size(); ++j) caster.bones[j] = after(bones[j], to_scene);
    caster.pose.set(*caster.tables, caster.bones);
    std::copy(caster.pose.parts.begin(), caster.pose.parts.end(), posed_.begin() + std::ptrdiff_t(caster.first_part));
    caster.centre = {};
    for (const PosedPart& part : caster.pose.posed)
        caster.centre += part.centre * (1 / float(caster.pose.posed.size()));
    caster.radius = caster.largest_part = 0;
    for (const PosedPart& part : caster.pose.posed) {
        caster.radius = std::max(caster.radius, length(part.centre - caster.centre));
        caster.largest_part = std::max(caster.largest_part, part.radius);
    }
}

void CastShadow::findParts(Vec3 centre, float radius, CasterChoice choice,
                           std::pmr::vector<std::uint16_t>& parts) const {
    parts.clear();
    for (std::size_t c = 0; c < casters_.size(); ++c) {
        const Caster& caster = casters_[c];
        if (caster.hidden || !choice.has(c)) continue;
        const float least = caster.tables->constants(FarQuality::kCast).blocked[0];
        const float distance = length(caster.centre - centre) - radius;
        if (countsNowhere(caster.largest_part, distance - caster.radius, least)) continue;
        for (std::size_t p = 0; p < caster.pose.posed.size(); ++p) {
            const PosedPart& part = caster.pose.posed[p];
            if (!countsNowhere(part.radius, length(part.centre - centre) - radius, least))
                parts.push_back(std::uint16_t(caster.first_part + p));
        }
    }
}

std::size_t CastShadow::evaluate(const CastReceivers& receivers, CasterChoice choice, std::span<float> out) const {
    const std::size_t count = receivers.positions.size();
    assert(out.size() == count * kFarNumbers);
    const FarPath& path = fastestFarPath();
    constexpr std::size_t kUsualParts = 2048;
    std::array<std::byte, 2 * sizeof(std::uint16_t) * kUsualParts> room;
    std::pmr::monotonic_buffer_resource memory(room.data(), room.size());
    std::pmr::vector<std::uint16_t> parts(&memory);
    parts.reserve(kUsualParts);
    std::size_t seen = 0;
    for (std::size_t first = 0; first < count; first += kMostReceivers) {
        const std::size_t n = std::min(kMostReceivers, count - first);
        const Sphere sphere = sphereAround(receivers.positions.subspan(first, n));
        findParts(sphere.centre, sphere.radius, choice, parts);
        float* const rows = out.data() + first * kFarNumbers;
        if (parts.empty()) {
            std::fill_n(rows, n * kFarNumbers, 0.0f);
            for (std::size_t r = 0; r < n; ++r) rows[r * kFarNumbers] = 2 * float(std::sqrt(M_PI));
            continue;
        }
        seen += n;
        const FarConstants& constants = casters_.front().tables->constants(FarQuality::kCast);
        const FarScene scene{tables_.data(), posed_.data(), parts.data(), parts.size()};
        path.far(constants, scene, {},
                 {receivers.positions.data() + first, receivers.normals.data() + first,
                  receivers.tangents.data() + first, n},
                 rows);
    }
    return seen;
}

}  // namespace penumbra
