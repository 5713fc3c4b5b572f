// Runs an importer that may crash in a child process, and takes nothing from it unchecked.
#include "formats/rig/rig_import.h"

#include <unistd.h>

#include <algorithm>
#include <stdexcept>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/rig/rig_bytes.h"

namespace penumbra {

namespace fs = std::filesystem;

RigSource importInChild(const fs::path& path, const RigImporter& importer, const ChildLimits& limits) {
    const auto fail = [&](const std::exception& how) {
        failAtFile(path, std::string("cannot be read (importer crashed): ") + how.what());
    };
    RigSource source;
    try {
        source = rigFromBytes(runInChild([&] { return bytesOf(importer(path)); }, limits));
    } catch (const ChildFailed& how) {
        fail(how);
    } catch (const std::out_of_range& how) {
        fail(how);
    }
    source.file = path;
    source.files_read = {path};
    checkSource(source);
    return source;
}

// A file of 10 MB takes assimp some 200 MB and a second. Compressed FBX and slow machines take several times as much.
ChildLimits importLimits(std::uint64_t file_size) {
    const std::uint64_t machine = std::uint64_t(::sysconf(_SC_PHYS_PAGES)) * std::uint64_t(::sysconf(_SC_PAGESIZE));
    return {std::min((std::uint64_t(4) << 30) + 100 * file_size, machine), 120 + 2e-6 * double(file_size)};
}

RigSource readWithAssimp(const fs::path& path) {
    checkReadable(path);
    std::error_code error;
    const std::uintmax_t size = fs::file_size(path, error);
    if (size == 0) failAtFile(path, "is empty");
    RigSource source = importInChild(path, importWithAssimp, importLimits(error ? 0 : size));
    if (isExtension(path, ".fbx")) collapseFbxPivots(source);
    return source;
}

}  // namespace penumbra
