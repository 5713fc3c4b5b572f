#include "player/shader_source.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "player/runtime/light_lobes.h"
#include "player/sh_glsl.h"
#include "player_shaders.h"
#include "sh/reflectance.h"
#include "sh/sh_product.h"

namespace penumbra {

static std::size_t sliceIndex(const SliceLayout& layout, int channel, int k, int e) {
    const int views = layout.view_order * (layout.view_order + 1) / 2;
    return std::size_t((channel * coefficientCount(layout.slice_order) + k) * views + e);
}

SliceLayout sliceLayout(const MaterialView& material) {
    SliceLayout layout{material.slice_order, material.view_order, material.channels, {}};
    float largest = 0;
    for (const float c : material.slices) largest = std::max(largest, std::abs(c));
    const float zero = 1e-7f * largest;  // a float's resolution: what a fit leaves where symmetry has an exact zero
    const int views = layout.view_order * (layout.view_order + 1) / 2;
    for (int k = 0; k < coefficientCount(layout.slice_order); ++k)
        for (int e = 0; e < views; ++e) {
            float value = 0;
            for (int channel = 0; channel < layout.channels; ++channel)
                value = std::max(value, std::abs(material.slices[sliceIndex(layout, channel, k, e)]));
            if (value > zero) layout.entries.push_back({k, e});
        }
    return layout;
}

std::vector<float> slicesBlock(const SliceLayout& layout, const MaterialView& material) {
    std::vector<float> block = {material.color.x, material.color.y, material.color.z, 0};
    const std::size_t width = layout.channels == 3 ? 4 : 1;  // a vec4 an entry for RGB, else four entries a vec4
    for (const SliceLayout::Entry& entry : layout.entries)
        for (std::size_t i = 0; i < width; ++i)
            block.push_back(int(i) < layout.channels ? material.slices[sliceIndex(layout, int(i), entry.k, entry.e)]
                                                     : 0);
    block.resize((block.size() + 3) / 4 * 4);
    return block;
}

std::vector<float> lightBlock(const LightView& light) {
    const LightLobes lobes = makeLightLobes(light);
    std::vector<float> block;
    for (const auto& vectors : {lobes.directions, lobes.weights})
        for (const Vec3& v : vectors) block.insert(block.end(), {v.x, v.y, v.z, 0});
    return block;
}

static std::string preamble(Channel channel) {
    std::string text = "#version 430 core\n";
    const char* names[] = {"SHADED", "AO", "ERROR", "CLUSTERS", "NORMALS"};  // in the order of Channel
    for (int i = 0; i < 5; ++i) text += std::string("#define CHANNEL_") + names[i] + " " + std::to_string(i) + "\n";
    text += "#define CHANNEL " + std::to_string(int(channel)) + "\n";
    // Centroid: at a silhouette, values at a covered point and not extrapolated beyond the triangle.
    return text + "#define INTERPOLATION " + (channel == Channel::kClusters ? "flat" : "centroid") + "\n";
}

// "numbers[2].w": number i of a vertex in numbersOf()'s array.
static std::string number(std::size_t i) { return "numbers[" + std::to_string(i / 4) + "]." + "xyzw"[i % 4]; }

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
        ambient += "\n        + " + glslFloat(weights[i]) + " * " + number(i);
        clamp += "    " + number(i) + " -= " + glslFloat(weights[i] / norm2) + " * excess;\n";
    }
    return ambient + ";\n}\n" + clamp + "}\n";
}

// f_k = sum over e of C_ke y_e, for every k that has an entry; `type` is float or vec3 (a slice a colour channel).
static std::string sliceGlsl(const SliceLayout& layout, const std::string& type) {
    const std::vector<int> even = evenIndices(layout.view_order);
    std::vector<std::string> terms(std::size_t(coefficientCount(layout.slice_order)));
    for (std::size_t i = 0; i < layout.entries.size(); ++i) {
        const SliceLayout::Entry& entry = layout.entries[i];
        const std::string value = layout.channels == 3 ? "slices[" + std::to_string(i) + "].rgb"
                                                       : "slices[" + std::to_string(i / 4) + "]." + "xyzw"[i % 4];
        std::string& sum = terms[std::size_t(entry.k)];
        sum += (sum.empty() ? "" : " + ") + value + " * e" + std::to_string(even[std::size_t(entry.e)]);
    }
    std::string text;
    for (std::size_t k = 0; k < terms.size(); ++k)
        if (!terms[k].empty()) text += "    " + type + " f" + std::to_string(k) + " = " + terms[k] + ";\n";
    return text;
}

// t_i = sum over j of v_j (sum over k of Gamma_ijk f_k), grouped so that a visibility number is multiplied once a row.
static std::string productGlsl(const ShaderRecipe& recipe, const std::string& type) {
    std::vector<int> number_of_index(std::size_t(coefficientCount(recipe.convention.order)), -1);
    const std::vector<int> indices = recipe.convention.indices();
    for (std::size_t i = 0; i < indices.size(); ++i) number_of_index[std::size_t(indices[i])] = int(i);
    std::vector<bool> used(std::size_t(coefficientCount(recipe.slices.slice_order)));
    for (const SliceLayout::Entry& entry : recipe.slices.entries) used[std::size_t(entry.k)] = true;

    const auto& gamma = tripleProduct(recipe.light_order, recipe.convention.order, recipe.slices.slice_order);
    std::string text;
    auto entry = gamma.begin();
    for (int i = 0; i < coefficientCount(recipe.light_order); ++i) {
        std::string sum = type + "(0.0)";
        while (entry != gamma.end() && entry->i == i) {
            const int j = entry->j, n = number_of_index[std::size_t(j)];
            std::string inner;
            for (; entry != gamma.end() && entry->i == i && entry->j == j; ++entry)
                if (n >= 0 && used[entry->k])
                    inner += (inner.empty() ? "" : " + ") + glslFloat(entry->value) + " * f" + std::to_string(entry->k);
            if (!inner.empty()) sum += "\n        + " + number(std::size_t(n)) + " * (" + inner + ")";
        }
        text += "    " + type + " t" + std::to_string(i) + " = " + sum + ";\n";
    }
    return text;
}

// L = sum over lobes d and bands l of w_dl sum over m of y_lm(Q s_d) t_lm (light_lobes.h).
static std::string lightGlsl(int order) {
    std::string text = "    vec3 radiance = vec3(0.0);\n    for (int d = 0; d < " + std::to_string(2 * order - 1) +
                       "; ++d) {\n    vec3 s = local_from_model * lobe_direction[d].xyz;\n" +
                       basisGlsl(order, false, "y", "s");
    for (int band = 0; band < order; ++band) {
        text += "    radiance += lobe_weight[d * " + std::to_string(order) + " + " + std::to_string(band) + "].rgb * (";
        for (int i = band * band; i < (band + 1) * (band + 1); ++i)
            text += (i == band * band ? "" : " + ") + ("y" + std::to_string(i)) + " * t" + std::to_string(i);
        text += ");\n";
    }
    return text + "    }\n    return material_color.rgb * radiance;\n";
}

static std::string shadeGlsl(const ShaderRecipe& recipe) {
    const std::string type = recipe.slices.channels == 3 ? "vec3" : "float";
    const std::size_t entries = recipe.slices.entries.size();
    const std::size_t texels = std::max<std::size_t>(1, recipe.slices.channels == 3 ? entries : (entries + 3) / 4);
    const int lobes = 2 * recipe.light_order - 1;
    return "layout(std140) uniform Slices { vec4 material_color; vec4 slices[" + std::to_string(texels) + "]; };\n" +
           "layout(std140) uniform Light { vec4 lobe_direction[" + std::to_string(lobes) + "]; vec4 lobe_weight[" +
           std::to_string(lobes * recipe.light_order) + "]; };\n" +
           "vec3 shade(vec4 numbers[STRIDE4], vec3 to_eye, mat3 local_from_model) {\n" +
           basisGlsl(recipe.slices.view_order, true, "e", "to_eye") + sliceGlsl(recipe.slices, type) +
           productGlsl(recipe, type) + lightGlsl(recipe.light_order) + "}\n";
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
    if (recipe.channel == Channel::kShaded) generated += shadeGlsl(recipe);
    std::string text = kShaderEvaluateVert;
    const std::string mark = "\nGENERATED\n";
    text.replace(text.find(mark), mark.size(), "\n" + generated + "\n");
    return preamble(recipe.channel) + defines + text;
}

std::string valueVertexSource(Channel channel) { return preamble(channel) + kShaderValueVert; }

std::string channelFragmentSource(Channel channel) { return preamble(channel) + kShaderChannelFrag; }

}  // namespace penumbra
