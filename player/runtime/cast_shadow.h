#pragma once
// What characters hide from points of a scene: from the ground, from things, and from one another (paper 000, section
// 7). A caster is a composed asset, whose parts' fields tell what they hide from anywhere (docs/formulas.md, section
// 7). Parts of all characters are multiplied, as the parts of one character are.
#include <cstdint>
#include <memory_resource>
#include <span>
#include <vector>

#include "player/runtime/evaluator.h"

namespace penumbra {

// Points with unit normals and tangents orthogonal to them, in the frame of the scene.
struct CastReceivers {
    std::span<const Vec3> positions, normals, tangents;  // [count]
};

constexpr std::size_t kNobody = std::size_t(-1);
// Which casters count: all but one, or one alone.
struct CasterChoice {
    std::size_t except = kNobody, only = kNobody;
    bool has(std::size_t caster) const { return caster != except && (only == kNobody || caster == only); }
};

class CastShadow {
public:
    // The evaluators are of composed assets and outlive this object. Together they have at most 65,535 parts; throws
    // std::length_error beyond that.
    explicit CastShadow(std::span<const Evaluator* const> casters);

    std::size_t casterCount() const { return casters_.size(); }
    // Poses a caster by its skinning matrices. `to_scene` is a rotation and a translation. Allocates nothing.
    void pose(std::size_t caster, std::span<const Affine> bones, const Affine& to_scene);
    // From now on the caster hides nothing, until it is posed again. This is how all casters begin.
    void hide(std::size_t caster);

    // Writes the visibility past the parts of the chosen casters, mirrored at each receiver's horizon:
    // out[r * kFarNumbers + i] in its local frame (farVisibility(), sh/far_visibility.h). Parts that hide too little
    // from all of 64 neighbouring receivers are skipped, which does not change what the others give. Returns how many
    // receivers see any caster; the rows of the others are those of free sight. Allocates
    // nothing unless thousands of parts are in reach.
    std::size_t evaluate(const CastReceivers& receivers, CasterChoice choice, std::span<float> out) const;

private:
    struct Caster {
        const FarTables* tables;
        bool hidden = true;
        std::size_t first_part;
        std::vector<Affine> bones;  // in the scene
        FarPose pose;
        Vec3 centre;  // bounding sphere of the parts, in the scene
        float radius = 0;
        float largest_part = 0;  // radius
    };
    std::vector<Caster> casters_;
    std::vector<FarTable> tables_;  // of all parts
    std::vector<FarPart> posed_;

    void findParts(Vec3 centre, float radius, CasterChoice choice, std::pmr::vector<std::uint16_t>& parts) const;
};

}  // namespace penumbra
