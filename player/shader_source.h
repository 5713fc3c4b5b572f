#pragma once
// GLSL text: the files of player/shaders/ with a preamble, and the sums over SH functions written out for one
// convention and shading layout.
#include <string>

#include "player/channel.h"
#include "player/runtime/shading_layout.h"

namespace penumbra {

// How one of the model's arrays lies in its texture buffer.
enum class ArrayFormat { kFloat, kScaledBytes };  // half floats read as floats

struct ShaderRecipe {
    Channel channel = Channel::kShaded;
    Convention convention;
    int stride = 0, influences = 0;
    bool numbers_given = false;  // by a buffer instead of the model
    ArrayFormat mean = ArrayFormat::kFloat, basis = ArrayFormat::kFloat;
    const ShadingLayout* shading = nullptr;  // kShaded only
};

std::string evaluateVertexSource(const ShaderRecipe& recipe);
std::string valueVertexSource(Channel channel);
std::string channelFragmentSource(Channel channel);

}  // namespace penumbra
