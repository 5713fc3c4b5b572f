#pragma once
// FBX2glTF 0.9.7 (npm package fbx2gltf), a program with Autodesk's FBX SDK inside, run as a confined child process.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/confine.h"
#include "formats/rig/fbx/fbx_scan.h"

namespace penumbra {

// Returns where the converter is: PENUMBRA_FBX2GLTF names it ("off": there is none), else PATH, else the folder that
// `scripts/setup --fbx` puts it into ($XDG_DATA_HOME/penumbra or ~/.local/share/penumbra). Throws IoError where
// PENUMBRA_FBX2GLTF names no program.
std::optional<std::filesystem::path> findConverter();

// The frames that the converter says a clip has, at framesASecond().
struct FbxConvertedClip {
    std::string name;
    double first = 0, last = 0;  // seconds of the timeline
};

struct FbxConversion {
    std::string problem;         // why there is no result; "" where there is one
    std::vector<std::byte> glb;  // the result; weights are 0 where the converter writes NaN for a vertex without any
    std::vector<FbxConvertedClip> clips;
    // Textures whose pictures it did not find. In the .glb each has a picture of one pixel.
    std::vector<std::string> missing_pictures;
    Confinement confinement;
    bool lost_old_clips = false;  // the file is of FBX 6 and has keys, the result has no clip
};

// Converts a file and checks what comes of it: the exit status, the length that the .glb states, its JSON, and that it
// has a mesh and the clips that the scan saw. Throws IoError where no temporary folder can be made, and Interrupted.
FbxConversion convertFbx(const std::filesystem::path& converter, const FbxScan& scan);

}  // namespace penumbra
