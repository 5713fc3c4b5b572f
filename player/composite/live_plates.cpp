#include "player/composite/live_plates.h"

#include "formats/cache/numbered_files.h"
#include "formats/common/errors.h"

namespace penumbra {

LivePlates::LivePlates(const std::filesystem::path& path, int width, int height) : name_(path.string()) {
    std::error_code error;
    if (std::filesystem::is_character_file(path, error))
        device_.emplace(path, width, height);
    else if (std::filesystem::is_directory(path, error))
        files_ = findNumberedFiles(path, {".jpg", ".jpeg", ".png", ".exr"}).files;
    else
        source_.emplace(path);
}

LiveNext LivePlates::nextOfDevice(Plate& plate) {
    constexpr std::chrono::milliseconds kWait(30), kPatience(5000);
    std::optional<TexturePicture> picture = device_->poll(kWait);
    const auto now = std::chrono::steady_clock::now();
    if (!picture) {
        if (now - came_ > kPatience) throw IoError(name_ + ": no picture comes");
        return LiveNext::kNotYet;
    }
    came_ = now;
    taken_ = device_->taken().value_or(taken_);
    plate = {std::move(*picture), {}};
    number_ = next_++;
    return LiveNext::kPicture;
}

LiveNext LivePlates::next(Plate& plate) {
    taken_ = std::chrono::steady_clock::now();
    if (device_) return nextOfDevice(plate);
    number_ = next_++;
    const std::size_t count = source_ ? source_->count().value_or(0) : files_.size();
    if (count > 0) number_ %= count;
    if (source_) return source_->read(number_, plate) ? LiveNext::kPicture : LiveNext::kEnded;
    plate = readPlate(files_[number_]);
    return LiveNext::kPicture;
}

}  // namespace penumbra
