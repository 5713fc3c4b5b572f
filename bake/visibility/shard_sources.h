#pragma once
// Compares and joins what shards of one bake were made from. A shard of whole clips names the rig and the files of its
// own clips alone, so that a change of another clip's file does not concern it. The whole names all of them.
#include <cstdint>
#include <string>
#include <vector>

#include "formats/stage/visibility_file.h"

namespace penumbra {

class ShardSources {
public:
    // Takes in the inputs of a shard and the clips that it was chosen from (its header has /shard). Returns sentences
    // that say why it is of another bake, or nothing:
    // - The first input, the rig, must be the same, and a name must stand for the same bytes everywhere.
    // - Shards of the same inputs choose from the same clips.
    // - A shard that reads a file which another one does not read has clips which the other one does not have. Clips
    //   that both have are of the same length and in the same order, and only one of the two has frames of such a clip.
    // - Occluders and tables of inputs are no files of clips. Bakes with them have the same inputs.
    std::vector<std::string> add(const VisibilityHeader& shard);

    // Tells whether the shards name several sets of files.
    bool several() const { return sets_.size() > 1; }

    // Writes the inputs, notes and clips of all shards into the header of the whole. Files and clips have the order in
    // which the shards were added; a file that only some shards have goes before the next one that others have, too.
    void describe(VisibilityHeader& whole) const;

private:
    // The shards of equal inputs.
    struct Set {
        std::vector<ProvenanceInput> inputs;
        ShardPlace choice;
        std::vector<std::string> held;  // clips that they have frames of
    };
    std::vector<std::string> addSet(const Set& set, const VisibilityHeader& shard);
    std::vector<Set> sets_;
    std::vector<ProvenanceInput> inputs_;
    std::vector<std::string> notes_;
    ShardPlace clips_;
};

}  // namespace penumbra
