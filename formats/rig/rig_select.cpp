// Chooses the parts of a rig by the names of their nodes and materials (--nodes, --without).
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <numeric>
#include <set>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

namespace {

bool matches(const std::string& pattern, const std::string& name) {
    return pattern == name || ::fnmatch(pattern.c_str(), name.c_str(), 0) == 0;
}

std::string slotName(const RigSource& source, const SourcePart& part) {
    return source.nodes[std::size_t(part.node)].name + "/" + part.material;
}

// Tells whether a slot, or a node with a mesh at or below it, has the very name of a pattern. Then it is no glob.
bool isName(const RigSource& source, const std::string& pattern) {
    return std::any_of(source.parts.begin(), source.parts.end(), [&](const SourcePart& part) {
        if (pattern == slotName(source, part)) return true;
        for (int n = part.node; n >= 0; n = source.nodes[std::size_t(n)].parent)
            if (pattern == source.nodes[std::size_t(n)].name) return true;
        return false;
    });
}

// A pattern means a part by its slot, or by a node above it.
bool means(const RigSource& source, const SourcePart& part, const std::string& pattern) {
    const bool literal = isName(source, pattern);
    const auto fits = [&](const std::string& name) { return literal ? pattern == name : matches(pattern, name); };
    if (fits(slotName(source, part))) return true;
    for (int n = part.node; n >= 0; n = source.nodes[std::size_t(n)].parent)
        if (fits(source.nodes[std::size_t(n)].name)) return true;
    return false;
}

// Tells whether a pattern may choose a hidden part: only the exact name of its node or slot does.
bool meansHidden(const RigSource& source, const SourcePart& part, const std::string& pattern) {
    return pattern == source.nodes[std::size_t(part.node)].name || pattern == slotName(source, part);
}

// Returns how many letters have to be changed, added or left out (Levenshtein 1966).
std::size_t editDistance(const std::string& a, const std::string& b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t(0));
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i + 1;
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = diagonal + (std::tolower(static_cast<unsigned char>(a[i])) !=
                                                    std::tolower(static_cast<unsigned char>(b[j])));
            diagonal = row[j + 1];
            row[j + 1] = std::min({changed, row[j] + 1, row[j + 1] + 1});
        }
    }
    return row[b.size()];
}

// Lists the nodes that have a mesh at or below them and the slots, those first that are most like the pattern.
std::string nearNames(const RigSource& source, const std::string& pattern) {
    constexpr std::size_t kMax = 5, kLongest = 100;  // names, and letters that are compared
    std::set<std::string> all;
    for (const SourcePart& part : source.parts) {
        all.insert(slotName(source, part));
        for (int n = part.node; n >= 0; n = source.nodes[std::size_t(n)].parent)
            all.insert(source.nodes[std::size_t(n)].name);
    }
    std::vector<std::pair<std::size_t, std::string>> names;
    for (const std::string& name : all)
        names.emplace_back(editDistance(name.substr(0, kLongest), pattern.substr(0, kLongest)), name);
    std::sort(names.begin(), names.end());
    std::string text;
    for (std::size_t i = 0; i < names.size() && i < kMax; ++i) text += (i ? ", '" : "'") + names[i].second + "'";
    return names.size() > kMax ? text + ", ..." : text;
}

[[noreturn]] void refuse(const RigSource& source, const char* option, const std::string& pattern) {
    const auto is_node = [&](const Node& node) { return matches(pattern, node.name); };
    const bool known = std::any_of(source.nodes.begin(), source.nodes.end(), is_node);
    throw BadOption(option, "'" + pattern + "' " +
                                (known ? "matches a node without a mesh at or below it, in "
                                       : "matches no node and no NODE/MATERIAL of ") +
                                source.file.string() + "; near it are " + nearNames(source, pattern));
}

// Marks the parts that any pattern means.
std::vector<bool> meantBy(const RigSource& source, const char* option, const std::vector<std::string>& patterns) {
    std::vector<bool> meant(source.parts.size());
    for (const std::string& pattern : patterns) {
        bool any = false;
        for (std::size_t p = 0; p < source.parts.size(); ++p) {
            const SourcePart& part = source.parts[p];
            const bool hidden = part.visible != Visible::kShown;
            if (!(hidden ? meansHidden(source, part, pattern) : means(source, part, pattern))) continue;
            any = true;
            meant[p] = true;
        }
        if (!any) refuse(source, option, pattern);
    }
    return meant;
}

}  // namespace

void selectParts(RigSource& source, const RigOptions& options) {
    const std::vector<bool> chosen = meantBy(source, "nodes", options.nodes);
    const std::vector<bool> left_out = meantBy(source, "without", options.without);
    std::vector<SourcePart> kept;
    for (std::size_t p = 0; p < source.parts.size(); ++p) {
        const bool shown = source.parts[p].visible == Visible::kShown;
        if (options.nodes.empty() ? shown : chosen[p])
            if (!left_out[p]) kept.push_back(std::move(source.parts[p]));
    }
    const bool emptied = kept.empty() && !source.parts.empty();
    source.parts = std::move(kept);
    if (emptied && !options.without.empty()) throw BadOption("without", "leaves nothing of " + source.file.string());
    if (emptied) throw InvalidInput(source.file.string() + ": hides all of its meshes");
}

}  // namespace penumbra
