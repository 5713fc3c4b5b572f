#include "player/shader_source.h"

#include "player/runtime/shading_glsl.h"
#include "player_shaders.h"

namespace penumbra {

static std::string preamble(Channel channel) {
    std::string text = "#version 430 core\n";
    const char* names[] = {"SHADED", "AO", "ERROR", "CLUSTERS", "NORMALS"};  // in the order of Channel
    for (int i = 0; i < 5; ++i) text += std::string("#define CHANNEL_") + names[i] + " " + std::to_string(i) + "\n";
    text += "#define CHANNEL " + std::to_string(int(channel)) + "\n";
    // Centroid: at a silhouette, values at a covered point and not extrapolated beyond the triangle.
    return text + "#define INTERPOLATION " + (channel == Channel::kClusters ? "flat" : "centroid") + "\n";
}

// Where penumbra_shade() finds its texels in this program, and what each vertex has.
static std::string shadingDeclarations(const ShadingLayout& layout) {
    return "layout(location = 5) in uint slot;\nuniform samplerBuffer materials;\n"
           "uniform usamplerBuffer material_of_slot;\nuniform int slot_base;\n"
           "layout(std140) uniform Light { vec4 light[" +
           std::to_string(layout.lightTexels()) +
           "]; };\n#define PENUMBRA_MATERIAL(i) texelFetch(materials, i)\n#define PENUMBRA_LIGHT(i) light[i]\n";
}

std::string evaluateVertexSource(const ShaderRecipe& recipe) {
    std::string defines = "#define INFLUENCES " + std::to_string(recipe.influences) + "\n#define PENUMBRA_STRIDE4 " +
                          std::to_string(recipe.stride / 4) + "\n";
    if (recipe.numbers_given) defines += "#define NUMBERS_GIVEN\n";
    if (recipe.mean == ArrayFormat::kScaledBytes) defines += "#define MEAN_I8\n";
    if (recipe.basis == ArrayFormat::kScaledBytes) defines += "#define BASIS_I8\n";
    std::string generated;
    if (recipe.channel != Channel::kNormals && recipe.channel != Channel::kClusters)
        generated = ambientGlsl(recipe.convention);
    if (recipe.channel == Channel::kShaded)
        generated += shadingDeclarations(*recipe.shading) + shadingGlsl(*recipe.shading);
    std::string text = kShaderEvaluateVert;
    const std::string mark = "\nGENERATED\n";
    text.replace(text.find(mark), mark.size(), "\n" + generated + "\n");
    return preamble(recipe.channel) + defines + kShaderPenumbraGlsl + text;
}

std::string valueVertexSource(Channel channel) { return preamble(channel) + kShaderValueVert; }

std::string channelFragmentSource(Channel channel) { return preamble(channel) + kShaderChannelFrag; }

}  // namespace penumbra
