#pragma once
// Looks up the pictures on a mesh at a point, for pictures by brute force. What it returns is the material of glTF 2.0
// (formats/common/surface.h).
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bake/reference/direct_light.h"
#include "formats/common/surface.h"
#include "formats/image/texture_file.h"

namespace penumbra {

// The material of one point.
struct PointMaterial {
    Vec3d diffuse, f0, f90, emissive;  // weights of the three parts of sh/brdf/principled.h
    double roughness = 1, occlusion = 1;
    BrdfSpec dielectric;                  // D
    std::optional<Vec3d> picture_normal;  // along tangent, bitangent (up in the picture) and normal
};

// A triangle of the mesh and where on it a point lies.
struct SurfacePlace {
    std::size_t triangle = 0;
    std::array<double, 3> weight{};
};

class PictureSurface {
public:
    // Opens the pictures; a relative file lies in `folder`. `slot_of_triangle` [T]. `name` starts messages. Throws the
    // errors of decodeTexture() and readTexture().
    PictureSurface(MeshSurface surface, std::vector<std::uint16_t> slot_of_triangle,
                   const std::filesystem::path& folder, const std::string& name);

    std::size_t triangles() const { return slot_of_triangle_.size(); }
    // From now on the slot has another material.
    void leaveOut(std::size_t slot) { plain_[slot] = true; }
    bool has(std::size_t triangle) const { return !plain_[slot_of_triangle_[triangle]]; }
    // Returns whether a ray passes: where alpha is below the cut-off or, of a slot that blends, not above `chance`,
    // which is even in [0, 1).
    bool isHole(const SurfacePlace& at, double chance) const;
    PointMaterial materialAt(const SurfacePlace& at) const;
    // Returns the normal of the picture for a triangle with these corners, whose smooth normal is `level`, unit. The
    // picture's x is along the unit direction in which u grows, across `level`, and its y at right angles to both
    // (glTF 2.0, section 3.7.2.1; MikkTSpace).
    Vec3d bentNormal(const SurfacePlace& at, const std::array<Vec3d, 3>& corners, Vec3d level, Vec3d picture) const;

private:
    MeshSurface surface_;
    std::vector<std::uint16_t> slot_of_triangle_;
    std::vector<bool> plain_;
    std::vector<TexturePicture> pictures_;

    const SlotSurface& slotAt(const SurfacePlace& at) const { return surface_.slots[slot_of_triangle_[at.triangle]]; }
    std::array<double, 4> look(const SurfacePlace& at, TextureRole role) const;
    std::array<double, 4> colorOf(const SurfacePlace& at) const;  // colour of the vertices, with alpha
    Vec3d turned(const SurfacePlace& at, Vec3d along) const;
};

// Samples the BRDF of points. Lobes to sample by are fitted once, at some roughnesses.
class PointBrdfs {
public:
    explicit PointBrdfs(int threads);
    SampledBrdf brdfOf(const PointMaterial& material) const;

private:
    std::vector<SamplingLobe> lobes_;
};

// Pictures on a part of the triangles of a scene, or on all of them.
struct PicturePart {
    std::size_t first_triangle = 0;
    const PictureSurface* surface = nullptr;
};

}  // namespace penumbra
