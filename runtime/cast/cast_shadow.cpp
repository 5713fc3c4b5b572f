// Casts the parts of characters onto receivers.
//
// Problem: 100 characters of 30 parts stand in a scene, and every receiver asks what all of them hide from it.
//
// Naive: look every part up at every receiver.
//
// Here: receivers go by 64 neighbours at a time. A part whose bounding sphere is too small from everywhere in the
// sphere around them counts nowhere there (heightOf(), sh/far/far_lookup.h), so it is left out, and a whole character
// is left out where its largest part would be. What is left goes through the kernel of composed models, and spheres
// through that of sh/cast/.
#include "runtime/cast/cast_shadow.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "sh/far/far_tables.h"

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

void leaveFree(std::span<float> rows) {
    std::ranges::fill(rows, 0.0f);
    for (std::size_t first = 0; first < rows.size(); first += kFarCoefficients)
        rows[first] = 2 * float(std::sqrt(std::numbers::pi));
}

}  // namespace

CasterSphere sphereAround(std::span<const Vec3> points) {
    Vec3 low = points.front(), high = low;
    for (const Vec3 p : points)
        for (int axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], p[axis]);
            high[axis] = std::max(high[axis], p[axis]);
        }
    CasterSphere sphere{(low + high) * 0.5f, 0};
    for (const Vec3 p : points) sphere.radius = std::max(sphere.radius, length(p - sphere.center));
    return sphere;
}

std::optional<CasterKind> casterKindOf(const Evaluator& evaluator) {
    if (evaluator.composed()) return CasterKind::kFields;
    if (!evaluator.asset().blockers.spheres.empty()) return CasterKind::kSpheres;
    return std::nullopt;
}

CastShadow::CastShadow(std::span<const Evaluator* const> casters, std::span<const CasterKind> kinds) {
    assert(kinds.empty() || kinds.size() == casters.size());
    std::size_t spheres = 0;
    for (std::size_t c = 0; c < casters.size(); ++c) {
        const Evaluator& evaluator = *casters[c];
        const CasterKind kind = kinds.empty() ? casterKindOf(evaluator).value() : kinds[c];
        const std::size_t bones = evaluator.bones().size();
        if (kind == CasterKind::kSpheres) {
            const BlockersView& blockers = evaluator.asset().blockers;
            casters_.push_back({nullptr, true, spheres, std::vector<Affine>(bones), FarPose(), blockers});
            spheres += blockers.spheres.size();
        } else {
            assert(evaluator.composed());
            const FarTables& tables = evaluator.farTables();
            constants_ = &tables.constants(FarQuality::kCast);
            casters_.push_back({&tables, true, tables_.size(), std::vector<Affine>(bones), FarPose(tables)});
            tables_.insert(tables_.end(), tables.tables(), tables.tables() + tables.partCount());
        }
        if (std::max(tables_.size(), spheres) > std::numeric_limits<std::uint16_t>::max())
            throw std::length_error("the casters of a scene have more than 65535 parts or spheres");
    }
    posed_.resize(tables_.size());
    spheres_.resize(spheres);
    ambientWeights(parseConvention("D" + std::to_string(kFieldOrder)), ambient_weights_);
    for (const float w : ambient_weights_) ambient_norm2_ += w * w;
}

void CastShadow::hide(std::size_t caster) { casters_[caster].hidden = true; }

float CastShadow::smallestCaster() const {
    float least = std::numeric_limits<float>::infinity();
    for (const Caster& caster : casters_)
        if (!caster.hidden) least = std::min(least, caster.largest_part);
    return least;
}

bool CastShadow::castsFields(CasterChoice choice) const {
    for (std::size_t c = 0; c < casters_.size(); ++c)
        if (!casters_[c].hidden && choice.has(c) && casters_[c].tables) return true;
    return false;
}

std::vector<CasterSphere> CastShadow::spheresOf(CasterChoice choice) const {
    std::vector<CasterSphere> out;
    for (std::size_t c = 0; c < casters_.size(); ++c) {
        if (casters_[c].hidden || !choice.has(c)) continue;
        const auto first = spheres_.begin() + std::ptrdiff_t(casters_[c].tables ? 0 : casters_[c].first_part);
        out.insert(out.end(), first, first + std::ptrdiff_t(casters_[c].blockers.spheres.size()));
    }
    return out;
}

// `sphereOf` returns the bounding sphere of each of the parts.
void CastShadow::bound(Caster& caster, std::size_t parts, const auto& sphereOf) {
    caster.center = {};
    for (std::size_t p = 0; p < parts; ++p) caster.center += sphereOf(p).center * (1 / float(parts));
    caster.radius = caster.largest_part = 0;
    for (std::size_t p = 0; p < parts; ++p) {
        const CasterSphere part = sphereOf(p);
        caster.radius = std::max(caster.radius, length(part.center - caster.center));
        caster.largest_part = std::max(caster.largest_part, part.radius);
    }
}

void CastShadow::poseSpheres(Caster& caster) {
    const BlockersView& blockers = caster.blockers;
    CasterSphere* const posed = spheres_.data() + caster.first_part;
    for (std::size_t s = 0; s < blockers.spheres.size(); ++s)
        posed[s] = movedBy(caster.bones[blockers.joints[s]], blockers.spheres[s]);
    bound(caster, blockers.spheres.size(), [&](std::size_t s) { return posed[s]; });
}

void CastShadow::pose(std::size_t index, std::span<const Affine> bones, const Affine& to_scene) {
    Caster& caster = casters_[index];
    assert(bones.size() == caster.bones.size());
    caster.hidden = false;
    for (std::size_t j = 0; j < bones.size(); ++j) caster.bones[j] = after(bones[j], to_scene);
    if (!caster.tables) return poseSpheres(caster);
    caster.pose.set(*caster.tables, caster.bones, to_scene);
    std::copy(caster.pose.parts.begin(), caster.pose.parts.end(), posed_.begin() + std::ptrdiff_t(caster.first_part));
    bound(caster, caster.pose.posed.size(), [&](std::size_t p) {
        return CasterSphere{caster.pose.posed[p].center, caster.pose.posed[p].radius};
    });
}

float CastShadow::leastOf(const Caster& caster) const {
    return caster.tables ? constants_->blocked[0] : kSphereFade.least;
}

bool CastShadow::reaches(std::size_t index, const CasterSphere& points) const {
    const Caster& caster = casters_[index];
    const float distance = length(caster.center - points.center) - points.radius - caster.radius;
    return !caster.hidden && !countsNowhere(caster.largest_part, distance, leastOf(caster));
}

void CastShadow::findParts(const CasterSphere& points, CasterChoice choice, Found& found) const {
    found.parts.clear();
    found.spheres.clear();
    for (std::size_t c = 0; c < casters_.size(); ++c) {
        const Caster& caster = casters_[c];
        if (!choice.has(c) || !reaches(c, points)) continue;
        const float least = leastOf(caster);
        const auto counts = [&](Vec3 at, float size) {
            return !countsNowhere(size, length(at - points.center) - points.radius, least);
        };
        for (std::size_t p = 0; p < caster.pose.posed.size(); ++p)
            if (const PosedPart& part = caster.pose.posed[p]; counts(part.center, part.radius))
                found.parts.push_back(std::uint16_t(caster.first_part + p));
        for (std::size_t s = 0; s < caster.blockers.spheres.size(); ++s)
            if (const CasterSphere& sphere = spheres_[caster.first_part + s]; counts(sphere.center, sphere.radius))
                found.spheres.push_back(sphere);
    }
}

void CastShadow::castFields(const CastReceivers& receivers, std::span<const std::uint16_t> parts,
                            const FarAnchors& anchors, std::span<float> rows) const {
    fastestFarPath().far(
        *constants_, {tables_.data(), posed_.data(), parts.data(), parts.size()}, anchors,
        {receivers.positions.data(), receivers.normals.data(), receivers.tangents.data(), receivers.positions.size()},
        rows.data());
}

void CastShadow::mirrorSpheres(const CastReceivers& receivers, const Found& found, std::span<float> rows) const {
    const CastPoints points{receivers.positions, receivers.normals, receivers.tangents};
    if (exponential_.isDefault()) return castMirrored(found.spheres, points, kSphereFade, rows);
    castMirroredReference(exponential_, found.spheres, points, kSphereFade, rows);
}

void CastShadow::castSpheres(const CastReceivers& receivers, const Found& found, std::span<float> rows) const {
    if (found.parts.empty()) return mirrorSpheres(receivers, found, rows);
    std::array<float, kMaxReceivers * kFarCoefficients> by_spheres;
    const std::span<float> factor = std::span(by_spheres).first(rows.size());
    mirrorSpheres(receivers, found, factor);
    multiplyBySpheres(factor, rows);
}

void CastShadow::multiplyBySpheres(std::span<const float> by_spheres, std::span<float> rows) const {
    fastestFarPath().compose(productConstants(kFieldOrder), by_spheres.data(), nullptr, rows.size() / kFarCoefficients,
                             kFarCoefficients, rows.data());
}

// Bands ring, and a crowd rings most. E stays in [0, 1].
void CastShadow::finish(std::span<float> rows) const {
    for (std::size_t first = 0; first < rows.size(); first += kFarCoefficients)
        clampAmbient(ambient_weights_, ambient_norm2_, rows.subspan(first, kFarCoefficients));
}

std::size_t CastShadow::evaluate(const CastReceivers& receivers, CasterChoice choice, std::span<float> out) const {
    const std::size_t count = receivers.positions.size();
    assert(out.size() == count * kFarCoefficients);
    thread_local Found found;  // keeps its room
    std::size_t seen = 0;
    for (std::size_t first = 0; first < count; first += kMaxReceivers) {
        const std::size_t n = std::min(kMaxReceivers, count - first);
        const CastReceivers block{receivers.positions.subspan(first, n), receivers.normals.subspan(first, n),
                                  receivers.tangents.subspan(first, n)};
        findParts(sphereAround(block.positions), choice, found);
        const std::span<float> rows = out.subspan(first * kFarCoefficients, n * kFarCoefficients);
        if (found.parts.empty() && found.spheres.empty()) {
            leaveFree(rows);
            continue;
        }
        seen += n;
        if (!found.parts.empty()) castFields(block, found.parts, {}, rows);
        if (!found.spheres.empty()) castSpheres(block, found, rows);
        finish(rows);
    }
    return seen;
}

}  // namespace penumbra
