#pragma once
// The stage "bake": it reads a rig or a point cache and writes x.vis.h5, frame by frame in bounded memory.
#include <filesystem>
#include <string>
#include <vector>

#include "bake/common/bake_options.h"
#include "bake/source/continuous_angles.h"
#include "bake/source/extra_inputs.h"
#include "bake/trace/blockers.h"
#include "bake/trace/local_parts.h"
#include "bake/visibility/bake_journal.h"
#include "formats/common/progress.h"

namespace penumbra {

// The plan tells what a bake will do, before any ray is traced.
struct BakePlan {
    BakeSource source;
    std::vector<std::filesystem::path> files_read;  // all of them, for provenance and depfiles
    // [V] the vertices of the source that are baked, ascending, where header.mesh is a choice of them; else empty
    std::vector<std::uint32_t> chosen;
    double rest_diagonal = 0;  // diagonal of the rest pose in the model frame; the unit of `bias`
    VisibilityHeader header;
    std::string albedo_from;                      // surface_colors.h; empty without bounces
    std::vector<std::filesystem::path> pictures;  // files from which the albedo was read
    std::vector<int> source_clip;                 // [C] the source's clip of each of header.frames' clips; -1 = at rest
    float bias = 1e-4f;
    std::vector<float> far_bias;  // far_bias.h; mostly empty
    // Set with a point cache, sheets or occluders: rays start by the rules of ray_start.h where `blockers` says so.
    bool sheet_rules = false;
    Blockers blockers;
    std::vector<std::uint32_t> places;  // BakeSource::places() of a rig: rays over its solids start by start_ways.h
    std::optional<LocalParts> local;    // set with header.local
    std::vector<Occluder> occluders;    // their clips go with header.frames.clip_names
    ExtraInputs inputs;
    std::vector<std::vector<EdgeTurns>> turns;  // [F] of a point cache, else empty

    // The character that blocks rays: all of it, whatever is chosen.
    const Mesh& occluder() const { return header.drawn ? header.drawn->mesh : header.mesh; }
    std::vector<std::string> notes() const;  // notes of the source and of the occluders, one line each
    double rays() const;                     // upper bound: every direction above the horizon of every vertex and frame
    double bytes(Precision) const;           // size of the output before compression
};
// Reads the source and chooses the frames. Throws UsageError, IoError and InvalidInput.
BakePlan planBake(const std::vector<std::filesystem::path>& paths, const BakeOptions& options);

struct BakeTarget {
    std::filesystem::path output;
    Journal journal = Journal::kFresh;  // kResume: go on from the journal of a killed bake, and keep ours when stopped
                                        // (bake_journal.h)
};

struct BakeResult {
    double rays_traced = 0;
    double seconds = 0;           // time to trace, without the time to read the rig
    double written_bytes = 0;     // size of the file
    std::size_t frames_kept = 0;  // frames that an earlier bake traced and the journal kept
    std::string note;             // about the journal; "" when there is nothing to tell
    // With bounces, means over all frames of VisibilityFrame::hit_shares.
    double hit_share = 0, back_share = 0;
    // Mean over all frames and vertices of how much of the hemisphere is open, of transfer weighted by the cosine.
    double open_share = 0;
};

// Returns coefficient 0 of a quantity where nothing blocks. With y_0 = 1 / sqrt(4 pi), that of visibility is y_0 times
// the integral of V, 2 pi. The mirrored one is twice that. That of transfer is y_0 times the integral of the cosine,
// pi.
double unblockedOf(const std::string& quantity);

// Traces and writes. The file holds the same bytes for any number of threads. Throws InvalidInput for a pose with a
// position that is not finite. Throws Interrupted within a second of a signal and then leaves no output.
BakeResult bakeVisibility(const BakePlan& plan, const BakeOptions& options, const BakeTarget& target, int threads,
                          ProgressStyle progress);

// Tells whether the file under this name is what the bake would make: it has the same inputs by content, the same
// options and version, and all of its data agree with their checksums. The function reads the whole file for that,
// and `damage` says what is wrong with a file that does not pass. Throws Interrupted.
bool isWhole(const std::filesystem::path& output, const BakePlan& plan, std::string& damage);

}  // namespace penumbra
