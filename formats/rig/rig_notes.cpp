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

std::vector<RigNote> lookNotes(const Rig& rig) {
    std::vector<RigNote> all;
    for (const ColoredPart& part : rig.part_colors)
        for (const std::string& text : part.look.notes) {
            const RigNote note{rig.files_read.front().string(), rig.mesh.slots[part.slot],
                               "material '" + part.look.material + "'", text};
            const bool known = std::ranges::any_of(
                rig.notes, [&](const RigNote& n) { return text.starts_with(n.feature + " is not read"); });
            if (!known && std::ranges::find(all, note) == all.end()) all.push_back(note);
        }
    return all;
}

}  // namespace penumbra
