#pragma once
// The flags of all verbs that read a rig, and what they tell of it.
#include <filesystem>

#include "formats/common/errors.h"
#include "formats/common/name_list_option.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/rig/rig_file.h"
#include "formats/rig/rig_options.h"

namespace penumbra {

inline void addRigFlags(CLI::App& app, RigOptions& rig) {
    addNameListOption(app, "--nodes", rig.nodes,
                      "only the meshes of these nodes and of those below them; names or globs");
    addNameListOption(app, "--without", rig.without, "leave out the meshes of these nodes and of those below them");
    app.add_option("--split-angle", rig.split_angle, "degrees from which on normals of one place make an edge")
        ->check(within(0.0, 180.0, "degrees"));
    app.add_option("--crease", rig.crease,
                   "degrees between triangles that make an edge, where the file has no normals (default: none)")
        ->check(within(0.0, 180.0, "degrees"));
    app.add_flag_callback(
        "--one-sided", [&rig] { rig.sides = RigSides::kFronts; },
        "use only front faces, even of materials that the file draws on both sides");
    app.add_flag("--strict", rig.strict, "refuse a file if something visible in it would be left out");
}

// Where a verb writes the .glb that an FBX file was converted to.
inline void addKeepConverted(CLI::App& app, RigOptions& rig, std::filesystem::path& file) {
    app.add_option_function<std::filesystem::path>(
        "--keep-converted",
        [&](const std::filesystem::path& value) {
            file = value;
            rig.keep_converted = true;
        },
        "FILE.glb: what FBX2glTF made of an .fbx rig, whose vertices /mesh/source_vertex counts");
}

// Writes it. Throws Unsupported where the first file was not converted.
inline void writeConverted(const std::filesystem::path& file, const Rig* rig, const std::filesystem::path& of) {
    if (file.empty()) return;
    if (!rig || !rig->converted)
        throw Unsupported(of.string() + ": FBX2glTF did not convert it, so there is nothing for --keep-converted");
    writeWholeFile(file, {reinterpret_cast<const char*>(rig->converted->data()), rig->converted->size()});
}

// Tells with -v who read the files how.
inline void logReaders(const std::vector<std::string>& lines, const Report& report) {
    if (report.log_as.empty()) return;
    for (const std::string& line : lines) logLine(report.log_as, line);
}

// Prints what the readers have to say, and adds it to the report.
inline void reportNotes(const std::vector<std::string>& notes, Report& report) {
    for (const std::string& note : notes) reportWarning("penumbra-bake", note);
    if (!notes.empty()) report.figures["notes"] = notes;
}

}  // namespace penumbra
