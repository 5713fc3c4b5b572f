#pragma once
// Shards of one bake, made anywhere by --frames and --clips: checked, then put together to the very file that the bake
// would have made in one go.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/bake_options.h"
#include "formats/progress.h"
#include "formats/visibility_file.h"

namespace penumbra {

// What the unsplit bake was told. Without `clips`: what all shards were told if they agree, else nothing (all clips).
struct MergeOptions {
    std::vector<std::string> clips = {};
    std::optional<FrameRange> frames = {};
};

// Why shards do not make a whole; every list is empty when they do.
struct MergeProblems {
    std::vector<std::string> different;  // "b.vis.h5: rays 64, not 128": sentences
    std::vector<ClipFrame> missing;
    std::vector<std::string> twice;   // "'walk' 3:5 in a.vis.h5 and b.vis.h5"
    std::vector<std::string> beyond;  // frames of clips or ranges that the whole has not
    bool any() const { return !(different.empty() && missing.empty() && twice.empty() && beyond.empty()); }
    std::string sentence() const;  // one line that names them all, at most a dozen ranges of each kind
};

struct MergePlan {
    VisibilityHeader header;  // of the whole
    Precision precision = Precision::kFloat32;
    std::vector<std::filesystem::path> shards;
    std::vector<std::uint32_t> frames_of_shard;
    bool is_virtual = false;          // a shard is an index of other files
    std::vector<FrameSource> source;  // [F] of the whole
    MergeProblems problems;           // when there are any, `source` is incomplete
};
// Opens every shard once, one after the other. IoError, InvalidInput and UsageError for what cannot be compared at all.
MergePlan planMerge(const std::vector<std::filesystem::path>& shards, const MergeOptions& options);

// Byte-identical to the unsplit bake. Memory: a few blocks of frames, however many shards. `plan` without problems.
void writeMerged(const MergePlan& plan, const std::filesystem::path& output, ProgressStyle progress);

// The same frames as an index of the shards, which have to stay where they are, seen from the output. Every shard is
// read through: InvalidInput names one whose data are damaged. UsageError when a shard is such an index itself.
void writeIndex(const MergePlan& plan, const std::filesystem::path& output, int threads);

}  // namespace penumbra
