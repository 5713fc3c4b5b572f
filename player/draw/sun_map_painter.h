#pragma once
// Depth maps of suns in GL, and the shader text that reads them. SunMaps (runtime/sun/sun_map.h) is its twin on
// the CPU.
#include <string>
#include <vector>

#include "player/draw/closed_surfaces.h"
#include "player/gl/gl_objects.h"
#include "runtime/sun/sun_nest.h"

namespace penumbra {

// GLSL of float sunVisibility(int sun, vec3 position, vec3 normal) and its two halves, without a #version.
std::string sunGlsl();

// The places of what sunGlsl() reads in a program; -1 where it does not use them.
struct SunUniforms {
    GLint depths = -1, blocks = -1, maps = -1, block_side = -1, block_count = -1;
};
SunUniforms sunUniforms(const GlObject& program);

class SunMapPainter {
public:
    // Draws maps of up to `suns` suns (1 to kMaxSunMaps), of `size` texels a side. It makes one now, and draw() makes
    // more where there are more suns or where they have several. Throws Unsupported when GL has no textures of that
    // size.
    explicit SunMapPainter(int suns = 1, int size = kSunMapSize);

    // Uploads the triangles. The casters of draw() have them, in the same order.
    void setCasters(const SunCasters& casters);
    // Uploads the casters' positions and draws the maps of fitSunNest() for this size; nests.size() is at most `suns`.
    // A map that would be the one that it is already is left alone: it holds a ground that has not changed, and nobody
    // else. Leaves a framebuffer of its own and its viewport in use.
    void draw(std::span<const SunNest> nests, const SunCasters& casters);

    // Gives the maps to the program in use, on texture units `unit` and the next.
    void bind(const SunUniforms& at, GLuint unit) const;
    int size() const { return size_; }

private:
    struct Mesh {
        GlObject vertex_array, positions, triangles;
        std::size_t vertices = 0;
        ClosedSurfaces surfaces;
        GLsizei drawn = 0;      // indices
        GLsizei outward = 0;    // number of indices at the start whose backs the sun cannot reach before their fronts
        bool skipping = false;  // the uploaded triangles lack those with vertices that are not finite
    };
    static constexpr std::size_t kFrameFloats = 20;
    struct Layer {
        std::array<float, kFrameFloats> frame{};  // layout of the shader
        std::uint64_t ground_version = 0;         // version of the ground, if it is alone in the layer; 0: other
                                                  // members are in it, too
        GlObject ground;                          // the triangles of the ground that reach into it
        std::size_t ground_room = 0;              // indices that the buffer has room for
    };
    struct Square {
        int first, side;
    };
    static std::array<float, kFrameFloats> packFrame(const NestedSunMap& map);
    static Mesh makeMesh(const SunCaster& caster, ClosedSurfaces surfaces);
    void makeLayers(std::size_t count);
    void upload(Mesh& mesh, const SunCaster& caster);
    void uploadGround(const SunCasters& casters);
    void drawLayer(std::size_t layer, const NestedSunMap& map, std::uint64_t ground_version);
    static void drawMember(const Mesh& mesh);
    void drawGround(Layer& layer, const NestedSunMap& map) const;
    // Clears a layer and puts a program into use that draws positions (attribute 0, scene frame) into it. After the
    // last triangle comes finish().
    void begin(std::size_t layer) const;
    void finish(std::size_t layer) const;
    static void reduce(const GlObject& program, Square from, Square to, int reached_first);

    int suns_, size_;
    GlObject depths_, framebuffer_, program_;
    GlObject texel_blocks_, block_blocks_;  // programs
    TextureBuffer blocks_;                  // [layers, blocks, 2], as sun_blocks.comp has them
    GLint frame_at_;
    std::vector<Mesh> meshes_;  // meshes of the members
    Mesh ground_;
    std::uint64_t ground_version_ = 0;             // version that is uploaded
    std::vector<std::uint32_t> finite_triangles_;  // scratch
    std::vector<Layer> layers_;
    std::array<GLint, 2 * kMaxSunMaps> maps_{};  // for each sun its first layer, and the one after its last
    std::vector<float> frames_;                  // frames of the layers, in the layout of the shader
    GlObject frames_block_;                      // frames_ on the GPU
};

}  // namespace penumbra
