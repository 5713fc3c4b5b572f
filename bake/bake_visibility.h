#pragma once
// The stage: rig or point cache in, x.vis.h5 out, one frame after the other in bounded memory.
#include <filesystem>
#include <vector>

#include "bake/bake_options.h"
#include "bake/blockers.h"
#include "bake/continuous_angles.h"
#include "bake/extra_inputs.h"
#include "formats/common/progress.h"

namespace penumbra {

// What a bake will do, known before any ray is traced.
struct BakePlan {
    BakeSource source;
    std::vector<std::filesystem::path> files_read;  // all of them, for provenance and depfiles
    double rest_diagonal = 0;                       // of the rest pose in the model frame: the unit of `bias`
    VisibilityHeader header;
    std::vector<int> source_clip;  // [C] the source's clip of each of header.frames' clips; -1 = at rest
    float bias = 1e-4f;
    // Of a point cache, of a sheet and with occluders rays start by the rules of ray_start.h.
    bool sheet_rules = false;
    Blockers blockers;
    std::vector<Occluder> occluders;  // their clips go with header.frames.clip_names
    ExtraInputs inputs;
    std::vector<std::vector<EdgeTurns>> turns;  // [F] of a point cache

    double rays() const;            // upper bound: every direction above the horizon of every vertex and frame
    double bytes(Precision) const;  // of the output before compression
};
// Reads the source and chooses the frames. UsageError, IoError, InvalidInput.
BakePlan planBake(const std::vector<std::filesystem::path>& paths, const BakeOptions& options);

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

// Whether the file under this name is what the bake would make: same inputs by content, options and version, and all
// of its data right by their checksums, for which it is read through. `damage` says which are not. Throws Interrupted.
bool isWhole(const std::filesystem::path& output, const BakePlan& plan, std::string& damage);

}  // namespace penumbra
