#pragma once
// Model, materials and lights to the run-time asset.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/slot_choice.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/model_file.h"

namespace penumbra {

struct PackOptions {
    // Of the visibility basis. I8 keeps the mean and the regressors' input basis in half precision.
    std::optional<AssetPrecision> precision = {};     // nothing: I8, or what max_error asks for
    std::optional<double> max_error = {};             // bound on Packed::quantization_error, > 0
    std::optional<double> max_bytes_per_vertex = {};  // bound on modelBytes() / V, > 0
    std::vector<SlotChoice> slots = {};               // the others have the first material
    bool playback = true;                             // the positions of a deforming mesh in every frame
};

struct Packed {
    std::vector<std::byte> bytes;  // 16-byte aligned
    AssetPrecision precision = AssetPrecision::kI8;
    // rms of (numbers of this asset - numbers of the F32 asset with all components) / rms of (numbers of that asset -
    // mean), over the training frames, both from the run-time evaluator. Stored in the asset.
    double quantization_error = 0;
    double dropped_error = 0;  // the part of it that was predicted for the components that were dropped
    std::size_t components = 0, all_components = 0;  // of all clusters: kept, and of the model
};

// A precision alone: every component, as the model has them. Else components are turned to the principal axes of what
// the model predicts, and those dropped that add least for their bytes (compress_model.h): with max_bytes_per_vertex as
// few as meet it, with max_error as many as it allows (in the coarsest precision that does), with neither 1e-3 of the
// squared signal. InvalidInput when a material or a light is given twice, UsageError when a bound cannot be met or the
// two contradict, or a slot or its material does not exist. Deterministic for any number of threads.
Packed packAsset(const Model& model, std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                 const PackOptions& options, const std::string& provenance, int threads);

// Materials and lights without a model, for viewers that add them to what they show. InvalidInput as packAsset().
std::vector<std::byte> packLibrary(std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                                   const std::string& provenance);

struct SizeOf {
    std::string section;
    std::size_t bytes;
};
// Bytes of every section, in the order of the schema; what containers and padding take comes last.
std::vector<SizeOf> sectionSizes(const AssetView& asset, std::size_t file_size);
// The visibility model: everything but mesh, skin, animation, truth, materials and lights; names and layout count.
std::size_t modelBytes(const AssetView& asset, std::size_t file_size);
// [cluster]: bytes of one component, its row of the regression weights included; 0 without components.
std::vector<double> componentBytes(const AssetView& asset);

}  // namespace penumbra
