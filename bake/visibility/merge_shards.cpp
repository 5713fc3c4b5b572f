// Merges the shards of a bake.
//
// Problem: a farm bakes one animation as many files, each with some of the frames. Put them together to the very file
// that one bake would have made, byte by byte, and refuse anything that cannot be right: a shard with other options,
// a missing or a doubled frame, damaged data.
//
// Naive: append the files in the order of the command line. That order is the shell's, not the animation's, and with
// --frames a:b:step or --clips consecutive frames stand in different shards. Nothing would notice a shard that is
// missing.
//
// Here: every shard tells the clips that it was chosen from, their lengths, and the number of each of its frames in
// its clip (/shard in formats/README.md). From that and the options we list the frames of the whole, look up each
// shard's frames in that list, and see at once which are missing, doubled or beyond it. Only then frames are copied,
// in the whole's order, by readers that check the checksums. docs/formulas.md has no section on this, as nothing is
// computed.
#include "bake/visibility/merge_shards.h"

#include <algorithm>
#include <cassert>
#include <list>
#include <map>
#include <nlohmann/json.hpp>

#include "bake/source/frame_choice.h"
#include "formats/common/errors.h"
#include "formats/common/joined.h"
#include "formats/common/parallel_for.h"
#include "formats/common/sha256.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_check.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kBakeTool = "penumbra-bake visibility";
constexpr std::size_t kMaxListed = 12;  // of each kind of problem in a message; the report lists them all

// Holds what has to be known of a shard while the others are read.
struct Shard {
    std::string name;
    std::vector<std::string> told_clips;       // as --clips told this shard
    std::vector<std::string> clip_names;       // clips of its frames
    std::vector<std::uint16_t> clip;           // [F] index into clip_names
    std::vector<std::uint32_t> frame_in_clip;  // [F]
    std::vector<double> time;
    std::vector<ProvenanceInput> inputs;
};

// --- Sameness -------------------------------------------------------------------------------------------------------

bool sameSkin(const std::optional<Skin>& a, const std::optional<Skin>& b) {
    if (!a || !b) return a.has_value() == b.has_value();
    return a->joint_names == b->joint_names && a->parents == b->parents && a->influences == b->influences &&
           a->joints == b->joints && a->weights == b->weights;
}

bool sameChoice(const ShardPlace& a, const ShardPlace& b) {
    return a.clip_names == b.clip_names && a.clip_frames == b.clip_frames;
}

// Lists how a shard differs from the first one. Equal provenance implies equal values here, unless somebody edited a
// file.
std::vector<std::string> differencesOf(const VisibilityHeader& other, const VisibilityHeader& expected) {
    std::vector<std::string> out = differencesOf(other.provenance, expected.provenance, {"clips", "frames"});
    if (!out.empty()) return out;
    const auto check = [&](bool same, const char* what) {
        if (!same) out.push_back(what);
    };
    const Mesh &a = other.mesh, &b = expected.mesh;
    check(other.order == expected.order, "another SH order");
    check(other.quantity == expected.quantity, "another quantity");
    check(other.rays == expected.rays && other.seed == expected.seed && other.bounces == expected.bounces,
          "other attributes rays, seed, bounces");
    check(other.colors == expected.colors, "other colours");
    check(other.ground_y == expected.ground_y, "another ground_y");
    check(other.distance == expected.distance, "another distance");
    check(other.local == expected.local, "other local moments");
    check(a.triangles == b.triangles && a.rest_positions == b.rest_positions && a.source_vertex == b.source_vertex &&
              a.morphs == b.morphs && a.slots == b.slots && a.slot_of_vertex == b.slot_of_vertex &&
              other.rest_normals == expected.rest_normals,
          "another mesh");
    check(a.two_sided == b.two_sided, "another attribute two_sided");
    check(a.opacity == b.opacity, "another /mesh/opacity_triangles");
    check(sameSkin(other.skin, expected.skin), "another skin");
    check(other.pose_size == expected.pose_size && other.pose_parameterisation == expected.pose_parameterisation &&
              other.edges == expected.edges && other.input_names == expected.input_names,
          "another /frames/pose");
    check(sameChoice(*other.shard, *expected.shard), "another list of clips to choose from");
    return out;
}

// Returns the clips that --clips told the bake; an empty list means all of them.
std::vector<std::string> toldClips(const std::string& file, const Provenance& provenance) try {
    return Json::parse(provenance.options_json).at("clips").get<std::vector<std::string>>();
} catch (const nlohmann::json::exception&) {
    throw InvalidInput(file + ": attribute provenance: no list of clips in the options");
}

// Checks that a bake made the file. A whole bake counts as the only shard, and gets the place that such a shard has.
void completePlace(const std::string& file, VisibilityHeader& header) {
    if (header.provenance.tool != kBakeTool)
        throw InvalidInput(file + ": made by " + header.provenance.tool + ", not by " + kBakeTool);
    if (header.shard) return;
    if (!toldClips(file, header.provenance).empty() || Json::parse(header.provenance.options_json).contains("frames"))
        throw InvalidInput(file + ": /shard is missing, which tells where its frames belong; bake it again");
    header.shard = ShardPlace{header.frames.clip_names, framesOfClips(header.frames), numberInClip(header.frames)};
}

// --- The whole ------------------------------------------------------------------------------------------------------

// Returns the options of the unsplit bake: those of a shard with --clips and --frames replaced.
std::string wholeOptions(const std::string& shard_options, const std::vector<std::string>& clips,
                         const MergeOptions& options) {
    const Json shard = Json::parse(shard_options);
    Json whole{{"clips", clips}};
    for (const auto& [name, value] : shard.items()) {
        // The bake writes its options in a fixed order, "frames" after "fps", and the bytes shall be equal.
        if (name != "clips" && name != "frames") whole[name] = value;
        if (name == "fps" && options.frames)
            whole["frames"] = {options.frames->begin, options.frames->end, options.frames->step};
    }
    return whole.dump();
}

// Holds --clips of the unsplit bake, and the clips of its frames (with --poses those of the list come first).
struct ClipChoice {
    std::vector<std::string> told, names;
};

// Returns the clips as the frames name them: with --blocks a clip stands for its blocks.
std::vector<std::string> namesOfClips(const std::vector<std::string>& clips, const ShardPlace& place) {
    std::vector<std::string> names;
    for (const std::string& clip : clips) {
        const std::size_t before = names.size();
        if (place.clipNamed(clip) < 0)
            std::copy_if(place.clip_names.begin(), place.clip_names.end(), std::back_inserter(names),
                         [&](const std::string& name) { return clipOfBlock(name) == clip; });
        if (names.size() == before) names.push_back(clip);
    }
    return names;
}

// Shards that were all told the same clips were split by --frames, so that the whole was told these clips as well.
// Otherwise the options decide, and without them the whole has all clips.
ClipChoice clipsOfWhole(const std::vector<Shard>& shards, const ShardPlace& place, const MergeOptions& options) {
    const std::vector<std::string>& told = options.clips.empty() ? shards[0].told_clips : options.clips;
    if (std::all_of(shards.begin(), shards.end(), [&](const Shard& shard) { return shard.told_clips == told; }))
        return {told, shards[0].clip_names};
    return {options.clips, options.clips.empty() ? place.clip_names : namesOfClips(options.clips, place)};
}

// Lists the frames of the whole. Their times still have to come from the shards.
struct Whole {
    FrameList frames;
    std::vector<std::uint32_t> frame_in_clip;
};

// Lists all frames of the named clips and takes the range of --frames from that list.
Whole listWhole(const ShardPlace& place, const std::vector<std::string>& names, const MergeOptions& options) {
    FrameList all{names, {}, {}};
    for (std::size_t c = 0; c < all.clip_names.size(); ++c) {
        const int known = place.clipNamed(all.clip_names[c]);
        if (known < 0) throw BadOption("clips", "the shards know no clip '" + all.clip_names[c] + "'");
        if (std::count(all.clip_names.begin(), all.clip_names.end(), all.clip_names[c]) > 1)
            throw BadOption("clips", "'" + all.clip_names[c] + "' is asked for twice");
        all.clip.insert(all.clip.end(), place.clip_frames[std::size_t(known)], std::uint16_t(c));
    }
    all.time.resize(all.clip.size());
    const std::vector<std::uint32_t> numbers = numberInClip(all);
    if (!options.frames) return {all, numbers};
    return {sliceFrames(all, *options.frames), slice(numbers, *options.frames)};
}

// Collects frames that have the same note, such as the names of the two shards that both have them, and makes one
// line of them.
class RangeNotes {
public:
    void add(const std::string& note, const ClipFrame& frame) { frames_[note].push_back(frame); }
    std::vector<std::string> lines() const {
        std::vector<std::string> out;
        for (const auto& [note, frames] : frames_) out.push_back(rangesText(frames, kMaxListed) + " " + note);
        return out;
    }

private:
    std::map<std::string, std::vector<ClipFrame>> frames_;
};

// Finds where each frame of the whole comes from, and notes the frames that do not fit.
void placeFrames(const std::vector<Shard>& shards, const Whole& whole, MergePlan& plan) {
    constexpr std::uint32_t kNone = UINT32_MAX;
    // 1. A frame's name is its clip and its number there. Look up where that name stands in the whole.
    std::map<std::pair<std::string, std::uint32_t>, std::size_t> position;
    for (std::size_t f = 0; f < whole.frames.frameCount(); ++f)
        position[{whole.frames.clip_names[whole.frames.clip[f]], whole.frame_in_clip[f]}] = f;
    plan.source.assign(whole.frames.frameCount(), {kNone, 0});
    // 2. Each frame of a shard takes its place, unless it has none or another shard has taken it.
    RangeNotes twice, beyond;
    for (std::uint32_t s = 0; s < shards.size(); ++s)
        for (std::uint32_t i = 0; i < shards[s].clip.size(); ++i) {
            const ClipFrame frame{shards[s].clip_names[shards[s].clip[i]], shards[s].frame_in_clip[i]};
            const auto found = position.find({frame.clip, frame.number});
            if (found == position.end()) {
                beyond.add("in " + shards[s].name, frame);
            } else if (plan.source[found->second].file != kNone) {
                twice.add("in " + shards[plan.source[found->second].file].name + " and " + shards[s].name, frame);
            } else {
                plan.source[found->second] = {s, i};
                plan.header.frames.time[found->second] = shards[s].time[i];
            }
        }
    plan.problems.twice = twice.lines();
    plan.problems.beyond = beyond.lines();
    // 3. The places that are still empty are the missing frames.
    for (std::size_t f = 0; f < whole.frames.frameCount(); ++f)
        if (plan.source[f].file == kNone)
            plan.problems.missing.push_back({whole.frames.clip_names[whole.frames.clip[f]], whole.frame_in_clip[f]});
}

// Fills in what the plan knows of the whole: its frames, its options, and where each frame comes from.
void describeWhole(const std::vector<Shard>& shards, const MergeOptions& options, MergePlan& plan) {
    VisibilityHeader& header = plan.header;
    const ClipChoice choice = clipsOfWhole(shards, *header.shard, options);
    const Whole whole = listWhole(*header.shard, choice.names, options);
    header.frames = whole.frames;
    header.shard->frame_in_clip = whole.frame_in_clip;
    placeFrames(shards, whole, plan);
    header.provenance.options_json = wholeOptions(header.provenance.options_json, choice.told, options);
    // a bake that was not asked for a part writes no /shard
    if (choice.told.empty() && !options.frames) header.shard.reset();
    if (plan.source[0].file < shards.size()) header.provenance.inputs = shards[plan.source[0].file].inputs;
}

// Runs `read` for one shard. An error in its file becomes a problem of the merge, so that the other shards are still
// read.
template <class Read>
void collectProblem(MergeProblems& problems, const Read& read) try {
    throwIfInterrupted();
    read();
} catch (const IoError& error) {
    problems.unreadable.push_back(error.what());
} catch (const InvalidInput& error) {
    problems.unusable.push_back(error.what());
} catch (const Unsupported& error) {
    problems.unsupported.push_back(error.what());
}

// Reads the header of one shard, compares it with the first one, and keeps what placeFrames() needs.
void addShard(const fs::path& path, std::vector<Shard>& shards, MergePlan& plan) {
    const VisibilityReader reader(path);
    VisibilityHeader header = reader.header();
    completePlace(path.string(), header);
    const std::vector<std::string> told_clips = toldClips(path.string(), header.provenance);
    if (plan.shards.empty()) {
        plan.header = header;
        plan.precision = reader.precision();
    }
    for (const std::string& difference : differencesOf(header, plan.header))
        plan.problems.different.push_back(path.string() + ": " + difference);
    if (reader.precision() != plan.precision)
        plan.problems.different.push_back(path.string() + ": coefficients of another precision");
    plan.shards.push_back(path);
    plan.frames_of_shard.push_back(std::uint32_t(header.frames.frameCount()));
    if (!sameChoice(*header.shard, *plan.header.shard)) return;  // its frames have no place in the whole
    plan.is_virtual = plan.is_virtual || reader.isVirtual();
    shards.push_back({path.string(), told_clips, header.frames.clip_names, header.frames.clip,
                      header.shard->frame_in_clip, header.frames.time, header.provenance.inputs});
}

}  // namespace

MergePlan planMerge(const std::vector<fs::path>& paths, const MergeOptions& options) {
    refuseTwice(paths);
    MergePlan plan;
    std::vector<Shard> shards;
    for (const fs::path& path : paths) collectProblem(plan.problems, [&] { addShard(path, shards, plan); });
    try {
        if (!shards.empty()) describeWhole(shards, options, plan);
    } catch (const UsageError&) {  // the options may be those of the shards that cannot be opened
        if (!plan.problems.any()) throw;
    }
    return plan;
}

// Reads one shard after the other, since HDF5 lets only one thread in at a time anyway.
void findDamage(MergePlan& plan) {
    for (const fs::path& shard : plan.shards)
        collectProblem(plan.problems, [&] { checkFrames(VisibilityReader(shard)); });
}

// --- Messages -------------------------------------------------------------------------------------------------------

namespace {

std::string joinedUpTo(std::size_t most, const std::vector<std::string>& items) {
    const std::string text = joined(std::span(items).first(std::min(items.size(), most)));
    return items.size() > most ? text + " and " + std::to_string(items.size() - most) + " more" : text;
}

}  // namespace

bool MergeProblems::any() const {
    return !(unreadable.empty() && unusable.empty() && unsupported.empty() && different.empty() && missing.empty() &&
             twice.empty() && beyond.empty());
}

std::string MergeProblems::sentence() const {
    std::string text;
    const auto add = [&](const char* what, const std::string& items) {
        if (!items.empty()) text += (text.empty() ? "" : "; ") + std::string(what) + items;
    };
    add("cannot be read: ", joinedUpTo(kMaxListed, unreadable));
    add("cannot be used: ", joinedUpTo(kMaxListed, unusable));
    add("not supported: ", joinedUpTo(kMaxListed, unsupported));
    add("not of one bake: ", joinedUpTo(kMaxListed, different));
    add("missing frames: ", rangesText(missing, kMaxListed));
    add("frames there twice: ", joinedUpTo(kMaxListed, twice));
    add("frames beyond the whole: ", joinedUpTo(kMaxListed, beyond));
    return text;
}

void MergeProblems::raise() const {
    const std::string text = "cannot merge: " + sentence();
    if (!unusable.empty() || !different.empty() || !twice.empty() || !beyond.empty()) throw InvalidInput(text);
    if (!unsupported.empty()) throw Unsupported(text);
    if (!unreadable.empty()) throw IoError(text);
    throw InvalidInput(text);
}

// --- Writing --------------------------------------------------------------------------------------------------------

namespace {

// Keeps some shards open, the one used last in front. A reader keeps up to two blocks of frames in memory, so that
// only few may stay open. Shards of consecutive frames need one open file at a time. Shards of every S-th frame need S
// open files.
class OpenShards {
public:
    explicit OpenShards(const MergePlan& plan) : plan_(plan) {
        // All readers together may take kBudget bytes. One reader takes at most kBlocks: two blocks of frames, each of
        // about 96 MB at most (kBlockBytes in visibility_file.cpp).
        constexpr double kBudget = 1e9, kBlocks = 2 * 96e6;
        const VisibilityHeader& header = plan.header;
        const double frame = 4.0 * double(header.mesh.vertexCount()) * double(header.coefficientsOfVertex() + 6);
        most_ = std::size_t(std::clamp(kBudget / std::min(kBlocks, 128 * frame), 2.0, 64.0));
    }
    VisibilityFrame read(FrameSource source) {
        auto found =
            std::find_if(open_.begin(), open_.end(), [&](const auto& one) { return one.shard == source.file; });
        if (found == open_.end()) {
            if (open_.size() == most_) open_.pop_back();
            open_.push_front({source.file, std::make_unique<VisibilityReader>(plan_.shards[source.file])});
            found = open_.begin();
        }
        open_.splice(open_.begin(), open_, found);
        const VisibilityReader& reader = *open_.front().reader;
        // Somebody may have replaced the file since planMerge() looked at it.
        if (source.frame >= reader.header().frames.frameCount() ||
            reader.header().mesh.vertexCount() != plan_.header.mesh.vertexCount() ||
            reader.header().order != plan_.header.order ||
            reader.header().coefficientsOfVertex() != plan_.header.coefficientsOfVertex())
            throw IoError(plan_.shards[source.file].string() + ": was replaced while it was read");
        return reader.readFrame(source.frame);
    }

private:
    struct OpenShard {
        std::uint32_t shard;
        std::unique_ptr<VisibilityReader> reader;
    };
    const MergePlan& plan_;
    std::size_t most_;
    std::list<OpenShard> open_;
};

}  // namespace

void writeMerged(const MergePlan& plan, const fs::path& output, ProgressStyle style) {
    assert(!plan.problems.any());
    VisibilityWriter writer(output, plan.header, plan.precision);
    OpenShards shards(plan);
    Progress progress(style, "merging", "frames", double(plan.source.size()));
    for (std::size_t f = 0; f < plan.source.size(); ++f) {
        writer.writeFrame(shards.read(plan.source[f]));
        progress.update(double(f + 1));
    }
    writer.finish();
}

void writeIndex(MergePlan& plan, const fs::path& output, int threads) {
    assert(!plan.problems.any());
    if (plan.is_virtual) throw BadOption("virtual", "a shard has no frames of its own; give the files that it names");
    VirtualSources sources{{}, std::vector<std::string>(plan.shards.size()), plan.frames_of_shard, plan.source};
    // 1. The index names each shard relative to its own folder, so that both can be moved together.
    const fs::path folder = fs::canonical(fs::absolute(output).parent_path());
    for (const fs::path& shard : plan.shards)
        sources.files.push_back(fs::canonical(shard).lexically_relative(folder).string());
    // 2. It also stores a hash of each shard.
    parallelFor(plan.shards.size(), threads, [&](std::size_t i) {
        throwIfInterrupted();
        sources.sha256[i] = sha256OfFile(plan.shards[i]);
    });
    findDamage(plan);  // after hashing: whoever opens the index refuses a shard that is replaced in between
    if (plan.problems.any()) return;
    writeVirtualVisibility(output, plan.header, plan.precision, sources);
}

}  // namespace penumbra
