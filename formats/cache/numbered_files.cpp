#include "formats/cache/numbered_files.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "formats/common/errors.h"
#include "formats/rig/rig_build.h"

namespace penumbra {
namespace fs = std::filesystem;

constexpr std::size_t kMaxDigits = 15;

namespace {
// A name without its number: what stands before and after it.
struct Template {
    std::string before, after;
    bool operator<(const Template& other) const {
        return std::tie(before, after) < std::tie(other.before, other.after);
    }
};

struct Numbered {
    std::uint64_t number = 0;
    fs::path file;
};

struct Place {
    std::size_t start = std::string::npos, size = 0;
};

bool isDigit(char c) { return c >= '0' && c <= '9'; }

// Finds "%d", "%4d", "%04d", "*" or a run of "#".
Place findPattern(const std::string& name) {
    if (const std::size_t star = name.find('*'); star != std::string::npos) return {star, 1};
    if (const std::size_t hash = name.find('#'); hash != std::string::npos)
        return {hash, std::min(name.find_first_not_of('#', hash), name.size()) - hash};
    const std::size_t percent = name.find('%');
    if (percent == std::string::npos) return {};
    std::size_t end = percent + 1;
    while (end < name.size() && isDigit(name[end])) ++end;
    if (end == name.size() || name[end] != 'd') return {};
    return {percent, end + 1 - percent};
}

// Finds the last run of digits before the extension.
Place findNumber(const std::string& name, std::size_t stem_size) {
    std::size_t end = stem_size;
    while (end > 0 && !isDigit(name[end - 1])) --end;
    std::size_t start = end;
    while (start > 0 && isDigit(name[start - 1])) --start;
    return start == end ? Place{} : Place{start, end - start};
}

Template cut(const std::string& name, Place place) {
    return {name.substr(0, place.start), name.substr(place.start + place.size)};
}

}  // namespace

bool namesSequence(const fs::path& path) {
    std::error_code error;
    if (fs::is_directory(path, error)) return true;
    return !fs::exists(path, error) && findPattern(path.filename().string()).start != std::string::npos;
}

namespace {

std::vector<std::string> namesIn(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        names.push_back(it->path().filename().string());
    if (error) throw IoError(folder.string() + ": cannot read: " + error.message());
    std::sort(names.begin(), names.end());
    return names;
}

std::vector<Numbered> matches(const fs::path& folder, const Template& pattern) {
    std::vector<Numbered> found;
    for (const std::string& name : namesIn(folder.empty() ? "." : folder)) {
        if (name.size() <= pattern.before.size() + pattern.after.size() || !name.starts_with(pattern.before) ||
            !name.ends_with(pattern.after))
            continue;
        const std::string digits =
            name.substr(pattern.before.size(), name.size() - pattern.before.size() - pattern.after.size());
        if (!std::all_of(digits.begin(), digits.end(), isDigit) || digits.size() > kMaxDigits) continue;
        found.push_back({std::stoull(digits), folder / name});
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Numbered& a, const Numbered& b) { return a.number < b.number; });
    return found;
}

// Returns the name that a number would have, with as many digits as the file before it.
std::string nameOf(const Numbered& before, const Template& pattern, std::uint64_t number) {
    const std::size_t width = before.file.filename().string().size() - pattern.before.size() - pattern.after.size();
    std::string digits = std::to_string(number);
    if (digits.size() < width) digits.insert(0, width - digits.size(), '0');
    return (before.file.parent_path() / (pattern.before + digits + pattern.after)).string();
}

// Returns the step of the ascending numbers: the greatest one that reaches all of them. Two files do not tell a step.
std::uint64_t stepOf(const std::vector<Numbered>& found) {
    std::uint64_t step = 0;
    for (std::size_t i = 1; i < found.size(); ++i) step = std::gcd(step, found[i].number - found[i - 1].number);
    return found.size() < 3 || step == 0 ? 1 : step;
}

void checkNumbers(const std::vector<Numbered>& found, const Template& pattern, std::uint64_t step) {
    const std::string sequence = step == 1 ? "the sequence" : "the sequence in steps of " + std::to_string(step);
    for (std::size_t i = 1; i < found.size(); ++i) {
        if (found[i].number == found[i - 1].number)
            throw InvalidInput(found[i].file.string() + ": has the number of " + found[i - 1].file.string());
        if (found[i].number != found[i - 1].number + step)
            throw InvalidInput(nameOf(found[i - 1], pattern, found[i - 1].number + step) + ": is missing in " +
                               sequence + " that goes on with " + found[i].file.string());
    }
}

NumberedFiles sequenceOf(const fs::path& folder, const Template& pattern, std::uint64_t first) {
    std::vector<Numbered> found = matches(folder, pattern);
    std::erase_if(found, [&](const Numbered& n) { return n.number < first; });
    if (found.empty())
        throw InvalidInput((folder / (pattern.before + "*" + pattern.after)).string() + ": no numbered files");
    NumberedFiles out;
    out.step = stepOf(found);
    checkNumbers(found, pattern, out.step);
    const std::size_t end = pattern.before.find_last_not_of("_-. ");
    out.name = end == std::string::npos ? "" : pattern.before.substr(0, end + 1);
    if (out.name.empty()) out.name = fs::absolute(folder).lexically_normal().filename().string();
    if (out.name.empty()) out.name = "sequence";
    for (const Numbered& n : found) out.files.push_back(n.file);
    return out;
}

// Returns the files of a folder, whose numbered files must all fit one template.
NumberedFiles sequenceIn(const fs::path& folder, const std::vector<std::string>& extensions) {
    std::map<Template, int> templates;
    for (const std::string& name : namesIn(folder)) {
        const bool fits = std::any_of(extensions.begin(), extensions.end(),
                                      [&](const std::string& e) { return isExtension(name, e.c_str()); });
        const Place place = findNumber(name, fs::path(name).stem().string().size());
        if (fits && place.start != std::string::npos) ++templates[cut(name, place)];
    }
    if (templates.empty()) throw IoError(folder.string() + ": a folder that has no numbered files");
    if (templates.size() > 1) {
        const Template &a = templates.begin()->first, &b = std::next(templates.begin())->first;
        throw InvalidInput(folder.string() + ": has several sequences, " + a.before + "*" + a.after + " and " +
                           b.before + "*" + b.after + "; name one of them");
    }
    return sequenceOf(folder, templates.begin()->first, 0);
}

}  // namespace

NumberedFiles findNumberedFiles(const fs::path& path, const std::vector<std::string>& extensions) {
    std::error_code error;
    if (fs::is_directory(path, error)) return sequenceIn(path, extensions);
    const std::string name = path.filename().string();
    if (namesSequence(path)) return sequenceOf(path.parent_path(), cut(name, findPattern(name)), 0);
    const Place place = findNumber(name, path.stem().string().size());
    const bool numbered = place.start != std::string::npos && place.size <= kMaxDigits;
    if (!fs::exists(path, error) || !numbered) return {path.stem().string(), {path}};
    return sequenceOf(path.parent_path(), cut(name, place), std::stoull(name.substr(place.start, place.size)));
}

}  // namespace penumbra
