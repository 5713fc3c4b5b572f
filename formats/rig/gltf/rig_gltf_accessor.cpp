#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <span>

#include "formats/rig/gltf/rig_gltf.h"
#include "formats/rig/rig_build.h"

namespace penumbra {

// An accessor without a buffer view is all zeros and costs no bytes. This limit keeps a small file from asking for a
// lot.
constexpr std::size_t kMaxImplicitElements = std::size_t(1) << 24;

namespace {
struct Layout {
    const unsigned char* data = nullptr;
    std::size_t stride = 0;
    int component_type = 0;
};
struct Reader {
    const GltfFile& file;
    const std::string& what;

    [[noreturn]] void fail(const std::string& problem) const { failAtFile(file.path, what + ": " + problem); }
    // Finds `count` elements of `components` each, `offset` bytes into a buffer view. Stride 0 means the view's own
    // stride, or packed elements.
    Layout locate(int view_index, std::size_t offset, std::size_t count, std::size_t components, int type) const;
};

std::size_t componentSize(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

}  // namespace

Layout Reader::locate(int view_index, std::size_t offset, std::size_t count, std::size_t components, int type) const {
    const tinygltf::Model& model = file.model;
    if (view_index < 0 || std::size_t(view_index) >= model.bufferViews.size()) fail("has no such buffer view");
    const tinygltf::BufferView& view = model.bufferViews[std::size_t(view_index)];
    if (view.buffer < 0 || std::size_t(view.buffer) >= model.buffers.size()) fail("has no such buffer");
    const std::vector<unsigned char>& bytes = model.buffers[std::size_t(view.buffer)].data;
    if (view.byteOffset > bytes.size() || view.byteLength > bytes.size() - view.byteOffset)
        fail("its buffer view reaches beyond the buffer");
    const std::size_t element = componentSize(type) * components;
    const std::size_t stride = view.byteStride == 0 ? element : view.byteStride;
    if (stride < element) fail("its byte stride is smaller than an element");
    if (offset > view.byteLength || element > view.byteLength - offset ||
        (count - 1) > (view.byteLength - offset - element) / stride)
        fail("reaches beyond its buffer view");
    return {bytes.data() + view.byteOffset + offset, stride, type};
}

namespace {

template <class T>
double load(const unsigned char* p) {
    T value;
    std::memcpy(&value, p, sizeof value);
    return double(value);
}

double loadComponent(const unsigned char* p, int type, bool normalized) {
    switch (type) {  // glTF 2.0 section 3.11, "normalized": f = c / max, and max(c / max, -1) for signed types
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return normalized ? std::max(load<std::int8_t>(p) / 127.0, -1.0) : load<std::int8_t>(p);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return normalized ? load<std::uint8_t>(p) / 255.0 : load<std::uint8_t>(p);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return normalized ? std::max(load<std::int16_t>(p) / 32767.0, -1.0) : load<std::int16_t>(p);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return normalized ? load<std::uint16_t>(p) / 65535.0 : load<std::uint16_t>(p);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return load<std::uint32_t>(p);
        default:
            return load<float>(p);
    }
}

void loadElement(const Layout& layout, std::size_t index, bool normalized, std::span<double> out) {
    const unsigned char* p = layout.data + index * layout.stride;
    for (std::size_t c = 0; c < out.size(); ++c)
        out[c] = loadComponent(p + c * componentSize(layout.component_type), layout.component_type, normalized);
}

void applySparse(const Reader& reader, const tinygltf::Accessor& accessor, AccessorValues& out) {
    const auto& sparse = accessor.sparse;
    if (sparse.count <= 0 || std::size_t(sparse.count) > accessor.count) reader.fail("has a wrong sparse count");
    // tinygltf 2.8 has these offsets as int, 2.9 as std::size_t.
    const auto indices_at = std::int64_t(sparse.indices.byteOffset), values_at = std::int64_t(sparse.values.byteOffset);
    if (indices_at < 0 || values_at < 0) reader.fail("has a negative sparse offset");
    const int type = sparse.indices.componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        reader.fail("has sparse indices of a wrong type");
    const std::size_t count = std::size_t(sparse.count), components = std::size_t(out.components);
    const Layout indices = reader.locate(sparse.indices.bufferView, std::size_t(indices_at), count, 1, type);
    const Layout values =
        reader.locate(sparse.values.bufferView, std::size_t(values_at), count, components, accessor.componentType);
    for (std::size_t i = 0; i < count; ++i) {
        double index = 0;
        loadElement(indices, i, false, std::span(&index, 1));
        if (index >= double(accessor.count)) reader.fail("has a sparse index out of range");
        loadElement(values, i, accessor.normalized,
                    std::span(out.values).subspan(std::size_t(index) * components, components));
    }
}

}  // namespace

AccessorValues readAnyNumbers(const GltfFile& file, int index, const std::string& what) {
    const Reader reader{file, what};
    if (index < 0 || std::size_t(index) >= file.model.accessors.size()) reader.fail("has no such accessor");
    const tinygltf::Accessor& accessor = file.model.accessors[std::size_t(index)];
    const int components = tinygltf::GetNumComponentsInType(std::uint32_t(accessor.type));
    if (components <= 0 || componentSize(accessor.componentType) == 0) reader.fail("has an unknown type");
    if (accessor.count == 0) reader.fail("is empty");

    AccessorValues out{components, {}};
    if (accessor.bufferView < 0) {
        if (accessor.count > kMaxImplicitElements) reader.fail("has too many elements without data");
        out.values.assign(accessor.count * std::size_t(components), 0.0);
    } else {
        const Layout layout = reader.locate(accessor.bufferView, accessor.byteOffset, accessor.count,
                                            std::size_t(components), accessor.componentType);
        out.values.resize(accessor.count * std::size_t(components));
        for (std::size_t i = 0; i < accessor.count; ++i)
            loadElement(layout, i, accessor.normalized,
                        std::span(out.values).subspan(i * std::size_t(components), std::size_t(components)));
    }
    if (accessor.sparse.isSparse) applySparse(reader, accessor, out);
    return out;
}

AccessorValues readAccessor(const GltfFile& file, int index, const std::string& what) {
    AccessorValues out = readAnyNumbers(file, index, what);
    for (const double v : out.values)
        if (!std::isfinite(v)) failAtFile(file.path, what + ": holds a number that is not finite");
    return out;
}

}  // namespace penumbra
