#pragma once
// The pictures on a mesh, for the fragments that join them with the terms of vertices (shaders/surface.glsl).
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "player/gl/gl_objects.h"
#include "runtime/shade/shading_set.h"

namespace penumbra {

// Properties of a mesh with pictures that its shaders depend on. Without terms, the shaders are for meshes without
// pictures.
struct SurfaceShader {
    bool on = false;
    bool colors = false, turns = false, blends = false;       // properties that vertices of some slot have
    std::size_t slopes = 0, steps = 0;                        // see SurfaceTerms
    std::size_t terms() const { return slopes + 2 * steps; }  // beside D
    auto operator<=>(const SurfaceShader&) const = default;
};
SurfaceShader surfaceShaderOf(const ShadingSet* shading);

// Places of the uniforms of shaders/surface.glsl, and of the one of value.vert.
struct SurfaceUniforms {
    GLint replaced = -1, base = -1, emissive = -1, f0 = -1, numbers = -1, alpha = -1, steps = -1, step_roughness = -1,
          uv_set = -1, colors = -1, turns = -1;
    std::array<GLint, kTextureRoles> textures{};
};
SurfaceUniforms surfaceUniforms(const GlObject& program);

class GlSurface {
public:
    // Decodes and uploads the pictures of an asset that has some. Throws what decodeTexture() and readTexture() throw,
    // and Unsupported for a picture that is too large for this OpenGL. `asset` outlives this object.
    explicit GlSurface(const AssetView& asset);

    std::size_t drawnVertices() const { return drawn_; }
    std::span<const std::uint32_t> seamVertices() const;
    // The triangles as vertices that are drawn, those of one slot together.
    std::span<const std::uint32_t> triangles() const { return triangles_; }
    // [V + E] texture coordinates of both sets, 4 floats a vertex.
    const GlObject& places() const { return places_; }
    // [V + E] the vertex of the mesh that each drawn vertex is, a word each.
    const GlObject& sources() const { return sources_; }
    std::size_t bytes() const { return bytes_; }

    // Draws the triangles of each slot with its pictures; the program, its other uniforms and an element buffer with
    // triangles() are in use. `shading` tells which slots have other materials now; null: the vertices tell.
    void draw(const SurfaceUniforms& at, const ShadingSet* shading, std::size_t instances = 1) const;

private:
    const AssetView* asset_;
    std::size_t drawn_ = 0, bytes_ = 0;
    std::vector<std::uint32_t> triangles_;
    std::vector<std::size_t> first_of_slot_;  // [slots + 1] into triangles_
    GlObject places_, sources_;
    TextureBuffer colors_, turns_;  // [V + E]; one texel where vertices have none
    // By texture, what it is for and how it repeats: an sRGB picture and one of numbers differ.
    std::map<std::tuple<std::uint16_t, bool, std::uint8_t>, GlObject> pictures_;
    std::array<GlObject, 2> none_;  // white, and the normal of a level surface

    void sortTriangles();
    void uploadPlaces();
    void uploadPictures();
    GLuint pictureOf(const TextureUse& use, TextureRole role) const;
    void bind(const SurfaceUniforms& at, std::size_t slot) const;
};

// The pictures of a mesh and what is on in it. Meshes of one asset may share the pictures.
struct PicturedMesh {
    const ShadingSet* shading = nullptr;       // outlives this
    std::shared_ptr<const GlSurface> surface;  // null: pictures are not shown

    PicturedMesh() = default;
    // Uploads them where `shading` shows them; it may be null.
    PicturedMesh(const ShadingSet* set) : shading(set) {
        if (surfaceShaderOf(set).on) surface = std::make_shared<const GlSurface>(set->asset());
    }
    SurfaceShader shader() const { return surface ? surfaceShaderOf(shading) : SurfaceShader(); }
};

}  // namespace penumbra
