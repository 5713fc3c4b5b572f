#pragma once
// Holds all that the characters of one asset share on the GPU: its arrays, materials and programs.
#include <map>

#include "player/draw/draw_frame.h"
#include "player/draw/shader_source.h"
#include "player/draw/sunlight.h"
#include "player/gl/gl_objects.h"
#include "runtime/evaluate/evaluator.h"

namespace penumbra {

class GlAsset {
public:
    // `asset` has a model and outlives this object, and so do its bytes. `shading` may be null where nothing is
    // shaded. The sets of all characters that are drawn with this object must have the same materials, lights and
    // choice. `evaluator` is one of this asset; with it the GPU evaluates a composed asset, too. Without it, and where
    // the model has more bands than the fields or stands on a floor, the numbers of a composed asset must be given.
    GlAsset(const AssetView& asset, const ShadingSet* shading, const Evaluator* evaluator = nullptr);

    const AssetView& view() const { return *asset_; }
    std::size_t vertexCount() const { return asset_->mesh.positions.size(); }
    const PosePlaces& pose() const { return recipe_.pose; }
    const ShadingLayout& shading() const { return *shading_; }
    std::size_t bytes() const { return bytes_; }  // of GL memory
    bool needsCoefficients() const { return asset_->model.composition && !recipe_.far; }
    // Anchors of a composed asset that the GPU evaluates, and the vec4 that their values take; 0 for any other.
    std::size_t anchorCount() const { return recipe_.far ? recipe_.far->anchor_count : 0; }
    std::size_t anchorValues() const { return recipe_.far ? recipe_.far->anchor_values : 0; }
    std::uint32_t fieldWords() const { return recipe_.far->parts; }  // where the words of its parts begin
    bool evaluatesFar() const { return recipe_.far.has_value(); }
    // Its pictures, which shaded characters show; null: none.
    const GlSurface* surface() const { return surface_ ? &*surface_ : nullptr; }
    // Of what is evaluated for a vertex, in vec4. `sunlit` has the models of lobes; 0: no suns.
    std::size_t evaluatedQuads(Channel channel, BrdfModels sunlit) const;

    struct Program {
        GlObject program;
        GLint eye = -1, vertex_count = -1;
        ViewUniforms view;
        SunlightUniforms sunlight;
        SurfaceUniforms surface;
    };
    // Programs are compiled when they are first asked for. The painter's shaders define the bindings.
    // `cast_sets` are GlCast::castSets(); 0: nothing casts.
    const Program& evaluateProgram(Channel channel, std::size_t cast_sets, bool sunlit);
    // `sunlit` has the models of all lobes that suns shine on; 0: they do not.
    const Program& drawProgram(Channel channel, BrdfModels sunlit);
    const Program& anchorProgram();
    const Program& receiverProgram();
    void bindArrays() const;  // and materials, for evaluating
    // Draws the triangles of `instances` characters, with pictures where the channel shows them.
    void draw(Channel channel, const Program& program, std::size_t instances) const;

private:
    GLsizei indexCount() const { return GLsizei(asset_->mesh.triangles.size()); }
    const AssetView* asset_;
    std::optional<ShadingLayout> shading_;
    ShaderRecipe recipe_;
    GlObject arrays_, vertex_array_, triangles_;
    std::optional<GlSurface> surface_;
    GlObject pictured_array_, pictured_triangles_;  // of vertices that are drawn, with copies at seams
    TextureBuffer materials_;
    std::size_t bytes_ = 0;
    std::map<std::tuple<Channel, std::size_t, bool>, Program> evaluate_;  // with and without casts, and suns
    std::map<std::pair<Channel, BrdfModels>, Program> draw_;
    std::optional<Program> anchor_, receiver_;

    void placePose();
    void uploadArrays(const Evaluator* evaluator, const ShadingSet* shading);
    void uploadMaterials(const ShadingSet& shading);
    void uploadSurface();
    SurfaceShader surfaceOf(Channel channel) const {
        return channel == Channel::kShaded ? recipe_.surface : SurfaceShader();
    }
};

}  // namespace penumbra
