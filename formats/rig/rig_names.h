#pragma once
// Matches joints of two files by their names. Exporters put namespaces ("mixamorig:Hips", "Armature|Hips") and prefixes
// ("mixamorig_Hips", "Bip01 Pelvis") before the same names.
#include <span>
#include <string>
#include <vector>

namespace penumbra {

// Returns what stands behind the last ':' or '|' of a name, or the whole name where nothing does.
std::string withoutNamespace(const std::string& name);

// Matches names in three steps, of which the first that finds something counts: equal names, names that are equal
// without namespaces, and names that are equal without namespaces and prefixes, where all separators are alike and so
// are small and capital letters. A prefix ends at the end of a word, and at least half of the file's names begin with
// it. Of all such prefixes of the two files those are taken with which most names match, and of these the shortest.
//
// Returns for each of `targets` the index of the name in `sources` that it matches, or -1. Several targets of one name
// match the same source. If as many sources have that name, each target matches the source of its own turn.
std::vector<int> matchNames(std::span<const std::string> targets, std::span<const std::string> sources);

}  // namespace penumbra
