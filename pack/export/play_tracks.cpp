#include "pack/export/play_tracks.h"

#include <algorithm>
#include <array>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

using GlbTree = nlohmann::ordered_json;

TrackForm formOf(const std::string& interpolation) {
    if (interpolation == "STEP") return TrackForm::kStep;
    return interpolation == "CUBICSPLINE" ? TrackForm::kCubic : TrackForm::kLinear;
}

const char* wordOf(TrackForm form) {
    constexpr std::array kWords{"STEP", "LINEAR", "CUBICSPLINE"};
    return kWords[std::size_t(form)];
}

bool drives(const GlbTree& channel, const MorphedNode& node) {
    const GlbTree& target = channel.at("target");
    return target.value("path", "") == "weights" && target.contains("node") &&
           target["node"].get<std::size_t>() == node.node;
}

// Refuses what would be wrong once the weights are more.
void refusePointers(const GrowingGlb& glb, const GlbTree& animation, const std::vector<MorphedNode>& nodes) {
    for (const GlbTree& channel : animation.at("channels")) {
        const GlbTree& target = channel.at("target");
        if (target.value("path", "") != "pointer" || !target.contains("extensions")) continue;
        const std::string pointer =
            target["extensions"].value("KHR_animation_pointer", GlbTree::object()).value("pointer", "");
        for (const MorphedNode& node : nodes)
            for (const std::string& way : {"/nodes/" + std::to_string(node.node) + "/weights",
                                           "/meshes/" + std::to_string(node.mesh) + "/weights"})
                if (pointer.starts_with(way))
                    throw Unsupported(glb.path.string() + ": drives morph weights by KHR_animation_pointer to '" +
                                      pointer + "', which cannot be joined with those of the occlusion");
    }
}

class TrackWriter {
public:
    TrackWriter(GrowingGlb& glb, const GltfNumbers& numbers, std::size_t count)
        : glb_(glb), numbers_(numbers), count_(count) {}

    void write(GlbTree& animation, const std::vector<MorphedNode>& nodes, const WeightTrack* played);

private:
    GrowingGlb& glb_;
    const GltfNumbers& numbers_;
    std::size_t count_;

    WeightTrack read(const GlbTree& animation, const GlbTree& channel, const MorphedNode& node) const;
    WeightTrack atRest(const MorphedNode& node) const;
    std::size_t addSampler(GlbTree& animation, const WeightTrack& track);
};

WeightTrack TrackWriter::read(const GlbTree& animation, const GlbTree& channel, const MorphedNode& node) const {
    const GlbTree& sampler = animation.at("samplers").at(channel.at("sampler").get<std::size_t>());
    const GltfArray times = numbers_.read(sampler.at("input").get<std::size_t>(), "times of morph weights");
    const GltfArray values = numbers_.read(sampler.at("output").get<std::size_t>(), "morph weights");
    WeightTrack track;
    track.form = formOf(sampler.value("interpolation", "LINEAR"));
    track.count = node.own;
    track.times.assign(times.values.begin(), times.values.end());
    track.values.assign(values.values.begin(), values.values.end());
    const std::size_t a_key = (track.form == TrackForm::kCubic ? 3 : 1) * node.own;
    if (track.times.empty() || track.values.size() != a_key * track.times.size() ||
        !std::is_sorted(track.times.begin(), track.times.end()))
        throw InvalidInput(glb_.path.string() + ": the morph weights of node " + std::to_string(node.node) +
                           " do not fit its mesh, or their times do not ascend");
    return track;
}

// The weights that a mesh has where no clip drives them.
WeightTrack TrackWriter::atRest(const MorphedNode& node) const {
    WeightTrack track{TrackForm::kLinear, node.own, {0}, std::vector<float>(node.own)};
    for (const GlbTree* holder :
         {&glb_.document.at("nodes").at(node.node), &glb_.document.at("meshes").at(node.mesh)}) {
        if (!holder->contains("weights")) continue;
        for (std::size_t m = 0; m < node.own; ++m) track.values[m] = (*holder)["weights"].at(m).get<float>();
        break;
    }
    return track;
}

std::size_t TrackWriter::addSampler(GlbTree& animation, const WeightTrack& track) {
    const std::size_t input = addAccessor(glb_, track.times, 1, AccessorUse::kTimes);
    const std::size_t output = addAccessor(glb_, track.values, 1, AccessorUse::kValues);
    animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", wordOf(track.form)}});
    return animation["samplers"].size() - 1;
}

void TrackWriter::write(GlbTree& animation, const std::vector<MorphedNode>& nodes, const WeightTrack* played) {
    const std::size_t none = std::size_t(-1);
    std::size_t shared = none;  // the sampler of all nodes whose mesh has no targets of its own
    for (const MorphedNode& node : nodes) {
        GlbTree& channels = animation.at("channels");
        const auto own =
            std::find_if(channels.begin(), channels.end(), [&](const GlbTree& c) { return drives(c, node); });
        if (own != channels.end() && node.own > 0) {
            const WeightTrack track = read(animation, *own, node);
            (*own)["sampler"] = addSampler(animation, played ? joinTracks(track, *played) : widened(track, count_));
            continue;
        }
        if (!played) continue;
        std::size_t sampler = shared;
        if (node.own > 0)
            sampler = addSampler(animation, joinTracks(atRest(node), *played));
        else if (shared == none)
            sampler = shared = addSampler(animation, *played);
        channels.push_back({{"sampler", sampler}, {"target", {{"node", node.node}, {"path", "weights"}}}});
    }
}

}  // namespace

void addPlayTracks(GrowingGlb& glb, const GltfNumbers& numbers, const std::vector<MorphedNode>& nodes,
                   const std::map<std::size_t, WeightTrack>& played, std::size_t count) {
    if (!glb.document.contains("animations")) return;
    TrackWriter writer(glb, numbers, count);
    // Accessors are added on the way, so that no reference to the document's lists may be kept.
    GlbTree animations = std::move(glb.document["animations"]);
    for (std::size_t a = 0; a < animations.size(); ++a) {
        refusePointers(glb, animations[a], nodes);
        const auto found = played.find(a);
        writer.write(animations[a], nodes, found == played.end() ? nullptr : &found->second);
    }
    glb.document["animations"] = std::move(animations);
}

}  // namespace penumbra
