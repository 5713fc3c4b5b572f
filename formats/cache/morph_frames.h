#pragma once
// Whether the clips of a glTF file play its morph targets as frames, as exporters of cloth and of point caches write
// them.
#include <filesystem>

namespace penumbra {

// Tells whether a glTF file is a point cache: no node has a skin, its clips move weights of morph targets and nothing
// else, and they play the targets as frames one after the other. Any other weights are those of a face or of
// correctives that somebody sets, and the file is a rig. Returns false where the file cannot be read.
bool playsMorphFrames(const std::filesystem::path& path);

}  // namespace penumbra
