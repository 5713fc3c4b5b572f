#include "formats/source/source_readers.h"

#include <algorithm>
#include <string>

#include "formats/cache/morph_frames.h"
#include "formats/cache/numbered_files.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

RigSource readGltfRig(const std::filesystem::path& path) { return readGltf(path); }

// The last two rows also read the folder or pattern of a sequence.
constexpr SourceReader kReaders[] = {
    {.extension = ".glb", .rig = readGltfRig, .cache = readGltfCache, .is_cache = playsMorphFrames},
    {.extension = ".gltf", .rig = readGltfRig, .cache = readGltfCache, .is_cache = playsMorphFrames},
    {.extension = ".vrm", .rig = readGltfRig, .cache = readGltfCache, .is_cache = playsMorphFrames},
    {.extension = ".fbx", .rig = readFbx},
    {.extension = ".dae", .rig = readCollada},
    {.extension = ".x", .rig = readWithAssimp},
    {.extension = ".bvh", .rig = readBvh},
    {.extension = ".npz", .cache = readNpzCache},
    {.extension = ".npy", .cache = readNpyCache, .positions_alone = true},
    {.extension = ".mdd", .cache = readMddCache, .positions_alone = true},
    {.extension = ".pc2", .cache = readPc2Cache, .positions_alone = true},
    {.extension = ".obj", .cache = readSequenceCache, .mesh = readMeshOfCache},
    {.extension = ".ply", .cache = readSequenceCache, .mesh = readMeshOfCache},
};

// Returns ".glb, .gltf and .x" of the rows that have `part`.
template <typename Part>
std::string extensionsWith(Part part) {
    std::string text, last;
    for (const SourceReader& reader : kReaders) {
        if (!(reader.*part)) continue;
        if (!last.empty()) text += (text.empty() ? "" : ", ") + last;
        last = reader.extension;
    }
    return text + " and " + last;
}

bool givesPositionsAlone(const std::filesystem::path& path) {
    const SourceReader* reader = findReader(path);
    return reader && reader->positions_alone;
}

CacheFile readCacheFile(const std::filesystem::path& path, double fps, bool beside_positions) {
    const SourceReader* reader = findReader(path);
    if (!reader || !reader->cache)
        throw Unsupported(path.string() + ": not a point cache (" + extensionsWith(&SourceReader::cache) +
                          " are read: meshes where they are numbered, glTF with morph targets)");
    return reader->mesh && beside_positions && !namesSequence(path) ? reader->mesh(path) : reader->cache(path, fps);
}

RigSource readRigSource(const std::filesystem::path& path) {
    const SourceReader* reader = findReader(path);
    if (!reader || !reader->rig)
        throw Unsupported(path.string() + ": not a rig (" + extensionsWith(&SourceReader::rig) + " are read)");
    return reader->rig(path);
}

}  // namespace

const SourceReader* findReader(const std::filesystem::path& path) {
    const auto reads = [&](const SourceReader& reader) { return isExtension(path, reader.extension); };
    const auto found = std::find_if(std::begin(kReaders), std::end(kReaders), reads);
    if (found != std::end(kReaders)) return found;
    return namesSequence(path) ? std::end(kReaders) - 1 : nullptr;
}

bool isPointCache(const std::filesystem::path& path) {
    const SourceReader* reader = findReader(path);
    return reader && reader->cache && (!reader->is_cache || reader->is_cache(path));
}

Rig readRig(const std::vector<std::filesystem::path>& paths, const RigOptions& options) {
    std::vector<RigSource> sources;
    for (const std::filesystem::path& path : paths) sources.push_back(readRigSource(path));
    return joinRig(std::move(sources), options);
}

PointCache readPointCache(const std::vector<std::filesystem::path>& paths, const PointCacheOptions& options) {
    const bool beside_positions = std::any_of(paths.begin(), paths.end(), givesPositionsAlone);
    std::vector<CacheFile> files;
    for (const std::filesystem::path& path : paths) files.push_back(readCacheFile(path, options.fps, beside_positions));
    return joinCache(paths, std::move(files), options);
}

}  // namespace penumbra
