#include "formats/rig/rig_names.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <map>
#include <set>

namespace penumbra {

namespace {

bool isLetterOrDigit(char c) { return std::isalnum(static_cast<unsigned char>(c)) || (c & 0x80) != 0; }
bool isCapital(char c) { return std::isupper(static_cast<unsigned char>(c)) != 0; }

// Tells whether a word begins at `at`: behind a separator ("Bip01 Pelvis"), or with a capital letter behind another
// letter or digit ("mixamorigHips").
bool beginsWord(const std::string& name, std::size_t at) {
    if (!isLetterOrDigit(name[at - 1])) return true;
    return isCapital(name[at]) && !isCapital(name[at - 1]);
}

// Returns a prefix without the separators at its end. A root may be called so ("Bip01" of "Bip01 Pelvis").
std::string bareOf(const std::string& prefix) { return prefix.substr(0, prefix.find_last_not_of(" _.-") + 1); }

// Returns the prefixes that at least half of the names have, and "".
std::vector<std::string> prefixesOf(const std::vector<std::string>& names) {
    std::map<std::string, std::size_t> uses;
    for (const std::string& name : names)
        for (std::size_t at = 1; at < name.size(); ++at)
            if (beginsWord(name, at)) ++uses[name.substr(0, at)];
    std::vector<std::string> prefixes{""};
    for (const auto& [prefix, beginning] : uses) {
        const std::string bare = bareOf(prefix);
        const std::size_t count = beginning + (bare != prefix && std::count(names.begin(), names.end(), bare) > 0);
        if (count > 1 && 2 * count >= names.size()) prefixes.push_back(prefix);
    }
    return prefixes;
}

// Returns a name without a prefix, in small letters and with "_" for every run of separators: "" for the bare prefix.
std::string plainName(const std::string& name, const std::string& prefix) {
    const bool has_prefix = name.compare(0, prefix.size(), prefix) == 0;
    std::string plain;
    for (const char c : has_prefix ? name.substr(prefix.size()) : name) {
        if (isLetterOrDigit(c))
            plain += char(std::tolower(static_cast<unsigned char>(c)));
        else if (!plain.empty() && plain.back() != '_')
            plain += '_';
    }
    return !prefix.empty() && name == bareOf(prefix) ? "" : plain;
}

std::vector<std::string> mapped(std::span<const std::string> names,
                                const std::function<std::string(const std::string&)>& key) {
    std::vector<std::string> keys;
    for (const std::string& name : names) keys.push_back(key(name));
    return keys;
}

using Groups = std::map<std::string, std::vector<int>>;

Groups groupsOf(const std::vector<std::string>& keys) {
    Groups groups;
    for (std::size_t i = 0; i < keys.size(); ++i) groups[keys[i]].push_back(int(i));
    return groups;
}

// Fills the matches of those targets that have none.
void matchKeys(const std::vector<std::string>& targets, const std::vector<std::string>& sources,
               std::vector<int>& match) {
    const Groups groups = groupsOf(sources);
    for (const auto& [key, members] : groupsOf(targets)) {
        const auto found = groups.find(key);
        if (found == groups.end()) continue;
        const bool by_turn = found->second.size() == members.size();
        for (std::size_t i = 0; i < members.size(); ++i) {
            int& of_target = match[std::size_t(members[i])];
            if (of_target < 0) of_target = found->second[by_turn ? i : 0];
        }
    }
}

std::size_t countMatched(std::vector<int> match) {
    std::erase(match, -1);
    return std::set<int>(match.begin(), match.end()).size();
}

// Matches without prefixes. `targets` and `sources` have no namespaces.
void matchWithoutPrefixes(const std::vector<std::string>& targets, const std::vector<std::string>& sources,
                          std::vector<int>& match) {
    std::vector<int> best = match;
    std::size_t most = countMatched(match), shortest = 0;
    for (const std::string& of_target : prefixesOf(targets))
        for (const std::string& of_source : prefixesOf(sources)) {
            std::vector<int> tried = match;
            matchKeys(mapped(targets, [&](const std::string& name) { return plainName(name, of_target); }),
                      mapped(sources, [&](const std::string& name) { return plainName(name, of_source); }), tried);
            const std::size_t count = countMatched(tried), size = of_target.size() + of_source.size();
            if (count < most || (count == most && size >= shortest)) continue;
            most = count;
            shortest = size;
            best = std::move(tried);
        }
    match = std::move(best);
}

}  // namespace

std::string withoutNamespace(const std::string& name) {
    const std::size_t end = name.find_last_of(":|");
    return end == std::string::npos || end + 1 == name.size() ? name : name.substr(end + 1);
}

std::vector<int> matchNames(std::span<const std::string> targets, std::span<const std::string> sources) {
    std::vector<int> match(targets.size(), -1);
    matchKeys({targets.begin(), targets.end()}, {sources.begin(), sources.end()}, match);
    const std::vector<std::string> short_targets = mapped(targets, withoutNamespace),
                                   short_sources = mapped(sources, withoutNamespace);
    matchKeys(short_targets, short_sources, match);
    matchWithoutPrefixes(short_targets, short_sources, match);
    return match;
}

}  // namespace penumbra
