#pragma once
// A mesh whose vertices a compute shader evaluates and evaluated.vert draws: one that stands in the scene.
#include <span>

#include "player/draw/sunlight.h"
#include "player/frame/channel.h"

namespace penumbra {

class EvaluatedMesh {
public:
    // Suns shine on a mesh whose materials have the models `sunlit`; 0: they do not.
    EvaluatedMesh(std::span<const std::uint32_t> triangles, std::size_t vertices, Channel channel, BrdfModels sunlit);

    std::size_t vertices() const { return vertices_; }
    // Where the shader writes, as evaluated.vert reads it.
    const GlObject& values() const { return evaluated_.buffer; }
    // `suns` are not null where they shine.
    void draw(const FrameView& view, const Sunlight* suns) const;

private:
    std::size_t vertices_;
    GLsizei index_count_;
    bool sunlit_;
    GlObject vertex_array_, triangles_, draw_;
    TextureBuffer evaluated_;
    GLint vertex_count_;
    ViewUniforms view_;
    SunlightUniforms sunlight_;
};

}  // namespace penumbra
