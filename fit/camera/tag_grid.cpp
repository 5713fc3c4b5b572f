#include "fit/camera/tag_grid.h"

#include <charconv>
#include <cmath>
#include <map>

#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr int kMaxTagsASide = 100;
constexpr double kLongestSide = 100;  // metres

// Reads a whole word as a number.
template <class T>
bool readWhole(const std::string& word, T& out) {
    const char* end = word.data() + word.size();
    const auto [stop, error] = std::from_chars(word.data(), end, out);
    return error == std::errc() && stop == end && !word.empty();
}

std::vector<std::string> split(const std::string& text, char at) {
    std::vector<std::string> out{""};
    for (const char c : text) {
        if (c == at)
            out.emplace_back();
        else
            out.back() += c;
    }
    return out;
}

}  // namespace

TagGrid parseTagGrid(const std::string& text) {
    const auto fail = [&text](const std::string& what) -> void {
        throw BadOption(
            "tags", "must be FAMILY:COLUMNSxROWS:SIDE:GAP, as 36h11:6x8:0.024:0.006; " + what + " in '" + text + "'");
    };
    const std::vector<std::string> words = split(text, ':');
    if (words.size() != 4) fail("there are " + std::to_string(words.size()) + " words");
    TagGrid out;
    const std::optional<TagFamily> family = findTagFamily(words[0]);
    if (!family) fail("no family '" + words[0] + "' (36h11, 25h9, 16h5 or 4x4_50)");
    out.family = *family;
    const std::vector<std::string> counts = split(words[1], 'x');
    if (counts.size() != 2 || !readWhole(counts[0], out.columns) || !readWhole(counts[1], out.rows))
        fail("no COLUMNSxROWS '" + words[1] + "'");
    if (std::min(out.columns, out.rows) < 1 || std::max(out.columns, out.rows) > kMaxTagsASide)
        fail("columns and rows must be 1..100");
    if (!readWhole(words[2], out.side) || !(out.side > 0 && out.side <= kLongestSide))
        fail("SIDE must be metres above 0");
    if (!readWhole(words[3], out.gap) || !(out.gap >= 0 && out.gap <= kLongestSide)) fail("GAP must be metres from 0");
    return out;
}

std::vector<SeenPoint> seenGridCorners(const TagGrid& grid, std::span<const DetectedTag> found) {
    std::map<int, const DetectedTag*> once;
    for (const DetectedTag& tag : found) {
        if (tag.family != grid.family || tag.id >= grid.columns * grid.rows) continue;
        if (!once.try_emplace(tag.id, &tag).second)
            throw InvalidInput(std::string("tag ") + nameOf(tag.family) + ":" + std::to_string(tag.id) +
                               " occurs twice: a picture must show only one grid");
    }
    const double pitch = grid.side + grid.gap;
    std::vector<SeenPoint> out;
    for (const auto& [id, tag] : once) {
        const Vec3d middle{(id % grid.columns - (grid.columns - 1) / 2.0) * pitch,
                           ((grid.rows - 1) / 2.0 - id / grid.columns) * pitch, 0};
        for (SeenPoint corner : seenCorners(*tag, grid.side)) {
            corner.point += middle;
            out.push_back(corner);
        }
    }
    return out;
}

}  // namespace penumbra
