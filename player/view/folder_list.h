#pragma once
// Finds what the window can open in a folder.
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct FolderList {
    std::filesystem::path folder;                // absolute
    std::vector<std::filesystem::path> folders;  // in it, by name, without hidden ones
    std::vector<std::filesystem::path> files;    // files that the window opens, by name
    // Files of other stages, by name: the window shows them once penumbra-pack has made an asset of them.
    std::vector<std::filesystem::path> unpacked;
    std::string problem;  // why nothing is listed
};

// Lists a folder. A folder that cannot be read has a problem and no entries.
FolderList listFolder(const std::filesystem::path& folder);

// Returns the file that shows `path`: for a character as .glb, .gltf, .vrm, .fbx or .dae the asset beside it that was
// packed of it, and the path itself for all others. Throws InvalidInput where a character has no asset beside it.
std::filesystem::path shownFile(const std::filesystem::path& path);

// Puts a file at the head of those that were opened last, which stay few.
void noteRecent(std::vector<std::filesystem::path>& recent, const std::filesystem::path& file);

}  // namespace penumbra
