#pragma once
// What characters hide from points of a scene: from the ground, from things, and from one another (Nowrouzezahrai 2009,
// section 7). Casters are of two kinds. A composed asset has fields of its parts, which tell what they hide from
// anywhere; parts of all characters are multiplied, as the parts of one character are (docs/formulas.md, sections 7 and
// 8). An asset with sphere blockers hides what its spheres hide (sections 9 and 10). Both give the same numbers.
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/evaluate/evaluator.h"
#include "sh/cast/cast_reference.h"
#include "sh/cast/cast_visibility.h"

namespace penumbra {

// Spheres fade as parts do. A person of 15 spheres counts whole up to some 3 m, and is gone at 6 m.
inline constexpr CastFade kSphereFade = {0.0001f, 0.0003f};

// Points with unit normals and tangents orthogonal to them, in the frame of the scene.
struct CastReceivers {
    std::span<const Vec3> positions, normals, tangents;  // [count]
};

// A sphere around all points, of which there is at least one.
CasterSphere sphereAround(std::span<const Vec3> points);

// Vertices of a character that share anchors (runtime/evaluate/far_anchors.h).
struct CastRun {
    CastReceivers vertices, anchors;  // the anchors' tangents are not read
    const std::uint16_t* anchor;      // [vertices, kAnchorsOfReceiver], index into `anchors`
    const float* weight;              // [vertices, kAnchorsOfReceiver]
    float spacing;                    // of the anchors
};

constexpr std::size_t kNobody = std::size_t(-1);
// Which casters count: all but one, or one alone.
struct CasterChoice {
    std::size_t except = kNobody, only = kNobody;
    bool has(std::size_t caster) const { return caster != except && (only == kNobody || caster == only); }
};

// What anchors know of the casters around them (CastShadow::sumAnchors()). It keeps its room.
struct CastAnchors {
    struct Values {
        std::vector<float> all, values;  // [anchors, anchorStride(]of all that is found, and of what is near[)]
        std::vector<std::size_t> near;   // index into what is found: what is near to any anchor

        // Makes `values` of `all`, in which `found` things have columns.
        void keepNear(std::size_t anchors, std::size_t found);
        FarAnchors view(const std::uint16_t* anchor, const float* weight) const {
            return {values.data(), anchorStride(near.size()), anchor, weight};
        }
    };
    CasterChoice choice;
    bool sums = false;  // else every vertex looks up all casters for itself
    bool has_fields = false, has_spheres = false;
    Values fields, spheres;
    std::vector<std::uint16_t> near_parts;
    std::vector<CasterSphere> near_spheres;
};

enum class CasterKind : std::uint8_t { kFields, kSpheres };
// Returns what an asset casts by if nothing else is wished: fields, else spheres, else nothing.
std::optional<CasterKind> casterKindOf(const Evaluator& evaluator);

class CastShadow {
public:
    // The evaluators outlive this object. Each has what its kind needs; by default it casts by casterKindOf(). Together
    // they have at most 65,535 parts and as many spheres; throws std::length_error beyond that.
    explicit CastShadow(std::span<const Evaluator* const> casters, std::span<const CasterKind> kinds = {});
    CastShadow(const CastShadow&) = delete;  // posed parts point into one another

    std::size_t casterCount() const { return casters_.size(); }
    // Poses a caster by its skinning matrices. `to_scene` is a rotation and a translation. Allocates nothing.
    void pose(std::size_t caster, std::span<const Affine> bones, const Affine& to_scene);
    // From now on the caster hides nothing, until it is posed again. This is how all casters begin.
    void hide(std::size_t caster);

    // How caps of spheres are multiplied from now on. Anything but the default is slow, allocates, and is there for
    // comparison.
    void setExponential(const CastExponential& exponential) { exponential_ = exponential; }
    const CastExponential& exponential() const { return exponential_; }
    // Returns whether a caster that is not hidden may count anywhere in a sphere.
    bool reaches(std::size_t caster, const CasterSphere& points) const;
    // Returns the radius of the largest part or sphere of the caster of which it is smallest. Hidden ones do not count.
    float smallestCaster() const;
    // Returns whether a chosen caster that is not hidden casts by fields.
    bool castsFields(CasterChoice choice) const;
    // Returns the spheres of the chosen casters that are not hidden, in the scene.
    std::vector<CasterSphere> spheresOf(CasterChoice choice) const;

    // Writes the visibility past the parts of the chosen casters, mirrored at each receiver's horizon:
    // out[r * kFarCoefficients + i] in its local frame (farVisibility(), sh/far/far_visibility.h). Parts that hide too
    // little from all of 64 neighbouring receivers are skipped, which does not change what the others give. Returns how
    // many receivers see any caster; the rows of the others are those of free sight. E of every row is in [0, 1]. A
    // thread keeps room for the parts and spheres in reach, so that nothing is allocated once it has seen as many.
    std::size_t evaluate(const CastReceivers& receivers, CasterChoice choice, std::span<float> out) const;
    // Sums what is far and hides little at anchors, whose tangents are not read. Vertices in the sphere `around` may
    // use them, which holds the anchors as well. `spacing` is the mean distance of a vertex from its anchors.
    void sumAnchors(const CastReceivers& anchors, const CasterSphere& around, float spacing, CasterChoice choice,
                    CastAnchors& out) const;
    // Does what evaluate() does for vertices among anchors, which look up only what is near. `anchor` and `weight` are
    // those of CastRun. docs/scene.md has the error.
    std::size_t evaluateAt(const CastAnchors& anchors, const CastReceivers& vertices, const std::uint16_t* anchor,
                           const float* weight, std::span<float> out) const;
    // Both, for vertices of a character.
    std::size_t evaluateRun(const CastRun& run, CasterChoice choice, std::span<float> out) const;

private:
    struct Caster {
        const FarTables* tables;  // null: it casts by spheres
        bool hidden = true;
        std::size_t first_part;     // or sphere
        std::vector<Affine> bones;  // in the scene
        FarPose pose;
        BlockersView blockers = {};
        Vec3 center = {};  // bounding sphere of the parts' centers, in the scene
        float radius = 0;
        float largest_part = 0;  // radius
    };
    struct Found {
        std::vector<std::uint16_t> parts;
        std::vector<CasterSphere> spheres;
    };
    std::vector<Caster> casters_;
    std::vector<FarTable> tables_;  // of all parts
    std::vector<FarPart> posed_;
    std::vector<CasterSphere> spheres_;  // of all casters, in the scene
    CastExponential exponential_;
    const FarConstants* constants_ = nullptr;
    std::array<float, kFarCoefficients> ambient_weights_{};
    float ambient_norm2_ = 0;

    void bound(Caster& caster, std::size_t parts, const auto& sphereOf);
    void poseSpheres(Caster& caster);
    float leastOf(const Caster& caster) const;  // share of the sphere below which nothing of it counts
    void findParts(const CasterSphere& points, CasterChoice choice, Found& found) const;
    void castFields(const CastReceivers& receivers, std::span<const std::uint16_t> parts, const FarAnchors& anchors,
                    std::span<float> rows) const;
    void castSpheres(const CastReceivers& receivers, const Found& found, std::span<float> rows) const;
    void multiplyBySpheres(std::span<const float> by_spheres, std::span<float> rows) const;
    void sumFields(const CastReceivers& anchors, float spacing, std::span<const std::uint16_t> parts,
                   std::span<float> values) const;
    void finish(std::span<float> rows) const;
    void mirrorSpheres(const CastReceivers& receivers, const Found& found, std::span<float> rows) const;
};

}  // namespace penumbra
