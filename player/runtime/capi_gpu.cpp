// The part of penumbra.h that gives a GPU what it needs to shade and to cast.
#include <algorithm>
#include <cstring>

#include "player/runtime/capi_handles.h"
#include "player/runtime/cast_glsl.h"
#include "player/runtime/shading_glsl.h"
#include "sh/cap_visibility.h"

namespace penumbra {

namespace {

// Hands out a text as penumbra.h says of `text`, `capacity` and `length`.
void copyGlsl(const std::string& glsl, char* text, size_t capacity, size_t* length) {
    *length = glsl.size();
    if (!text) return;
    if (capacity <= glsl.size())
        throw UsageError("capacity is " + std::to_string(capacity) + ", the text and its zero take " +
                         std::to_string(glsl.size() + 1));
    std::memcpy(text, glsl.c_str(), glsl.size() + 1);
}

}  // namespace

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_shading_get_glsl(const penumbra_shading* shading, char* text, size_t capacity, size_t* length,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requirePointer(length, "length");
        const ModelView& model = shading->view.model;
        const std::string glsl = "// Convention " + model.convention.name() + ", light order " +
                                 std::to_string(shading->layout.light_order) + "\n#define PENUMBRA_STRIDE4 " +
                                 std::to_string(model.stride / 4) + "\n" + ambientGlsl(model.convention) +
                                 shadingGlsl(shading->layout);
        copyGlsl(glsl, text, capacity, length);
    });
}

size_t penumbra_shading_gpu_material_texels(const penumbra_shading* shading) {
    return shading ? shading->layout.materialTexels() : 0;
}

size_t penumbra_shading_gpu_light_texels(const penumbra_shading* shading) {
    return shading ? shading->layout.lightTexels() : 0;
}

penumbra_status penumbra_shading_get_gpu_materials(const penumbra_shading* shading, float* texels,
                                                   penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requirePointer(texels, "texels");
        const std::vector<float> data = materialData(shading->layout, *shading->set);
        std::copy(data.begin(), data.end(), texels);
    });
}

penumbra_status penumbra_shading_get_gpu_light(const penumbra_shading* shading, float* texels, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requirePointer(texels, "texels");
        writeLightData(shading->layout, shading->set->lightTables(), {texels, 4 * shading->layout.lightTexels()});
    });
}

penumbra_status penumbra_cast_get_glsl(const penumbra_asset* asset, char* text, size_t capacity, size_t* length,
                                       penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(length, "length");
        if (asset && !asset->data->view.has_model) throw Unsupported(asset->data->view.name + ": has no model");
        copyGlsl(castGlsl() + (asset ? castNumbersGlsl(asset->data->view.model.convention) : ""), text, capacity,
                 length);
    });
}

penumbra_status penumbra_get_cap_logs(float* texels, penumbra_error* error) {
    static_assert(2 * kCapLogEntries == PENUMBRA_CAP_LOG_TEXELS);
    return guarded(error, [&] {
        requirePointer(texels, "texels");
        std::ranges::copy(capLogTexels(), texels);
    });
}
