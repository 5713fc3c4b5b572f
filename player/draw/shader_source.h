#pragma once
// Makes GLSL text from the files of player/shaders/ with a preamble, and from the sums over SH functions that are
// written out for one convention and shading layout.
#include <optional>
#include <string>

#include "player/draw/evaluate_layout.h"
#include "player/draw/gl_surface.h"
#include "player/frame/channel.h"
#include "runtime/glsl/brdf_glsl.h"
#include "runtime/glsl/far_glsl.h"
#include "runtime/shade/shading_layout.h"

namespace penumbra {

struct ShaderRecipe {
    Channel channel = Channel::kShaded;
    Convention convention;
    int stride = 0, influences = 0;
    bool slots = false;      // the mesh has them
    bool deforming = false;  // positions and normals are given instead of skinned: also with morph targets
    // The precision that all clusters share; unset: each cluster has its own.
    std::optional<AssetPrecision> mean = {}, basis = {};
    const ShadingLayout* shading = nullptr;  // only for kShaded
    SurfaceShader surface = {};              // only for kShaded: of the asset's pictures
    AssetPlaces asset = {};
    PosePlaces pose = {};
    std::size_t clusters = 0;           // clusters of the model
    bool residual = false;              // the asset has one
    std::optional<FarPlaces> far = {};  // set for a composed asset that the GPU evaluates
    std::string far_functions = {};     // farGlsl()
    // Where the asset has light that bounces: its first row in the cluster table, and the weights of its ambient term.
    std::optional<std::size_t> first_indirect = {};
    Vec3 bounced_ambient = {};
    bool casts = false;    // numbers are multiplied by what GlCast has written
    bool heights = false;  // multiplies by the visibility past a height field, too, which follows for each vertex
    bool sunlit = false;   // surfaces are written for the fragments that suns shine on; only for kShaded
};

bool showsVisibility(Channel channel);

constexpr std::size_t kWorkGroup = 64;  // vertices: two warps or one wave

std::string evaluateSource(const ShaderRecipe& recipe);
// Returns the shader that evaluates the anchors of a composed asset, which goes before the other. recipe.far is set.
std::string anchorSource(const ShaderRecipe& recipe);
// Returns the shader that writes the vertices on which GlCast casts.
std::string receiverSource(const ShaderRecipe& recipe);
// The receivers of a cast: each for itself, the anchors of characters, or the vertices around them.
enum class CastPass { kEach, kAnchors, kAtAnchors };
// Return the shader that casts, for a scene with such casters, and that of the ground.
std::string castSource(CasterKinds kinds, CastPass pass = CastPass::kEach);
std::string groundSource(bool sunlit);

// The shaders of a height field. `heights` is heightsGlsl() (heights_glsl.h).
struct HeightsRecipe {
    std::string heights;
    int order = 0;                           // order of V
    int spacing = 0;                         // points from one receiver to the next
    std::size_t rows = 0, columns = 0;       // size of the grid of receivers
    float tolerance = 0;                     // error above which there are finer receivers; 0: nowhere
    Channel channel = Channel::kShaded;      // kShaded or kAmbient
    const ShadingLayout* shading = nullptr;  // only for kShaded
    bool casts = false, sunlit = false;      // see ShaderRecipe
};
std::string heightsPyramidSource();
std::string heightsHorizonsSource(const HeightsRecipe& recipe);
// How much of finer receivers the cells show, or what these see.
std::string heightsSharesSource(const HeightsRecipe& recipe);
std::string heightsFinerSource(const HeightsRecipe& recipe);
std::string heightsAboveSource(const std::string& heights);
std::string heightsReceiversSource(const HeightsRecipe& recipe);
std::string heightsPointsSource(const HeightsRecipe& recipe);
// Suns shine on a surface of materials with these models (shaders/sunlight.glsl); 0: they do not.
// `surface` is of meshes with pictures, only for kShaded.
std::string valueVertexSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface = {});
std::string evaluatedVertexSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface = {});
std::string channelFragmentSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface = {});
// A light behind everything, as SkyPainter draws it.
std::string skyVertexSource();
std::string skyFragmentSource();

}  // namespace penumbra
