#pragma once
// The flags of `penumbra-player render`, and what they say together.
#include "formats/common/command_line.h"
#include "player/cast_flags.h"
#include "player/render/render_sheet.h"

namespace penumbra {

struct RenderCommand {
    std::vector<std::filesystem::path> assets;  // several stand side by side, which is a scene
    std::filesystem::path scene, truth, output, csv;
    double time = 0;                 // of a scene, seconds
    CastFlags cast;                  // of a scene
    std::filesystem::path compared;  // of a scene: a picture of it by brute force
    RenderOptions options;
    FrameChoice choice;
    Framing framing = Framing::kFrame;
    SheetOptions sheet;
    std::optional<ErrorGate> gate;
    bool flip = false;
    bool batch = false;  // the user asks for more than one picture of one frame

    bool isScene() const { return !scene.empty() || assets.size() > 1; }
    bool draws() const;       // tells whether the run needs OpenGL
    bool imageError() const;  // tells whether pictures of model and truth are compared

    // Values as the user typed them.
    std::string frames, framing_word, fail_figure = "ambient-mean", fail_per = "frame";
    double fail_above = 0, fail_percent = 0;
    std::vector<std::string> panels;
    std::string size, channel = "shaded", source = "model", path = "auto", backend = "auto", background = "transparent";
    std::string reflectance = "slices", light_form = "auto", suns = "auto", bounces = "both";
    std::size_t lobe = 0;
    // Options that only --channel shaded, pictures, -o, --sheet and --fail-above read.
    std::vector<const CLI::Option*> shading, picture, overlay, sheet_only, gate_only;
    const CLI::Option *frame_option = nullptr, *source_option = nullptr, *error_max_option = nullptr,
                      *fail_option = nullptr, *lobe_option = nullptr, *lobe_of_option = nullptr, *time_option = nullptr,
                      *compare_option = nullptr;
    // What only a picture of one asset reads, what one of any assets does, and what only one of a scene does.
    std::vector<const CLI::Option*> asset_only, not_of_files, scene_only;
};

void defineRender(CLI::App& app, RenderCommand& command);
// Sets everything above "Values as the user typed them" from what stands below. Throws UsageError, which names option
// and value.
void parseRender(RenderCommand& command);

}  // namespace penumbra
