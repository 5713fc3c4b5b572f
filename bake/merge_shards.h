#pragma once
// Shards of one bake, made anywhere by --frames and --clips: checked, then put together to the very file that the bake
// would have made in one go.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "formats/common/progress.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// What the unsplit bake was told. Without `clips`: what all shards were told if they agree, else nothing (all clips).
struct MergeOptions {
    std::vector<std::string> clips = {};
    std::optional<FrameRange> frames = {};
};

// Why shards do not make a whole; every list is empty when they do.
struct MergeProblems {
    std::vector<std::string> unreadable;   // "a.vis.h5: cannot read: No such file or directory": sentences
    std::vector<std::string> unusable;     // "b.vis.h5: /frames/time: damaged": to be baked again
    std::vector<std::string> unsupported;  // of a newer format
    std::vector<std::string> different;    // "c.vis.h5: rays 64, not 128"
    std::vector<ClipFrame> missing;        // those of shards that cannot be opened too
    std::vector<std::string> twice;        // "'walk' 3:5 in a.vis.h5 and b.vis.h5"
    std::vector<std::string> beyond;       // frames of clips or ranges that the whole has not
    bool any() const;
    std::string sentence() const;  // one line that names them all, at most a dozen of each kind
    // With the sentence: Unsupported or IoError where such shards, and frames missing with them, are all that is wrong,
    // else InvalidInput.
    [[noreturn]] void raise() const;
};

struct MergePlan {
    VisibilityHeader header;  // of the whole
    Precision precision = Precision::kFloat32;
    std::vector<std::filesystem::path> shards;  // that can be read
    std::vector<std::uint32_t> frames_of_shard;
    bool is_virtual = false;          // a shard is an index of other files
    std::vector<FrameSource> source;  // [F] of the whole
    MergeProblems problems;           // when there are any, `source` is incomplete
};
// Opens every shard once, one after the other. UsageError for what cannot be asked of them. Without a shard that can be
// read the whole is not known, nor what is missing.
MergePlan planMerge(const std::vector<std::filesystem::path>& shards, const MergeOptions& options);

// Reads the frames of all shards of `plan` through their checksums; adds those that are damaged to its problems.
void findDamage(MergePlan& plan);

// Byte-identical to the unsplit bake. Memory: a few blocks of frames, however many shards. `plan` without problems.
// InvalidInput for the first shard whose data are damaged.
void writeMerged(const MergePlan& plan, const std::filesystem::path& output, ProgressStyle progress);

// The same frames as an index of the shards, which have to stay where they are, seen from the output. Every shard is
// read through; where some are damaged they are added to the problems of `plan`, and nothing is written. UsageError
// when a shard is such an index itself.
void writeIndex(MergePlan& plan, const std::filesystem::path& output, int threads);

}  // namespace penumbra
