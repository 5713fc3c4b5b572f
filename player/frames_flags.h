#pragma once
// The flags that choose the frames of one asset.
#include "formats/common/options.h"
#include "player/render/render_batch.h"

namespace penumbra {

constexpr const char* kFramesGroup = "Frames of one asset";

struct FramesFlags {
    FrameChoice choice;
    std::optional<Framing> framing;  // unset: clips for the files of a sequence, else frame
};

inline void addFramesFlags(CLI::App& app, FramesFlags& flags) {
    app.add_option("--clip", flags.choice.clips,
                   "name of a clip, or a beginning of it that no other has; any number of them, or all (default: the "
                   "first for one frame, all for a sequence)")
        ->allow_extra_args(false)
        ->group(kFramesGroup);
    CLI::Option* frame = app.add_option("--frame", flags.choice.frame, "one sampled frame of the clip, from 0")
                             ->check(within(0, INT_MAX))
                             ->default_str("0")
                             ->group(kFramesGroup);
    addFrames(app, flags.choice.frames,
              "A:B or A:B:S, half-open: a sequence of the sampled frames of all chosen clips, counted in order")
        ->excludes(frame)
        ->group(kFramesGroup);
    addChoice(app, "--framing", flags.framing, kFramingWords,
              "clips: one camera that holds all frames of the chosen clips; clip: one a clip; frame: each frame as it "
              "is framed alone (default: clips for the pictures of a sequence, else frame)")
        ->group(kFramesGroup);
}

}  // namespace penumbra
