#pragma once
// The flags of all verbs that read a rig, and what they tell of it.
#include "formats/common/name_list_option.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/rig/rig_options.h"

namespace penumbra {

inline void addRigFlags(CLI::App& app, RigOptions& rig) {
    addNameListOption(app, "--nodes", rig.nodes,
                      "only the meshes of these nodes and of those below them; names or globs");
    addNameListOption(app, "--without", rig.without, "not the meshes of these nodes and of those below them");
    app.add_option("--split-angle", rig.split_angle, "degrees from which on normals of one place make an edge")
        ->check(within(0.0, 180.0, "degrees"));
    app.add_option("--crease", rig.crease,
                   "degrees between triangles that make an edge, where the file has no normals (default: none)")
        ->check(within(0.0, 180.0, "degrees"));
    app.add_flag_callback(
        "--one-sided", [&rig] { rig.sides = RigSides::kFronts; },
        "fronts alone, also of materials that the file draws on both sides");
    app.add_flag("--strict", rig.strict, "refuse a file of which something that is seen would be left out");
}

// Prints what the readers have to say, and adds it to the report.
inline void reportNotes(const std::vector<std::string>& notes, Report& report) {
    for (const std::string& note : notes) reportWarning("penumbra-bake", note);
    if (!notes.empty()) report.figures["notes"] = notes;
}

}  // namespace penumbra
