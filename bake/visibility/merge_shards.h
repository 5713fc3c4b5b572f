#pragma once
// Merges shards of one bake, which were made anywhere by --frames and --clips. The merge checks them first. It then
// writes the very file that the bake would have made in one go.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/common/bake_options.h"
#include "formats/common/progress.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Tells what the unsplit bake was told. Without `clips` that is what all shards were told if they agree, and
// otherwise nothing, which means all clips.
struct MergeOptions {
    std::vector<std::string> clips = {};
    std::optional<FrameRange> frames = {};
};

// Lists why shards do not make a whole. Every list is empty when they do.
struct MergeProblems {
    std::vector<std::string> unreadable;   // "a.vis.h5: cannot read: No such file or directory": sentences
    std::vector<std::string> unusable;     // "b.vis.h5: /frames/time: damaged": such a shard has to be baked again
    std::vector<std::string> unsupported;  // files of a newer format
    std::vector<std::string> different;    // "c.vis.h5: rays 64, not 128"
    std::vector<ClipFrame> missing;        // frames of the whole that no readable shard has
    std::vector<std::string> twice;        // "'walk' 3:5 in a.vis.h5 and b.vis.h5"
    std::vector<std::string> beyond;       // frames of clips or ranges that are no part of the whole
    // Tells whether there is any problem.
    bool any() const;
    std::string sentence() const;  // one line that names all problems, at most a dozen of each kind
    // Throws with that sentence: Unsupported or IoError where such shards, and the frames missing with them, are all
    // that is wrong, and InvalidInput otherwise.
    [[noreturn]] void raise() const;
};

struct MergePlan {
    VisibilityHeader header;  // header of the whole file
    Precision precision = Precision::kFloat32;
    std::vector<std::filesystem::path> shards;  // the shards that can be read
    std::vector<std::uint32_t> frames_of_shard;
    bool is_virtual = false;          // a shard is an index of other files
    std::vector<FrameSource> source;  // [F] of the whole: where each frame comes from
    MergeProblems problems;           // if there are any, `source` is incomplete
};
// Opens every shard once, one after the other, and plans the merge. Throws UsageError when the options ask for clips
// or frames that these shards cannot give. Without any shard that can be read, the plan knows neither the whole nor
// what is missing from it.
MergePlan planMerge(const std::vector<std::filesystem::path>& shards, const MergeOptions& options);

// Reads the frames of all shards of `plan` and compares their checksums. Adds the damaged shards to the plan's
// problems.
void findDamage(MergePlan& plan);

// Writes the merged file, byte-identical to the unsplit bake. Memory holds a few blocks of frames, however many
// shards there are. `plan` must be without problems. Throws InvalidInput for the first shard whose data are damaged.
void writeMerged(const MergePlan& plan, const std::filesystem::path& output, ProgressStyle progress);

// Writes an index of the shards instead, which holds the same frames. The shards have to stay where they are, seen
// from the output. The function reads every shard through. If some are damaged it adds them to the problems of `plan`
// and writes nothing. Throws UsageError when a shard is such an index itself.
void writeIndex(MergePlan& plan, const std::filesystem::path& output, int threads);

}  // namespace penumbra
