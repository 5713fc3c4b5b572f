#pragma once
// Every file format of characters and deforming meshes stands in one table: by which extension it is known, what it
// gives, and who reads it. A new format is a row there (source_readers.cpp) and a reader beside the others, in
// formats/rig or formats/cache.
#include <filesystem>
#include <vector>

#include "formats/cache/point_cache_build.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

struct SourceReader {
    const char* extension;  // in lower case, with its dot
    // Reads a character with its clips. Null: the format has none.
    RigSource (*rig)(const std::filesystem::path& path) = nullptr;
    // Reads positions over time. Null: the format has none. `fps` is PointCacheOptions::fps.
    CacheFile (*cache)(const std::filesystem::path& path, double fps) = nullptr;
    // Reads the mesh of another path that has positions alone. Null: the format is no mesh.
    CacheFile (*mesh)(const std::filesystem::path& path) = nullptr;
    bool positions_alone = false;
    // Looks into a file of a format that may be either, and tells whether it is a cache.
    bool (*is_cache)(const std::filesystem::path& path) = nullptr;
};

// Returns the row of a path: by its extension, or that of numbered meshes for the folder or pattern of a sequence.
// Null where nothing reads it.
const SourceReader* findReader(const std::filesystem::path& path);

// Tells whether readPointCache() reads this path. For a path that cannot be read the name decides.
bool isPointCache(const std::filesystem::path& path);

// Reads several files as one rig. The first one brings mesh and skin; later ones may bring only clips, whose joints
// are matched by name. Checks everything. Throws InvalidInput, which names file and node, and Unsupported for a
// required extension that we do not have. Triangles without area are dropped. A mesh without triangles or with one
// vertex, missing weights and NaN are errors. Rig::notes tells what the files say and nobody does.
Rig readRig(const std::vector<std::filesystem::path>& paths, const RigOptions& options = {});

// Reads a cache of several paths (point_cache.h). Checks everything except the frames' numbers, which are checked when
// they are read. Throws BadOption, IoError, InvalidInput, which names file, field and frame, and
// Unsupported.
PointCache readPointCache(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options);

}  // namespace penumbra
