#pragma once
// Photographs as they come, for a window: from a camera that is plugged in, a folder, numbered files or a stream.
#include <filesystem>
#include <optional>

#include "formats/camera/video_device.h"
#include "player/composite/picture_stream.h"

namespace penumbra {

class LivePlates {
public:
    // `path` is a device such as /dev/video0, whose pictures shall have this size; a folder of numbered pictures; or
    // what PlateSource takes. Throws what VideoDevice and PlateSource throw.
    LivePlates(const std::filesystem::path& path, int width, int height);

    // Waits for the next photograph. A folder begins again after its last picture; false: a stream has ended. Throws
    // what readers of pictures throw.
    bool next(Plate& plate);
    // Number of the picture, from 0; of a folder that of its file in order.
    std::size_t number() const { return number_; }
    // How long ago the photograph that came last was taken, seconds. None where nobody knows.
    std::optional<double> age() const;

private:
    std::optional<VideoDevice> device_;
    std::optional<PlateSource> source_;
    std::vector<std::filesystem::path> files_;  // of a folder
    std::size_t next_ = 0, number_ = 0;
};

}  // namespace penumbra
