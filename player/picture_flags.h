#pragma once
// The flags of a picture: what it shows, from where, and how large it is.
#include "formats/common/options.h"
#include "player/frame/render_options.h"

namespace penumbra {

constexpr const char* kPictureGroup = "Picture";
constexpr const char* kOverlayGroup = "Drawn over a picture of one asset";

// Where vertices are evaluated: render and view have this.
inline void addPathFlag(CLI::App& app, std::optional<EvaluationPath>& path) {
    addChoice(app, "--path", path, kPathWords, "where vertices are evaluated; auto: on a GPU, but not on software GL")
        ->group(kPictureGroup);
}

// Render and bench have these.
inline void addTargetFlags(CLI::App& app, RenderOptions& options) {
    addSize(app, options.width, options.height)->group(kPictureGroup);
    addChoice(app, "--aa", options.samples, kSampleWords, "samples a pixel")->group(kPictureGroup);
    addChoice(app, "--gl", options.backend, kGlWords, "what draws; auto: a GPU, else software")->group(kPictureGroup);
}

inline void addPictureFlags(CLI::App& app, RenderOptions& options) {
    addTargetFlags(app, options);
    app.add_option("--camera", options.camera,
                   "yaw=,pitch=,fov= (degrees), distance=,target=X/Y/Z; what is not given is framed")
        ->group(kPictureGroup);
    addChoice(app, "--channel", options.channel, kChannelWords, "what the picture shows")->group(kPictureGroup);
    addPathFlag(app, options.path);
    const auto background = [&options](const std::string& text) {
        options.light_background = text == "light";
        return options.light_background ? std::nullopt : readBackground(text);
    };
    addParsed(app, "--background", options.background, background,
              "transparent, R/G/B (linear), or light: what the light looks like, behind a shaded picture")
        ->default_str("transparent")
        ->group(kPictureGroup);
    app.add_option("--error-max", options.error_max,
                   "the error that gets the brightest colour of --channel error or transfer-error")
        ->check(aboveZero())
        ->group(kPictureGroup);
}

inline void addOverlayFlags(CLI::App& app, RenderOptions& options) {
    CLI::Option* lobe = app.add_option("--lobe", options.lobe, "a vertex, from 0, whose visibility is drawn as a lobe")
                            ->check(within<std::int64_t>(0, UINT32_MAX))
                            ->group(kOverlayGroup);
    app.add_option("--lobe-of", options.lobe_of,
                   "which part of a composed visibility: whole, local, far, residual, or the visibility past one far "
                   "part (its joint, or a beginning of it that no other has)")
        ->needs(lobe)
        ->group(kOverlayGroup);
    addNameListOption(app, "--boxes", options.boxes,
                      "draw the boxes of the fields of these parts of a composed asset (their joints, or "
                      "beginnings that no other has), or all")
        ->group(kOverlayGroup);
}

}  // namespace penumbra
