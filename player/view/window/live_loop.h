#pragma once
// The window of penumbra-player view --plate: characters in photographs as they come.
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "player/composite/live_light.h"
#include "player/frame/render_options.h"

namespace penumbra {

struct LiveOptions {
    std::filesystem::path scene, plate;       // arguments of LivePlates
    std::vector<TagChoice> tags;              // none: the scene says where the camera stands
    std::string response = "srgb";            // response of the camera: a name, or a file
    double exposure = 1;                      // light of 1 times it has the highest code
    std::optional<LiveBall> ball;             // ball whose light replaces the scene's
    std::optional<std::pair<int, int>> size;  // size of the window; unset: the photographs' size
    std::filesystem::path screenshots = ".";  // folder
    std::optional<std::size_t> pictures;      // ends after so many; unset: when the user quits
    RenderOptions look;                       // suns, sun_map
};

struct LiveResult {
    std::string gl;
    std::size_t pictures = 0, seen = 0;  // shown, and those with a tag
    double track = 0, compose = 0;       // milliseconds a picture: mean
    double latency = 0;                  // from when a picture was taken, or asked for, until it was shown: mean
};

// Returns when the user quits, or when a stream ends. Throws what reading throws, and Unsupported without a display.
LiveResult runLive(const LiveOptions& options, int threads);

}  // namespace penumbra
