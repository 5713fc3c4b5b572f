// Writes vertex colours that follow the clips of a .glb: COLOR_0 has the mean, and morph targets of COLOR_0 have the
// patterns that a clip's weights add to it. glTF 2.0 alone plays it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>

#include "formats/common/errors.h"
#include "pack/export/export_files.h"
#include "pack/export/play_tracks.h"

namespace penumbra {

namespace {

using GlbTree = nlohmann::ordered_json;

constexpr std::size_t kMaxNumbers = std::size_t(1) << 28;  // limit for all frames and points, 1 GB

// The frames that are played: which animation of the file each is of, and when it is.
struct PlayedFrames {
    std::vector<std::size_t> frames, animation;  // [P]
    std::vector<float> times;                    // [P] seconds, as the file counts them
};

// Returns the clip of a rig that a clip of the bake is, or is a block of ("walk#2").
const Clip* clipOfBake(const Rig& rig, const std::string& name) {
    const auto named = [&](const std::string& wanted) {
        const auto found =
            std::find_if(rig.clips.begin(), rig.clips.end(), [&](const Clip& clip) { return clip.name == wanted; });
        return found == rig.clips.end() || found->gltf_animation < 0 ? nullptr : &*found;
    };
    if (const Clip* clip = named(name)) return clip;
    const std::size_t block = name.rfind('#');
    return block == std::string::npos ? nullptr : named(name.substr(0, block));
}

PlayedFrames playedFrames(const FrameList& frames, const ExportOptions& options, ExportedGlb& out) {
    PlayedFrames played;
    std::set<std::string> missing;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const std::string& name = frames.clip_names[frames.clip[f]];
        const Clip* clip = clipOfBake(out.rig, name);
        if (!clip) {
            missing.insert(name);
            continue;
        }
        played.frames.push_back(f);
        played.animation.push_back(std::size_t(clip->gltf_animation));
        played.times.push_back(float(frames.time[f] - clip->moved_by));
    }
    const std::string file = out.glb.path.string();
    if (!missing.empty() && (!options.clips.empty() || played.frames.empty()))
        throw InvalidInput(file + ": has no animation '" + *missing.begin() + "', which could play the occlusion");
    for (const std::string& name : missing)
        out.glb.notes.push_back(file + ": has no animation '" + name + "'; its frames are left out");
    return played;
}

// The points that rows take values from, and where each stands among them.
struct UsedPoints {
    std::vector<std::uint32_t> points;  // [U] ascending
    std::vector<std::uint32_t> place;   // [points of the source]

    UsedPoints(const ExportedGlb& out, std::size_t count) : place(count) {
        std::vector<bool> used(count);
        for (const std::size_t p : out.rows.parts) {
            const ColoredPart& part = out.rig.part_colors[p];
            for (std::size_t r = part.first_vertex; r < part.first_vertex + part.vertices; ++r)
                for (const std::uint32_t corner : out.rows.points.corners[r]) used[corner] = true;
        }
        for (std::uint32_t p = 0; p < count; ++p) {
            place[p] = std::uint32_t(points.size());
            if (used[p]) points.push_back(p);
        }
    }
};

PrincipalWeights findPatterns(const FrameReader& reader, const PlayedFrames& played, const UsedPoints& used,
                              const ExportOptions& options) {
    if (played.frames.size() * used.points.size() > kMaxNumbers)
        throw Unsupported(std::to_string(played.frames.size()) + " frames of " + std::to_string(used.points.size()) +
                          " points are too many for morph targets: choose fewer clips or a lower rate");
    std::vector<float> values;
    values.reserve(played.frames.size() * used.points.size());
    for (const std::size_t frame : played.frames) {
        const OcclusionFrame read = reader.read(frame, FrameParts::kAmbient);
        for (const std::uint32_t point : used.points) values.push_back(read.ambient[point]);
    }
    return principalWeights(values, played.frames.size(), {options.components, options.max_error});
}

class PlayWriter {
public:
    PlayWriter(ExportedGlb& out, const PrincipalWeights& patterns, const UsedPoints& used)
        : out_(out), patterns_(patterns), used_(used) {}

    void write();
    const std::vector<MorphedNode>& nodes() const { return nodes_; }
    // The root mean square over vertices and frames of what is wrong where one morph target of the file that changes
    // COLOR_0 has the weight 1, of the worst of them; unset: no target does.
    std::optional<double> colorMorphError() const { return color_morph_error_; }

private:
    ExportedGlb& out_;
    const PrincipalWeights& patterns_;
    const UsedPoints& used_;
    std::vector<MorphedNode> nodes_;
    std::optional<double> color_morph_error_;
    std::map<std::pair<std::size_t, int>, std::size_t> zeros_;  // accessors by count and components

    std::size_t zeros(std::size_t count, int components) {
        const auto [at, is_new] = zeros_.try_emplace({count, components}, 0);
        if (is_new) at->second = addZeros(out_.glb, count, components);
        return at->second;
    }
    std::vector<Vec3> factorOfPattern(const GlbTarget& target, std::span<const float> pattern) const;
    double playedVariance(std::size_t pattern) const;
    void darkenMorphs(const GlbTarget& target, int components, std::span<const Vec3> mean,
                      std::span<const double> variance);
    void writeMesh(std::size_t mesh, std::span<const GlbTarget* const> targets);
    void writePrimitive(std::size_t mesh, std::size_t primitive, const GlbTarget* target);
    std::vector<std::size_t> writePatterns(const GlbTarget& target, int& components);
    void extendWeights(std::size_t mesh, std::size_t own);
};

std::vector<Vec3> PlayWriter::factorOfPattern(const GlbTarget& target, std::span<const float> pattern) const {
    std::vector<float> of_points(used_.place.size());
    for (std::size_t u = 0; u < used_.points.size(); ++u) of_points[used_.points[u]] = pattern[u];
    std::vector<Vec3> factor;
    for (const float x : valuesOf(out_.rig, target, valuesOfRows(out_.rows, of_points))) factor.push_back({x, x, x});
    return factor;
}

// The mean square of a pattern's weight over all frames. The weights of two patterns are orthogonal.
double PlayWriter::playedVariance(std::size_t pattern) const {
    double squares = 0;
    for (std::size_t i = pattern; i < patterns_.weights.size(); i += patterns_.count)
        squares += double(patterns_.weights[i]) * double(patterns_.weights[i]);
    return squares * double(patterns_.count) / double(patterns_.weights.size());
}

// A player adds, so the product (c + sum of w t) (mean + sum of k p) lacks w k t p: what morph targets of the file add
// to colours is darkened by the mean. `variance` [vertices] is that of the occlusion that is played.
void PlayWriter::darkenMorphs(const GlbTarget& target, int components, std::span<const Vec3> mean,
                              std::span<const double> variance) {
    const auto size = std::size_t(components);
    for (ColorMorph& own : ownColorMorphs(out_, target, components)) {
        double squares = 0;
        for (std::size_t i = 0; i < own.values.size(); ++i)
            if (i % size < 3) squares += double(own.values[i]) * double(own.values[i]) * variance[i / size];
        const double error = std::sqrt(squares / (3 * double(variance.size())));
        color_morph_error_ = std::max(color_morph_error_.value_or(0), error);
        multiplyColors(own.values, components, mean);
        const std::size_t accessor = addAccessor(out_.glb, own.values, components, AccessorUse::kVertices);
        primitiveOf(out_.glb, target).at("targets").at(own.morph)["COLOR_0"] = accessor;
    }
}

// Writes the mean into COLOR_0. Returns the accessors of the patterns, each the own colour times the pattern.
std::vector<std::size_t> PlayWriter::writePatterns(const GlbTarget& target, int& components) {
    const VertexColors own = ownColors(out_, target, 3);
    components = own.components;
    VertexColors shown = own;
    const std::vector<Vec3> mean = factorOfPattern(target, patterns_.mean);
    multiplyColors(shown.values, components, mean);
    writeColors(out_, target, shown);
    std::vector<std::size_t> accessors;
    std::vector<double> variance(mean.size());
    const std::size_t points = used_.points.size();
    for (std::size_t k = 0; k < patterns_.count; ++k) {
        const std::vector<Vec3> factor =
            factorOfPattern(target, std::span(patterns_.components).subspan(k * points, points));
        std::vector<float> colors = own.values;
        multiplyColors(colors, components, factor);
        for (std::size_t i = 3; components == 4 && i < colors.size(); i += 4) colors[i] = 0;
        accessors.push_back(addAccessor(out_.glb, colors, components, AccessorUse::kVertices));
        const double squares = playedVariance(k);
        for (std::size_t v = 0; v < variance.size(); ++v)
            variance[v] += squares * double(factor[v].x) * double(factor[v].x);
    }
    darkenMorphs(target, components, mean, variance);
    return accessors;
}

// Appends the targets. Players expect the same attributes in all targets of a primitive, so those that one has and
// another lacks are zeros, which take no bytes. Without POSITION some do not see a target at all.
void PlayWriter::writePrimitive(std::size_t mesh, std::size_t primitive, const GlbTarget* target) {
    const auto place = [&]() -> GlbTree& {
        return out_.glb.document["meshes"].at(mesh).at("primitives").at(primitive);
    };
    int components = 3;
    std::vector<std::size_t> colors;
    if (target) colors = writePatterns(*target, components);
    if (patterns_.count == 0) return;  // a list without entries is no glTF
    const auto position = place().at("attributes").at("POSITION").get<std::size_t>();
    const auto vertices = out_.glb.document["accessors"].at(position).at("count").get<std::size_t>();
    std::map<std::string, int> others{{"POSITION", 3}};
    if (place().contains("targets"))
        for (const GlbTree& own : place()["targets"])
            for (const auto& [name, accessor] : own.items())
                if (name != "COLOR_0")
                    others[name] = name.starts_with("TEXCOORD") ? 2 : name.starts_with("COLOR") ? 4 : 3;
    GlbTree targets = place().contains("targets") ? place()["targets"] : GlbTree::array();
    for (GlbTree& own : targets)
        if (target && !own.contains("COLOR_0")) own["COLOR_0"] = zeros(vertices, components);
    for (std::size_t k = 0; k < patterns_.count; ++k) {
        GlbTree added;
        for (const auto& [name, count] : others) added[name] = zeros(vertices, count);
        if (target) added["COLOR_0"] = colors[k];
        targets.push_back(std::move(added));
    }
    place()["targets"] = std::move(targets);
}

void PlayWriter::extendWeights(std::size_t mesh, std::size_t own) {
    GlbTree& document = out_.glb.document;
    GlbTree& holder = document["meshes"].at(mesh);
    const auto extend = [&](GlbTree& weights) {
        while (weights.size() < own + patterns_.count) weights.push_back(0);
    };
    if (!holder.contains("weights")) holder["weights"] = GlbTree::array();
    extend(holder["weights"]);
    for (GlbTree& node : document["nodes"])
        if (node.contains("mesh") && node["mesh"].get<std::size_t>() == mesh && node.contains("weights"))
            extend(node["weights"]);
    // Names of some targets would be names of the wrong ones.
    const bool named =
        holder.contains("extras") && holder["extras"].is_object() && holder["extras"].contains("targetNames");
    if (own > 0 && !named) return;
    if (holder.contains("extras") && !holder["extras"].is_object()) return;
    GlbTree& names = holder["extras"]["targetNames"];
    if (names.is_null()) names = GlbTree::array();
    if (!names.is_array() || names.size() != own) return;
    for (std::size_t k = 0; k < patterns_.count; ++k) names.push_back("penumbra_ao_" + std::to_string(k));
}

void PlayWriter::writeMesh(std::size_t mesh, std::span<const GlbTarget* const> targets) {
    GlbTree& primitives = out_.glb.document["meshes"].at(mesh).at("primitives");
    const std::size_t own = primitives.at(0).value("targets", GlbTree::array()).size();
    for (std::size_t p = 0; p < primitives.size(); ++p) {
        const auto found =
            std::find_if(targets.begin(), targets.end(), [&](const GlbTarget* t) { return t->primitive == p; });
        writePrimitive(mesh, p, found == targets.end() ? nullptr : *found);
    }
    if (patterns_.count > 0) extendWeights(mesh, own);
    nodes_.push_back({targets[0]->node, mesh, own});
}

void PlayWriter::write() {
    std::map<std::size_t, std::vector<const GlbTarget*>> of_mesh;
    for (const GlbTarget& target : out_.targets) of_mesh[target.mesh].push_back(&target);
    for (const auto& [mesh, targets] : of_mesh) writeMesh(mesh, targets);
}

// The weights of each animation. Of frames at one time the first one counts.
std::map<std::size_t, WeightTrack> tracksOf(const PlayedFrames& played, const PrincipalWeights& patterns) {
    std::map<std::size_t, std::map<float, std::size_t>> order;
    for (std::size_t i = 0; i < played.frames.size(); ++i) order[played.animation[i]].try_emplace(played.times[i], i);
    std::map<std::size_t, WeightTrack> tracks;
    for (const auto& [animation, frames] : order) {
        WeightTrack& track = tracks[animation];
        track.count = patterns.count;
        for (const auto& [time, i] : frames) {
            track.times.push_back(time);
            const auto first = patterns.weights.begin() + std::ptrdiff_t(i * patterns.count);
            track.values.insert(track.values.end(), first, first + std::ptrdiff_t(patterns.count));
        }
    }
    return tracks;
}

}  // namespace

PrincipalWeights exportPlay(const FrameReader& reader, const ExportOptions& options, ExportedGlb& out) {
    const PlayedFrames played = playedFrames(reader.source.frames(), options, out);
    const UsedPoints used(out, reader.source.mesh().vertexCount());
    PrincipalWeights patterns = findPatterns(reader, played, used, options);
    markExport(out.glb, {{"version", 1}, {"as", "play"}, {"components", patterns.count}});
    PlayWriter writer(out, patterns, used);
    writer.write();
    if (const std::optional<double> error = writer.colorMorphError()) {
        char text[24];
        std::snprintf(text, sizeof text, "%.2g", *error);
        out.glb.notes.push_back(out.glb.path.string() +
                                ": morph targets of COLOR_0: what they add is darkened by the mean occlusion, which is "
                                "wrong by up to " +
                                text + " (rms) at the weight 1");
    }
    if (patterns.count > 0)
        addPlayTracks(out.glb, out.numbers, writer.nodes(), tracksOf(played, patterns), patterns.count);
    else
        out.glb.notes.push_back(out.glb.path.string() +
                                ": nothing moves: the mean is as near to the frames as was asked for");
    return patterns;
}

}  // namespace penumbra
