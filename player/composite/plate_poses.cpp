#include "player/composite/plate_poses.h"

#include <algorithm>
#include <map>

namespace penumbra {

namespace {

using Names = std::map<std::string, std::optional<std::size_t>>;  // none: several frames have this name

void add(Names& names, const std::string& name, std::size_t picture) {
    if (name.empty()) return;
    const auto [place, is_new] = names.try_emplace(name, picture);
    if (!is_new) place->second = std::nullopt;
}

std::optional<std::size_t> find(const Names& names, const std::string& name) {
    const auto found = names.find(name);
    return found == names.end() ? std::nullopt : found->second;
}

// Returns the last digits of a name without its extension, without zeros before them; empty: there are none.
std::string lastNumber(const std::filesystem::path& file) {
    constexpr const char* kDigits = "0123456789";
    const std::string stem = file.stem().string();
    const std::size_t last = stem.find_last_of(kDigits);
    if (last == std::string::npos) return "";
    const std::size_t before = stem.find_last_not_of(kDigits, last);
    std::string digits = stem.substr(before == std::string::npos ? 0 : before + 1, last - before);
    digits.erase(0, std::min(digits.find_first_not_of('0'), digits.size() - 1));
    return digits;
}

struct FrameNames {
    Names whole, stems, numbers;

    explicit FrameNames(std::span<const std::string> files) {
        for (std::size_t i = 0; i < files.size(); ++i) {
            const std::filesystem::path file = files[i];
            add(whole, file.filename().string(), i);
            add(stems, file.stem().string(), i);
            add(numbers, lastNumber(file), i);
        }
    }
};

}  // namespace

PlatePoses::PlatePoses(const SceneCameras& cameras, std::span<const std::filesystem::path> files)
    : cameras_(cameras), stream_(files.empty()) {
    const FrameNames names(cameras.files());
    for (std::size_t i = 0; i < files.size(); ++i) {
        std::optional<std::size_t>& picture = picture_of_file_.emplace_back();
        if (!cameras.moves() || names.whole.empty()) {
            if (!cameras.moves() || i < cameras.count()) picture = i;
            continue;
        }
        picture = find(names.whole, files[i].filename().string());
        if (!picture) picture = find(names.stems, files[i].stem().string());
        if (!picture) picture = find(names.numbers, lastNumber(files[i]));
        if (!picture && files.size() == 1) picture = 0;
    }
}

std::optional<std::size_t> PlatePoses::pictureOf(std::size_t i) const {
    if (!stream_) return i < picture_of_file_.size() ? picture_of_file_[i] : std::nullopt;
    if (cameras_.moves() && i >= cameras_.count()) return std::nullopt;
    return i;
}

bool PlatePoses::hasPose(std::size_t i) const {
    const std::optional<std::size_t> picture = pictureOf(i);
    return picture && cameras_.hasPose(*picture);
}

std::vector<std::size_t> PlatePoses::without() const {
    std::vector<std::size_t> out;
    const std::size_t count = stream_ ? (cameras_.moves() ? cameras_.count() : 0) : picture_of_file_.size();
    for (std::size_t i = 0; i < count; ++i)
        if (!hasPose(i)) out.push_back(i);
    return out;
}

}  // namespace penumbra
