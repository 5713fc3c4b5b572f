#pragma once
// Photographs as they come, for a window: from a camera that is plugged in, a folder, numbered files or a stream.
#include <chrono>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "formats/camera/video_device.h"
#include "player/composite/picture_stream.h"

namespace penumbra {

// Whether a photograph has come.
enum class LiveNext { kPicture, kNotYet, kEnded };

class LivePlates {
public:
    // `path` is a device such as /dev/video0, whose pictures shall have this size; a folder of numbered pictures; or
    // what PlateSource takes. Throws what VideoDevice and PlateSource throw.
    LivePlates(const std::filesystem::path& path, int width, int height);

    // Takes the next photograph. A folder begins again after its last picture. A camera is waited for no longer than a
    // window may stand still; throws IoError after five seconds without a picture, and what readers of pictures throw.
    LiveNext next(Plate& plate);
    // Number of the picture, from 0; of a folder that of its file in order.
    std::size_t number() const { return number_; }
    // The files of a folder or of numbered files, in order; empty for a camera and a stream.
    std::span<const std::filesystem::path> files() const {
        return source_ ? std::span(source_->files()) : std::span(files_);
    }
    // When the photograph that came last was taken, or where its camera does not say that, when it was asked for.
    std::chrono::steady_clock::time_point taken() const { return taken_; }

private:
    std::string name_;
    std::optional<VideoDevice> device_;
    std::optional<PlateSource> source_;
    std::vector<std::filesystem::path> files_;  // files of a folder
    std::size_t next_ = 0, number_ = 0;
    std::chrono::steady_clock::time_point taken_, came_ = std::chrono::steady_clock::now();

    LiveNext nextOfDevice(Plate& plate);
};

}  // namespace penumbra
