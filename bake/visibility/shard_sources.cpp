#include "bake/visibility/shard_sources.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace penumbra {
namespace {

using Inputs = std::vector<ProvenanceInput>;

bool sameBytes(const ProvenanceInput& a, const ProvenanceInput& b) { return a.sha256 == b.sha256; }

bool sameFiles(const Inputs& a, const Inputs& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), sameBytes);
}

bool sameClips(const ShardPlace& a, const ShardPlace& b) {
    return a.clip_names == b.clip_names && a.clip_frames == b.clip_frames;
}

template <class T>
bool contains(const std::vector<T>& list, const T& item) {
    return std::find(list.begin(), list.end(), item) != list.end();
}

// Puts what `list` lacks of `more` before the next item that both have, or at the end. Returns false where the two have
// common items in different orders. An item may stand in both more than once.
template <class T, class Same>
bool joinInOrder(const std::vector<T>& more, std::vector<T>& list, const Same& same) {
    std::ptrdiff_t passed = 0;  // items of `list`
    for (auto item = more.begin(); item != more.end(); ++item) {
        const auto rest = list.begin() + passed;
        auto place = list.end();
        for (auto next = item; next != more.end() && place == list.end(); ++next)
            place = std::find_if(rest, list.end(), [&](const T& known) { return same(known, *next); });
        if (place == list.end() || !same(*place, *item)) {
            if (std::any_of(list.begin(), rest, [&](const T& known) { return same(known, *item); })) return false;
            place = list.insert(place, *item);
        }
        passed = place - list.begin() + 1;
    }
    return true;
}

// Says how the inputs of a shard differ from those of another one.
std::vector<std::string> otherInputs(const Inputs& other, const Inputs& expected) {
    return differencesOf(Provenance{"", "", "{}", other}, Provenance{"", "", "{}", expected}, {});
}

// Tells whether `set` reads a file that `other` does not read, without a clip that `other` does not have.
bool readsWithoutClips(const Inputs& inputs, const ShardPlace& choice, const Inputs& other, const ShardPlace& others) {
    const bool reads_more = std::any_of(inputs.begin(), inputs.end(), [&](const ProvenanceInput& input) {
        return std::none_of(other.begin(), other.end(), [&](const ProvenanceInput& b) { return sameBytes(input, b); });
    });
    return reads_more && std::all_of(choice.clip_names.begin(), choice.clip_names.end(),
                                     [&](const std::string& name) { return others.clipNamed(name) >= 0; });
}

bool readsMoreThanClips(const VisibilityHeader& shard) {
    const nlohmann::json options = nlohmann::json::parse(shard.provenance.options_json);
    return options.contains("occluders") || options.contains("inputs");
}

}  // namespace

std::vector<std::string> ShardSources::add(const VisibilityHeader& shard) {
    const Set set{
        shard.provenance.inputs, {shard.shard->clip_names, shard.shard->clip_frames, {}}, shard.frames.clip_names};
    const auto known =
        std::find_if(sets_.begin(), sets_.end(), [&](const Set& other) { return sameFiles(other.inputs, set.inputs); });
    if (known != sets_.end() && !sameClips(known->choice, set.choice)) return {"another list of clips to choose from"};
    // A clip whose frames come from shards of other inputs may be another motion of the same name.
    for (const Set& other : sets_)
        for (const std::string& clip : set.held)
            if (!sameFiles(other.inputs, set.inputs) && contains(other.held, clip))
                return otherInputs(set.inputs, other.inputs);
    if (known == sets_.end()) return addSet(set, shard);
    for (const std::string& clip : set.held)
        if (!contains(known->held, clip)) known->held.push_back(clip);
    return {};
}

std::vector<std::string> ShardSources::addSet(const Set& set, const VisibilityHeader& shard) {
    if (sets_.empty()) {
        inputs_ = set.inputs;
        notes_ = shard.provenance.notes;
        clips_ = set.choice;
        sets_.push_back(set);
        return {};
    }
    for (const Set& other : sets_) {
        const bool fits = !set.inputs.empty() && !other.inputs.empty() && sameBytes(set.inputs[0], other.inputs[0]) &&
                          !readsMoreThanClips(shard) &&
                          !readsWithoutClips(set.inputs, set.choice, other.inputs, other.choice) &&
                          !readsWithoutClips(other.inputs, other.choice, set.inputs, set.choice);
        if (!fits) return otherInputs(set.inputs, other.inputs);
    }
    for (const ProvenanceInput& input : set.inputs)
        for (const ProvenanceInput& known : inputs_)
            if (input.name == known.name && !sameBytes(input, known)) return otherInputs({input}, {known});
    for (std::size_t c = 0; c < set.choice.clip_names.size(); ++c) {
        const std::string& name = set.choice.clip_names[c];
        const int known = clips_.clipNamed(name);
        if (known >= 0 && clips_.clip_frames[std::size_t(known)] != set.choice.clip_frames[c])
            return {"clip '" + name + "' has " + std::to_string(set.choice.clip_frames[c]) + " frames, not " +
                    std::to_string(clips_.clip_frames[std::size_t(known)])};
    }
    std::vector<std::string> names = clips_.clip_names;
    Inputs inputs = inputs_;
    if (!joinInOrder(set.inputs, inputs, sameBytes) || !joinInOrder(set.choice.clip_names, names, std::equal_to<>()))
        return {"files or clips in another order"};
    ShardPlace clips{names, {}, {}};
    for (const std::string& name : names) {
        const int known = clips_.clipNamed(name);
        clips.clip_frames.push_back(known >= 0 ? clips_.clip_frames[std::size_t(known)]
                                               : set.choice.clip_frames[std::size_t(set.choice.clipNamed(name))]);
    }
    for (const std::string& note : shard.provenance.notes)
        if (!contains(notes_, note)) notes_.push_back(note);
    inputs_ = std::move(inputs);
    clips_ = std::move(clips);
    sets_.push_back(set);
    return {};
}

void ShardSources::describe(VisibilityHeader& whole) const {
    whole.provenance.inputs = inputs_;
    whole.provenance.notes = notes_;
    whole.shard->clip_names = clips_.clip_names;
    whole.shard->clip_frames = clips_.clip_frames;
}

}  // namespace penumbra
