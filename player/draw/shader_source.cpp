#include "player/draw/shader_source.h"

#include "player/draw/gl_cast.h"
#include "player/draw/heights_glsl.h"
#include "player/draw/sun_map_painter.h"
#include "player/frame/lobe_table.h"
#include "player_shaders.h"
#include "runtime/glsl/brdf_glsl.h"
#include "runtime/glsl/cast_glsl.h"
#include "runtime/glsl/far_glsl.h"
#include "runtime/glsl/sh_glsl.h"
#include "runtime/glsl/shading_glsl.h"
#include "sh/brdf/principled.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

std::string define(const std::string& name, std::size_t value) {
    return "#define " + name + " " + std::to_string(value) + "\n";
}

std::string preamble(Channel channel) {
    std::string text = "#version 430 core\n";
    const char* names[] = {"SHADED",  "AO",    "ERROR",     "CLUSTERS",
                           "NORMALS", "PARTS", "BOUNCED_AO"};  // in the order of Channel
    for (std::size_t i = 0; i < std::size(names); ++i) text += define(std::string("CHANNEL_") + names[i], i);
    // Both kinds of error are a number that becomes a colour.
    return text + define("CHANNEL", std::size_t(channel == Channel::kTransferError ? Channel::kError : channel));
}

// Centroid interpolation takes values at a covered point, so that silhouettes are not extrapolated beyond the
// triangle.
std::string interpolation(Channel channel) {
    const bool whole_numbers = channel == Channel::kClusters || channel == Channel::kParts;
    return std::string("#define INTERPOLATION ") + (whole_numbers ? "flat" : "centroid") + "\n";
}

std::string places(const AssetPlaces& asset, const PosePlaces& pose) {
    return define("POSITIONS", asset.positions) + define("NORMALS", asset.normals) +
           define("TANGENTS", asset.tangents) + define("SKIN_JOINTS", asset.skin_joints) +
           define("SKIN_WEIGHTS", asset.skin_weights) + define("SLOTS", asset.slots) +
           define("CLUSTER_OF_VERTEX", asset.cluster_of_vertex) + define("PART_OF_VERTEX", asset.part_of_vertex) +
           define("OTHER_SIDE", asset.other_side) + define("CLUSTERS", asset.clusters) +
           define("CLUSTER_WORDS", kClusterWords) + define("POSE_BONES", pose.bones) +
           define("POSE_ROTATIONS", pose.rotations) + define("POSE_SCORES", pose.scores) +
           define("POSE_PARTS", pose.parts) + define("POSE_MATERIALS", pose.materials) +
           define("POSE_LOBES", pose.lobes) + define("POSE_TERMS", pose.terms) + define("POSE_LIGHT", pose.light) +
           define("POSE_SIZE", pose.size);
}

// Writes the precision of an array: a number, or the place in the cluster's table that has it.
std::string precisionOf(const char* array, const std::optional<AssetPrecision>& shared, int word) {
    return std::string("#define ") + array + "_PRECISION " +
           (shared ? std::to_string(int(*shared)) + "u" : "clusterWord(" + std::to_string(word) + ")") + "\n";
}

std::string noAnchor() { return "#define NO_ANCHOR " + std::to_string(kNoAnchor) + "u\n"; }

std::string farPlaces(const FarPlaces& far) {
    return "#define COMPOSED\n" + define("FAR_LISTS", far.lists) + define("FAR_RECEIVERS", far.receivers) +
           define("FAR_ANCHOR_TABLE", far.anchors) + define("PART_COUNT", far.part_count) +
           define("ANCHOR_COUNT", far.anchor_count) + define("ANCHOR_VALUES", far.anchor_values) +
           define("NEAR_COUNT", far.near_count) + define("NEAR_PARTS", far.near_parts) +
           define("NEAR_GAINS", far.near_gains) + define("NUMBERS", std::size_t(far.coefficients)) + noAnchor();
}

// Puts a text in the place of the line that names what makes it.
void insertAt(std::string& text, const char* mark, const std::string& generated) {
    const std::string line = std::string("\n") + mark + "\n";
    text.replace(text.find(line), line.size(), "\n" + generated);
}

std::string castPreamble() {
    return "#version 430 core\n" + define("WORK_GROUP", kWorkGroup) + define("CAST_QUADS", kCastQuads);
}

const std::string kSunlit = "#define SUNLIT\n";

// Whether suns shine on what is evaluated, and how much of it there is.
std::string evaluatedQuads(bool sunlit, const SurfaceShader& surface = {}) {
    const std::size_t first = firstTermQuad(surface.slopes, sunlit);
    return (sunlit ? kSunlit : "") + define("EVALUATED_QUADS", first + surface.terms()) + define("TERM_QUAD", first);
}

std::string surfaceDefines(const SurfaceShader& surface) {
    if (!surface.on) return "";
    return std::string("#define TEXTURED\n") + (surface.colors ? "#define COLORED\n" : "") +
           (surface.turns && surface.slopes > 0 ? "#define TURNED\n" : "") +
           (surface.blends ? "#define BLENDED\n" : "") + define("SLOPES", surface.slopes) +
           define("STEPS", surface.steps) + define("TERMS", surface.terms()) + "#define MIN_ROUGHNESS " +
           glslFloat(kMinRoughness) + "\n";
}

}  // namespace

bool showsVisibility(Channel channel) {
    return channel == Channel::kShaded || channel == Channel::kAmbient || channel == Channel::kError ||
           channel == Channel::kBouncedAmbient;
}

std::string receiverSource(const ShaderRecipe& recipe) {
    ShaderRecipe receivers = recipe;
    receivers.channel = Channel::kNormals;
    std::string text = evaluateSource(receivers);
    return text.insert(text.find("#define"), "#define RECEIVERS\n");
}

std::string castSource(CasterKinds kinds, CastPass pass) {
    std::string text = kShaderCastComp, generated = castGlsl(), defines;
    if (pass != CastPass::kEach) {
        generated += castAnchorsGlsl(kinds) + kShaderCastAnchorsGlsl;
        defines = (pass == CastPass::kAnchors ? "#define CAST_ANCHORS\n" : "#define AT_ANCHORS\n") +
                  define("ANCHOR_WORDS", kCastAnchorWords) + noAnchor() + "#define NEAR_SPACINGS " +
                  glslFloat(double(kNearSpacings[0])) + "\n#define FAR_SPACINGS " +
                  glslFloat(double(kNearSpacings[1])) + "\n";
    }
    insertAt(text, "GENERATED_BY_CAST_GLSL", generated);
    return castPreamble() + define("CAP_LOG_TEXELS", capLogTexels().size() / 4) +
           (kinds.parts ? "#define HAS_PARTS\n" : "") + (kinds.spheres ? "#define HAS_SPHERES\n" : "") + defines + text;
}

std::string groundSource(bool sunlit) { return castPreamble() + evaluatedQuads(sunlit) + kShaderGroundComp; }

namespace {

std::string heightsPreamble(const HeightsRecipe& recipe) {
    return preamble(recipe.channel) + define("WORK_GROUP", kWorkGroup) +
           define("ROW_QUADS", heightRowQuads(recipe.order)) + define("SPACING", std::size_t(recipe.spacing)) +
           "#define LINES ivec2(" + std::to_string(recipe.rows) + ", " + std::to_string(recipe.columns) + ")\n" +
           "#define NORMALS_MATTER " + glslFloat(double(kNormalsMatter)) + "\n" +
           (recipe.tolerance > 0
                ? define("SHARES", heightCellShares(recipe.spacing)) + "#define REFINED\n#define TOLERANCE " +
                      glslFloat(double(recipe.tolerance)) + "\n"
                : "");
}

// What points and finer receivers have in common.
std::string heightsSeen(const HeightsRecipe& recipe) { return recipe.heights + kShaderHeightsSeenGlsl; }

}  // namespace

std::string heightsPyramidSource() { return std::string("#version 430 core\n") + kShaderHeightsPyramidComp; }

std::string heightsHorizonsSource(const HeightsRecipe& recipe) {
    return heightsPreamble(recipe) + recipe.heights + kShaderHeightsHorizonsComp;
}

std::string heightsSharesSource(const HeightsRecipe& recipe) {
    return heightsPreamble(recipe) + heightsSeen(recipe) + kShaderHeightsRefineComp;
}

std::string heightsFinerSource(const HeightsRecipe& recipe) {
    return heightsPreamble(recipe) + "#define LOOK\n" + heightsSeen(recipe) + kShaderHeightsRefineComp;
}

std::string heightsAboveSource(const std::string& heights) {
    return castPreamble() + heights + kShaderHeightsAboveComp;
}

std::string heightsReceiversSource(const HeightsRecipe& recipe) {
    std::string text = kShaderHeightsPointsComp;
    insertAt(text, "GENERATED_BY_SHADING_GLSL",
             "#define PENUMBRA_STRIDE4 1\n" + std::string(kShaderPenumbraGlsl) + "\n");
    return heightsPreamble(recipe) + "#undef CHANNEL\n#define CHANNEL CHANNEL_AO\n#define RECEIVERS\n" +
           heightsSeen(recipe) + text;
}

std::string heightsPointsSource(const HeightsRecipe& recipe) {
    const Convention convention{BelowHorizon::kMirrored, recipe.order};
    const auto coefficients = std::size_t(convention.size());
    std::string generated = ambientGlsl(convention);
    if (recipe.casts) generated += castAmbientGlsl() + castCoefficientsGlsl(convention);
    if (recipe.channel == Channel::kShaded) generated += shadingGlsl(*recipe.shading);
    if (recipe.sunlit) generated += sightGlsl(convention);
    std::string text = kShaderHeightsPointsComp;
    insertAt(text, "GENERATED_BY_SHADING_GLSL", generated + kShaderPenumbraGlsl + "\n");
    return heightsPreamble(recipe) + define("NUMBERS", coefficients) +
           define("PENUMBRA_STRIDE4", (coefficients + 3) / 4) + evaluatedQuads(recipe.sunlit) +
           (recipe.casts ? "#define CAST\n" + define("CAST_QUADS", kCastQuads) : "") + heightsSeen(recipe) + text;
}

std::string anchorSource(const ShaderRecipe& recipe) {
    ShaderRecipe anchors = recipe;
    anchors.channel = Channel::kAmbient;
    std::string text = evaluateSource(anchors);
    return text.insert(text.find("#define"), "#define FAR_ANCHORS\n");
}

std::string evaluateSource(const ShaderRecipe& recipe) {
    std::string defines = define("WORK_GROUP", kWorkGroup) + define("INFLUENCES", std::size_t(recipe.influences)) +
                          define("PENUMBRA_STRIDE4", std::size_t(recipe.stride) / 4) +
                          places(recipe.asset, recipe.pose) + precisionOf("MEAN", recipe.mean, 6) +
                          precisionOf("BASIS", recipe.basis, 7);
    const SurfaceShader surface = recipe.channel == Channel::kShaded ? recipe.surface : SurfaceShader();
    defines += evaluatedQuads(recipe.sunlit, surface) + surfaceDefines(surface);
    if (surface.on) defines += "#define PASSES " + std::to_string(recipe.shading->term_passes) + "u\n";
    if (recipe.slots) defines += "#define HAS_SLOTS\n";
    const bool followers = recipe.asset.first_follower > 0 && showsVisibility(recipe.channel);
    if (followers)
        defines += define("FIRST_FOLLOWER", recipe.asset.first_follower) +
                   define("POINT_CORNERS", recipe.asset.point_corners) +
                   define("POINT_WEIGHTS", recipe.asset.point_weights);
    if (recipe.deforming) defines += "#define DEFORMING\n";
    if (recipe.channel == Channel::kShaded && recipe.shading->membranes) defines += "#define HAS_MEMBRANES\n";
    const bool composed = recipe.far && showsVisibility(recipe.channel);
    if (composed) {
        defines += farPlaces(*recipe.far) + define("CLUSTER_COUNT", recipe.clusters);
        if (recipe.residual) defines += "#define HAS_RESIDUAL\n";
    }
    if (recipe.first_indirect && (recipe.channel == Channel::kShaded || recipe.channel == Channel::kBouncedAmbient)) {
        const Vec3 w = recipe.bounced_ambient;
        defines += "#define BOUNCES\n" + define("FIRST_INDIRECT", *recipe.first_indirect) +
                   "#define BOUNCED_AMBIENT vec3(" + glslFloat(w.x) + ", " + glslFloat(w.y) + ", " + glslFloat(w.z) +
                   ")\n";
    }
    if (recipe.casts) defines += "#define CAST\n" + define("CAST_QUADS", kCastQuads);
    if (recipe.casts) defines += define("CAST_SETS", recipe.heights ? 2 : 1);
    std::string generated;
    if (showsVisibility(recipe.channel)) generated = ambientGlsl(recipe.convention);
    if (followers) generated += followGlsl(recipe.convention);
    if (recipe.casts) generated += castAmbientGlsl() + castCoefficientsGlsl(recipe.convention);
    if (recipe.channel == Channel::kShaded) generated += shadingGlsl(*recipe.shading);
    if (recipe.sunlit) generated += sightGlsl(recipe.convention);
    // penumbra.glsl goes after the functions that the text has generated and the buffers that its macros name.
    std::string text = kShaderEvaluateComp;
    insertAt(text, "GENERATED_BY_SHADING_GLSL",
             generated + kShaderPenumbraGlsl + "\n" + (composed ? recipe.far_functions + kShaderFarGlsl + "\n" : ""));
    return preamble(recipe.channel) + defines + text;
}

std::string valueVertexSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface) {
    return preamble(channel) + interpolation(channel) + (sunlit ? kSunlit : "") + surfaceDefines(surface) +
           (sunlit || surface.slopes > 0 ? "#define HAS_NORMALS\n" : "") + kShaderValueVert;
}

std::string evaluatedVertexSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface) {
    return preamble(channel) + interpolation(channel) + evaluatedQuads(sunlit != 0, surface) + surfaceDefines(surface) +
           kShaderEvaluatedVert;
}

std::string skyVertexSource() { return preamble(Channel::kShaded) + kShaderSkyVert; }

std::string skyFragmentSource() {
    return preamble(Channel::kShaded) + define("SUN_MAX_SUNS", kMaxSuns) + kShaderDisplayGlsl + kShaderSkyGlsl +
           kShaderSkyFrag;
}

std::string channelFragmentSource(Channel channel, BrdfModels sunlit, const SurfaceShader& surface) {
    std::string suns;
    if (sunlit && surface.on)
        for (const BrdfModel model : {BrdfModel::kPrincipledDiffuse, BrdfModel::kGgxF0, BrdfModel::kGgxF90})
            sunlit |= 1u << int(model);
    if (sunlit) suns = kSunlit + brdfGlsl(sunlit) + sunGlsl() + kShaderSkyGlsl + kShaderSunlightGlsl;
    if (sunlit & kMembranes) suns.insert(0, "#define SUN_MEMBRANES\n");
    if ((sunlit & ~kMembranes) == 1u << int(BrdfModel::kLambert)) suns.insert(0, "#define SUN_LAMBERT\n");
    if (sunlit >> int(BrdfModel::kMirror) & 1) suns.insert(0, "#define SUN_MIRRORS\n");
    const std::string textured = surface.on ? surfaceDefines(surface) + kShaderSurfaceGlsl : "";
    return preamble(channel) + interpolation(channel) + textured + suns + kShaderDisplayGlsl + kShaderChannelFrag;
}

}  // namespace penumbra
