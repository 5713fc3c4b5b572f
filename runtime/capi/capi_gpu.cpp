// The part of penumbra.h that gives a GPU what it needs to shade and to cast.
#include <algorithm>
#include <cstring>

#include "runtime/capi/capi_handles.h"
#include "runtime/glsl/brdf_glsl.h"
#include "runtime/glsl/cast_glsl.h"
#include "runtime/glsl/far_glsl.h"
#include "runtime/glsl/shading_glsl.h"
#include "sh/cast/cap_visibility.h"

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

// Transfer is evaluated by the CPU alone.
void requireShader(const penumbra_shading* shading) {
    requirePointer(shading, "shading");
    refuseTransfer<Unsupported>(shading->view, "there is no shader for transfer");
}

bool hasFields(const penumbra_asset& asset) { return asset.data->view.has_model && asset.data->view.model.composition; }
const CompositionView& compositionOf(const penumbra_asset& asset) { return *asset.data->view.model.composition; }

// Fields can be read at `first_word` of a buffer.
void requireFields(const penumbra_asset& asset, std::size_t first_word) {
    if (!hasFields(asset)) throw Unsupported(asset.data->view.name + ": has no fields of parts");
    if (first_word % 4 != 0 || first_word >= kMaxFieldWords ||
        fieldBlockWords(compositionOf(asset)) > kMaxFieldWords - first_word)
        throw UsageError("first_word is " + std::to_string(first_word) +
                         ", it must be a multiple of 4 with room for the fields below " +
                         std::to_string(kMaxFieldWords));
}

// A shader can do what far.glsl does for the asset.
bool canComposeOnGpu(const penumbra_asset& asset) {
    return hasFields(asset) && !compositionOf(asset).floor && asset.data->view.model.convention.order <= kFieldOrder;
}

// The words of penumbra_asset_get_far.
std::vector<std::uint32_t> composedWords(const penumbra_asset& asset) {
    const CompositionView& composition = compositionOf(asset);
    const Evaluator evaluator = asset.data->restPose();
    const FarWords far = makeFarWords(evaluator.farTables(), evaluator.farLayout());
    constexpr std::size_t kHead = 9;
    std::vector<std::uint32_t> words = {std::uint32_t(far.anchors.size() / 2), std::uint32_t(far.anchor_values),
                                        std::uint32_t(composition.near_count)};
    words.resize(kHead);
    std::size_t array = 3;
    const auto add = [&](const auto& values) {
        words[array++] = std::uint32_t(words.size());
        words.insert(words.end(), values.begin(), values.end());
    };
    add(far.lists);
    add(far.anchors);
    add(far.receivers);
    add(composition.part_of_vertex);
    add(composition.near_parts);
    add(composition.near_gains);
    return words;
}

}  // namespace

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_shading_get_glsl(const penumbra_shading* shading, char* text, size_t capacity, size_t* length,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requireShader(shading);
        requirePointer(length, "length");
        const ModelView& model = shading->view.model;
        const std::string glsl = "// Convention " + model.convention.name() + ", light order " +
                                 std::to_string(shading->layout.light_order) + "\n#define PENUMBRA_STRIDE4 " +
                                 std::to_string(model.stride / 4) + "\n" + ambientGlsl(model.convention) +
                                 (shading->view.mesh.follower_corners.empty() ? "" : followGlsl(model.convention)) +
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
        requireShader(shading);
        requirePointer(texels, "texels");
        const std::vector<float> data = materialData(shading->layout, *shading->set);
        std::copy(data.begin(), data.end(), texels);
    });
}

penumbra_status penumbra_shading_get_gpu_light(const penumbra_shading* shading, float* texels, penumbra_error* error) {
    return guarded(error, [&] {
        requireShader(shading);
        requirePointer(texels, "texels");
        writeLightData(shading->layout, *shading->set, {texels, 4 * shading->layout.lightTexels()});
    });
}

penumbra_status penumbra_brdf_get_glsl(char* text, size_t capacity, size_t* length, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(length, "length");
        copyGlsl(brdfGlsl(), text, capacity, length);
    });
}

penumbra_status penumbra_cast_get_glsl(const penumbra_asset* asset, char* text, size_t capacity, size_t* length,
                                       penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(length, "length");
        if (asset && !asset->data->view.has_model) throw Unsupported(asset->data->view.name + ": has no model");
        copyGlsl(castGlsl() + (asset ? castCoefficientsGlsl(asset->data->view.model.convention) : ""), text, capacity,
                 length);
    });
}

size_t penumbra_asset_part_count(const penumbra_asset* asset) {
    return asset && hasFields(*asset) ? compositionOf(*asset).parts.size() : 0;
}

size_t penumbra_asset_field_words(const penumbra_asset* asset) {
    return asset && hasFields(*asset) ? fieldBlockWords(compositionOf(*asset)) : 0;
}

penumbra_status penumbra_asset_get_fields(const penumbra_asset* asset, size_t first_word, uint32_t* words,
                                          penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", words, "words");
        requireFields(*asset, first_word);
        const Evaluator evaluator = asset->data->restPose();
        writeFieldBlock(evaluator.farTables(), compositionOf(*asset), std::uint32_t(first_word),
                        {words, penumbra_asset_field_words(asset)});
    });
}

penumbra_status penumbra_character_get_parts(const penumbra_character* character, const float* to_scene,
                                             size_t first_word, float* rows, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(character, "character", rows, "rows");
        requireFields({character->asset}, first_word);
        const Affine placed = rigidOf(to_scene);
        auto words = std::uint32_t(first_word);
        for (const PosedPart& part : character->evaluator.posedParts()) {
            writePosedPart(part, placed, words, rows);
            rows += 4 * kPosedPartRows;
            words += kFarPartWords;
        }
    });
}

size_t penumbra_asset_far_words(const penumbra_asset* asset) {
    std::size_t words = 0;
    guarded(nullptr, [&] {
        if (asset && canComposeOnGpu(*asset)) words = composedWords(*asset).size();
    });
    return words;
}

penumbra_status penumbra_asset_get_far(const penumbra_asset* asset, uint32_t* words, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(asset, "asset", words, "words");
        if (!canComposeOnGpu(*asset))
            throw Unsupported(asset->data->view.name + ": has no composed model that a shader can evaluate");
        std::ranges::copy(composedWords(*asset), words);
    });
}

penumbra_status penumbra_far_get_glsl(char* text, size_t capacity, size_t* length, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(length, "length");
        const FarTables none({}, {}, kFieldOrder);  // has the constants of all
        copyGlsl(farGlsl(none.constants()), text, capacity, length);
    });
}

penumbra_status penumbra_get_cap_logs(float* texels, penumbra_error* error) {
    static_assert(2 * kCapLogEntries == PENUMBRA_CAP_LOG_TEXELS);
    return guarded(error, [&] {
        requirePointer(texels, "texels");
        std::ranges::copy(capLogTexels(), texels);
    });
}
