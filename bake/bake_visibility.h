#pragma once
// The stage: rig in, x.vis.h5 out, one frame after the other in bounded memory.
#include <filesystem>
#include <vector>

#include "bake/bake_options.h"
#include "formats/progress.h"
#include "formats/rig_file.h"

namespace penumbra {

// What a bake will do, known before any ray is traced.
struct BakePlan {
    Rig rig;
    double rest_diagonal = 0;  // of the rest pose in the model frame: the unit of `bias`
    VisibilityHeader header;
    std::vector<int> rig_clip;  // [C] index into rig.clips of each of header.frames' clips; -1 = rest pose

    double rays() const;            // upper bound: every direction above the horizon of every vertex and frame
    double bytes(Precision) const;  // of the output before compression
};
// Reads the rig and chooses the frames. UsageError, IoError, InvalidInput.
BakePlan planBake(const std::vector<std::filesystem::path>& rigs, const BakeOptions& options);

struct BakeResult {
    double rays_traced = 0;
    double seconds = 0;        // of tracing; reading the rig is not in it
    double written_bytes = 0;  // the file
};
// Traces and writes. The same bytes for any number of threads. A pose with a position that is not finite is
// InvalidInput; throws Interrupted within a second of a signal and leaves no file.
BakeResult bakeVisibility(const BakePlan& plan, const BakeOptions& options, const std::filesystem::path& output,
                          int threads, ProgressStyle progress);

}  // namespace penumbra
