// Tells what a rig's reader did not do as its file says.
#include <algorithm>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

std::string textOf(const RigNote& note) {
    const std::string node = note.node.empty() ? "" : "node '" + note.node + "': ";
    return note.file + ": " + node + note.feature + ": " + note.effect;
}

std::vector<RigNote> takeNotes(std::vector<RigSource>& sources) {
    std::vector<RigNote> all;
    for (RigSource& source : sources)
        for (RigNote& note : source.notes)
            if (std::find(all.begin(), all.end(), note) == all.end()) all.push_back(std::move(note));
    return all;
}

void refuseNotes(const std::vector<RigNote>& notes) {
    if (notes.empty()) return;
    const std::string more = notes.size() == 1 ? "" : " (and " + std::to_string(notes.size() - 1) + " more)";
    throw Unsupported(textOf(notes.front()) + more);
}

}  // namespace penumbra
