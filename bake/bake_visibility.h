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

struct BakeTarget {
    std::filesystem::path output;
    bool resume = false;  // go on from the journal of a killed bake, and keep ours when stopped (bake_journal.h)
};

struct BakeResult {
    double rays_traced = 0;
    double seconds = 0;           // of tracing; reading the rig is not in it
    double written_bytes = 0;     // the file
    std::size_t frames_kept = 0;  // of those, traced by a bake before
    std::string note;             // about the journal, or ""
};
// Traces and writes. The same bytes for any number of threads. A pose with a position that is not finite is
// InvalidInput; throws Interrupted within a second of a signal and leaves no output.
BakeResult bakeVisibility(const BakePlan& plan, const BakeOptions& options, const BakeTarget& target, int threads,
                          ProgressStyle progress);

// Whether the file under this name is what the bake would make: same inputs by content, options and version.
bool isWhole(const std::filesystem::path& output, const BakePlan& plan);

}  // namespace penumbra
