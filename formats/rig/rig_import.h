#pragma once
// Runs an importer that may crash.
#include <functional>

#include "formats/common/child_process.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

// Reads a file with assimp in this process, which a damaged file may crash. What it returns is as assimp has it:
// numbers may not be finite, and chains of FBX nodes are not joined. Throws InvalidInput and Unsupported.
RigSource importWithAssimp(const std::filesystem::path& path);
// The same for the text of a file, which `path` names for messages and for what it refers to.
RigSource importTextWithAssimp(const std::filesystem::path& path, const std::string& text);

// Returns where a picture lies: as the file says, or beside the rig under the same name. Files often hold the path of
// the machine that wrote them.
std::filesystem::path findPicture(const std::filesystem::path& rig, std::string name);

// Returns a .x text without bones that weigh no vertex (SkinWeights of 0 vertices), on which assimp's reader of text
// fails.
std::string withoutEmptyWeights(const std::string& text);

using RigImporter = std::function<RigSource(const std::filesystem::path&)>;
// Runs an importer in a child process and checks what it hands back. The errors of the importer leave this function as
// they are. Throws InvalidInput "FILE: cannot be read (importer crashed): HOW" where it crashes or passes a limit.
RigSource importInChild(const std::filesystem::path& path, const RigImporter& importer, const ChildLimits& limits);

// The limits for a file of so many bytes: generous, so that only an importer that has lost its way passes them.
ChildLimits importLimits(std::uint64_t file_size);

}  // namespace penumbra
