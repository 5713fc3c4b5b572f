#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/gltf_numbers.h"

namespace penumbra {

struct GltfNumbers::Impl {
    GltfFile file;
};

GltfNumbers::GltfNumbers(const std::filesystem::path& path) : impl_(std::make_unique<Impl>(Impl{openGltf(path)})) {}

GltfNumbers::~GltfNumbers() = default;

GltfArray GltfNumbers::read(std::size_t accessor, const std::string& what) const {
    if (accessor >= impl_->file.model.accessors.size()) failAtFile(impl_->file.path, what + ": has no such accessor");
    AccessorValues values = readAccessor(impl_->file, int(accessor), what);
    return {std::size_t(values.components), std::move(values.values)};
}

}  // namespace penumbra
