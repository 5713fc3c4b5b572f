#pragma once
// The light of suns, which the fragments of sunlit surfaces add to what their vertices show (shaders/sunlight.glsl).
#include <span>
#include <vector>

#include "player/draw/frame_view.h"
#include "player/draw/sun_map_painter.h"
#include "player/frame/lobe_table.h"
#include "player/frame/sky_picture.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

// Inputs of suns for a mesh besides its positions.
struct SunlitSurface {
    std::span<const Vec3> normals, tangents;  // [V] unit, in the frame of the positions
    std::span<const LobeRange> lobes;         // [V] of the vertex' material, in the table of the Sunlight
    std::span<const float> sight = {};        // [V] mirrorSight(); empty where there are no mirrors
};

struct SunlightUniforms {
    GLint scene_from_model = -1, eye = -1, lobes = -1, count = -1, direction = -1, irradiance = -1, cosine = -1;
    GLint sky = -1, sky_size = -1, light_from_scene = -1;
    SunUniforms maps;
};
SunlightUniforms sunlightUniforms(const GlObject& program);

class Sunlight {
public:
    // `lobes` outlives this object.
    explicit Sunlight(const LobeTable& lobes, int map_size = kSunMapSize);

    // Draws the maps of suns, at most kMaxSuns, whose directions and casters are in the scene. Between calls only
    // positions may change, unless the casters are other ones by their number of triangles or vertices. Leaves another
    // framebuffer and viewport in use.
    void shine(std::span<const Sun> suns, const SunCasters& casters);
    // Takes what mirrors reflect, turned by `rotation` in the scene.
    void reflect(const SkyPicture& sky);
    void turnSky(const Mat3& rotation) { rotation_ = rotation; }
    BrdfModels models() const { return lobes_->models(); }  // models of all lobes
    // Uploads the lobes where they have changed, into the same buffer while it is large enough.
    void updateLobes();
    // Gives suns, maps, lobes and the sky to the program in use.
    void bind(const SunlightUniforms& at, const FrameView& view) const;

private:
    const LobeTable* lobes_;
    TextureBuffer lobe_texels_;
    std::vector<BrdfLobe> uploaded_;  // contents of the texels
    std::size_t room_ = 0;            // lobes that the buffer has room for
    SunMapPainter maps_;
    std::vector<Sun> suns_;
    TextureBuffer sky_;
    int sky_width_ = 0, sky_height_ = 0;
    Mat3 rotation_;
    std::vector<SunNest> nests_;      // one for each sun
    std::vector<std::size_t> sizes_;  // vertices and triangles of the casters that are uploaded
};

}  // namespace penumbra
