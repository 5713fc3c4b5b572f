#include "formats/stage/stage_file_kind.h"

#include "formats/stage/hdf5_handle.h"

namespace penumbra {

std::string stageFileKind(const std::filesystem::path& path) {
    return readTextAttribute(openHdf5(path), "/", "format");
}

}  // namespace penumbra
