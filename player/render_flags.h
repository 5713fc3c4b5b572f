#pragma once
// The flags of `penumbra-player render`, and what they say together.
#include "player/cast_flags.h"
#include "player/frames_flags.h"

namespace penumbra {

struct RenderCommand {
    std::vector<std::filesystem::path> assets;  // several stand side by side, which is a scene
    std::filesystem::path scene, truth, output;
    std::optional<double> time;      // for a scene, seconds
    CastWay cast;                    // for a scene
    std::filesystem::path compared;  // for a scene: a picture of it by brute force
    RenderOptions options;
    FramesFlags frames;
    const CLI::App* app = nullptr;  // tells which options were given

    bool isScene() const { return !scene.empty() || assets.size() > 1; }
    std::vector<std::filesystem::path> inputs() const;
};

void defineRender(CLI::App& app, RenderCommand& command);
// Finishes what the options say together. Throws UsageError where the result would be another one than asked for, and
// warns of options that change nothing.
void checkRender(RenderCommand& command);

}  // namespace penumbra
