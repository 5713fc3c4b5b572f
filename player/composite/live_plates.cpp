#include "player/composite/live_plates.h"

#include "formats/cache/numbered_files.h"

namespace penumbra {

LivePlates::LivePlates(const std::filesystem::path& path, int width, int height) {
    std::error_code error;
    if (std::filesystem::is_character_file(path, error))
        device_.emplace(path, width, height);
    else if (std::filesystem::is_directory(path, error))
        files_ = findNumberedFiles(path, {".jpg", ".jpeg", ".png", ".exr"}).files;
    else
        source_.emplace(path);
}

bool LivePlates::next(Plate& plate) {
    number_ = next_++;
    if (device_) {
        plate = {device_->next(), {}};
        return true;
    }
    const std::size_t count = source_ ? source_->count().value_or(0) : files_.size();
    if (count > 0) number_ %= count;
    if (source_) return source_->read(number_, plate);
    plate = readPlate(files_[number_]);
    return true;
}

std::optional<double> LivePlates::age() const {
    if (!device_ || device_->age() < 0) return std::nullopt;
    return device_->age();
}

}  // namespace penumbra
