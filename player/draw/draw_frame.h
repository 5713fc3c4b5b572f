#pragma once
// Draws one frame into the bound target.
#include <array>
#include <memory>
#include <optional>
#include <span>

#include "formats/asset/asset_file.h"
#include "player/draw/closed_surfaces.h"
#include "player/draw/frame_view.h"
#include "player/draw/gl_surface.h"
#include "player/draw/sunlight.h"
#include "player/frame/channel.h"
#include "player/gl/gl_objects.h"
#include "sh/vec3.h"

namespace penumbra {

// Tells which sides of triangles are drawn.
enum class Sides {
    kBoth,
    kSeen,    // only the outsides of closed surfaces (closed_surfaces.h), and both sides of others
    kFront,   // only fronts: in a two-sided mesh the backs have triangles of their own
    kFading,  // both, and what is there already shows through towards FrameView::rim
};

// Draws vertices whose values were computed on the CPU.
class ValuePainter {
public:
    // Suns shine on a mesh whose materials have these models and whose channel is kShaded: it needs upload() with a
    // surface and draw() with the suns. 0: no suns.
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides = Sides::kBoth,
                 BrdfModels sunlit = 0);
    // Draws `sides` of a mesh that is not two-sided. Where `shading` shows a surface, the mesh is that of its asset,
    // the values of upload() are [terms, V] (shadeFrame()), and both outlive this object.
    ValuePainter(const MeshView& mesh, Channel channel, Sides sides, BrdfModels sunlit = 0,
                 const PicturedMesh& pictures = {});
    void draw(const FrameView& view, std::span<const Vec3> positions, std::span<const Vec3> values);
    // The two halves of draw().
    void upload(std::span<const Vec3> positions, std::span<const Vec3> values, const SunlitSurface& surface = {});
    void draw(const FrameView& view, const Sunlight* suns = nullptr) const;
    // Draws other triangles of the same vertices from now on. Not for kSeen.
    void setTriangles(std::span<const std::uint32_t> triangles);

private:
    ValuePainter(std::span<const std::uint32_t> triangles, Channel channel, Sides sides, BrdfModels sunlit,
                 const PicturedMesh& pictures);
    void uploadSurface(const SunlitSurface& surface);
    void addTextures();
    void replaceDrawn(const GlObject& buffer, std::span<const Vec3> values);
    GlObject program_, vertex_array_, positions_, values_, triangles_;
    std::array<GlObject, 4> surface_;  // normals, tangents, lobes and sight of a sunlit mesh
    ViewUniforms view_;
    std::optional<SunlightUniforms> sunlight_;
    Sides sides_;
    ClosedSurfaces surfaces_;  // only for kSeen
    bool outward_ = false;     // in the uploaded pose
    SurfaceUniforms surface_uniforms_;
    std::vector<GlObject> terms_;  // terms after the first
    std::vector<Vec3> drawn_;      // positions of all vertices that are drawn, those at seams last
    std::vector<std::uint32_t> drawn_lobes_;
    std::vector<float> drawn_sight_;
    GLsizei index_count_;
    PicturedMesh pictures_;
};

}  // namespace penumbra
