#pragma once
// GLSL text: the files of player/shaders/ with a preamble, and the sums over SH functions, slices and Gamma written out
// for one convention, light order and material layout.
#include <string>
#include <vector>

#include "formats/asset_file.h"
#include "player/channel.h"

namespace penumbra {

// The entries of a material's slices that are not zero (an isotropic one has 65 of 375), in a fixed order: the text
// refers to them by position, so that materials of one layout share a program.
struct SliceLayout {
    struct Entry {
        int k, e;  // slice coefficient, z-even function of the view direction
        bool operator==(const Entry&) const = default;
    };
    int slice_order = 0, view_order = 0, channels = 1;
    std::vector<Entry> entries;
    bool operator==(const SliceLayout&) const = default;
};
SliceLayout sliceLayout(const MaterialView& material);

// How one of the model's arrays lies in its texture buffer.
enum class ArrayFormat { kFloat, kScaledBytes };  // half floats read as floats

struct ShaderRecipe {
    Channel channel = Channel::kShaded;
    Convention convention;
    int stride = 0, influences = 0;
    bool numbers_given = false;  // by a buffer instead of the model
    ArrayFormat mean = ArrayFormat::kFloat, basis = ArrayFormat::kFloat;
    int light_order = 1;  // kShaded only, as is `slices`
    SliceLayout slices;
};

std::string evaluateVertexSource(const ShaderRecipe& recipe);
std::string valueVertexSource(Channel channel);
std::string channelFragmentSource(Channel channel);

// Contents of the uniform blocks "Slices" (colour of the material included) and "Light", std140.
std::vector<float> slicesBlock(const SliceLayout& layout, const MaterialView& material);
std::vector<float> lightBlock(const LightView& light);

}  // namespace penumbra
