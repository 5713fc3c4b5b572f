#include "player/shader_source.h"

#include <numeric>

#include "player/sh_glsl.h"
#include "player/shading_glsl.h"
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

// ambientOf() and clampAmbient() (sh/visibility_convention.h).
static std::string ambientGlsl(const Convention& convention) {
    std::vector<float> weights(std::size_t(convention.size()));
    ambientWeights(convention, weights);
    const float norm2 = std::inner_product(weights.begin(), weights.end(), weights.begin(), 0.0f);
    std::string ambient = "float ambientOf(vec4 numbers[STRIDE4]) {\n    return 0.0";
    std::string clamp =
        "void clampAmbient(inout vec4 numbers[STRIDE4]) {\n    float e = ambientOf(numbers);\n"
        "    float excess = min(e, 0.0) + max(e - 1.0, 0.0);\n";
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (weights[i] == 0) continue;
        ambient += "\n        + " + glslFloat(weights[i]) + " * " + numberGlsl(i);
        clamp += "    " + numberGlsl(i) + " -= " + glslFloat(weights[i] / norm2) + " * excess;\n";
    }
    return ambient + ";\n}\n" + clamp + "}\n";
}

std::string evaluateVertexSource(const ShaderRecipe& recipe) {
    std::string defines = "#define INFLUENCES " + std::to_string(recipe.influences) + "\n#define STRIDE4 " +
                          std::to_string(recipe.stride / 4) + "\n";
    if (recipe.numbers_given) defines += "#define NUMBERS_GIVEN\n";
    if (recipe.mean == ArrayFormat::kScaledBytes) defines += "#define MEAN_I8\n";
    if (recipe.basis == ArrayFormat::kScaledBytes) defines += "#define BASIS_I8\n";
    std::string generated;
    if (recipe.channel != Channel::kNormals && recipe.channel != Channel::kClusters)
        generated = ambientGlsl(recipe.convention);
    if (recipe.channel == Channel::kShaded) generated += shadingGlsl(*recipe.shading);
    std::string text = kShaderEvaluateVert;
    const std::string mark = "\nGENERATED\n";
    text.replace(text.find(mark), mark.size(), "\n" + generated + "\n");
    return preamble(recipe.channel) + defines + text;
}

std::string valueVertexSource(Channel channel) { return preamble(channel) + kShaderValueVert; }

std::string channelFragmentSource(Channel channel) { return preamble(channel) + kShaderChannelFrag; }

}  // namespace penumbra
