#pragma once
// Which pose of a scene's camera belongs to which photograph.
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/scene/scene_camera.h"

namespace penumbra {

// Pairs photographs that are files with the frames of a track by their names without folders: by the whole name, else
// without the extension, else by the last number in it (p.012.png belongs to film/007/q_0012.jpg), if that is the
// number of one frame alone. A track whose frames have no names is paired in order. One file alone has the first frame
// where no name fits, and a camera that stands still has all photographs.
class PlatePoses {
public:
    // `files` is empty for a stream, whose pictures come in the order of the frames.
    PlatePoses(const SceneCameras& cameras, std::span<const std::filesystem::path> files);

    // The picture for SceneCameras::view() of photograph i; none where the track has no frame for it.
    std::optional<std::size_t> pictureOf(std::size_t i) const;
    // Tells whether the photograph has a frame, and that a pose.
    bool hasPose(std::size_t i) const;
    // Numbers of the photographs without a pose: of files all, of a stream those of the frames that there are.
    std::vector<std::size_t> without() const;

private:
    const SceneCameras& cameras_;
    bool stream_;
    std::vector<std::optional<std::size_t>> picture_of_file_;
};

}  // namespace penumbra
