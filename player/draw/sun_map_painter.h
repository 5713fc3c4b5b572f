#pragma once
// Depth maps of suns in GL, and the shader text that reads them. SunMap (player/runtime/sun_map.h) is its twin on the
// CPU.
#include <string>
#include <vector>

#include "player/gl/gl_objects.h"
#include "player/runtime/sun_frame.h"

namespace penumbra {

// GLSL of float sunVisibility(int sun, vec3 position, vec3 normal) and its two halves, without a #version.
std::string sunGlsl();

// The places of what sunGlsl() reads in a program; -1 where it does not use them.
struct SunUniforms {
    GLint depths = -1, blocks = -1, frames = -1, block_side = -1, block_count = -1;
};
SunUniforms sunUniforms(const GlObject& program);

class SunMapPainter {
public:
    // Makes maps for `suns` suns (1 to kMaxSunMaps), of `size` texels a side. Throws Unsupported when GL has no
    // textures of that size.
    explicit SunMapPainter(int suns = 1, int size = kSunMapSize);

    // Uploads the triangles. The casters of draw() have them, in the same order.
    void setCasters(std::span<const SunCaster> casters);
    // Uploads the casters' positions and draws the maps; frames.size() is at most `suns`. Frames of fitSunFrame() for
    // this size, or empty ones. Leaves a framebuffer of its own and its viewport in use.
    void draw(std::span<const SunFrame> frames, std::span<const SunCaster> casters);
    // Clears the map of a sun and puts a program into use that draws positions (attribute 0, scene frame) into it.
    // Positions must be finite. After the last triangle comes finish().
    void begin(int sun, const SunFrame& frame);
    void finish(int sun) const;

    // Gives the maps to the program in use, on texture units `unit` and the next.
    void bind(const SunUniforms& at, GLuint unit) const;
    int size() const { return size_; }

private:
    struct Mesh {
        GlObject vertex_array, positions, triangles;
        std::size_t vertices = 0, indices = 0;
        GLsizei drawn = 0;      // indices
        bool skipping = false;  // the uploaded triangles lack those with vertices that are not finite
    };
    struct Square {
        int first, side;
    };
    void upload(Mesh& mesh, const SunCaster& caster);
    void drawMeshes() const;
    static void reduce(const GlObject& program, Square from, Square to, int reached_first);

    int suns_, size_;
    GlObject depths_, framebuffer_, program_;
    GlObject texel_blocks_, block_blocks_;  // programs
    TextureBuffer blocks_;                  // [suns, blocks, 2], as sun_blocks.comp has them
    GLint frame_at_;
    std::vector<Mesh> meshes_;
    std::vector<std::uint32_t> finite_triangles_;  // scratch
    std::vector<float> frames_;                    // [suns, 4, 4], as the shader has them
};

}  // namespace penumbra
