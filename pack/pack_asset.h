#pragma once
// Model, materials and lights to the run-time asset.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/asset_file.h"
#include "formats/brdf_file.h"
#include "formats/light_file.h"
#include "formats/model_file.h"

namespace penumbra {

struct PackOptions {
    // Of the visibility basis. I8 keeps the mean and the regressors' input basis in half precision.
    std::optional<AssetPrecision> precision;  // nothing: I8, or what max_error asks for
    std::optional<double> max_error;          // bound on Packed::quantization_error, > 0
};

struct Packed {
    std::vector<std::byte> bytes;  // 16-byte aligned
    AssetPrecision precision = AssetPrecision::kI8;
    // rms of (numbers of this asset - numbers of the F32 asset) / rms of (numbers of the F32 asset - mean), over all
    // frames of the model, both from the run-time evaluator. Stored in the asset.
    double quantization_error = 0;
};

// With max_error and no precision: the coarsest precision within it. InvalidInput when a material or a light is given
// twice, UsageError when max_error cannot be met. Deterministic for any number of threads.
Packed packAsset(const Model& model, std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                 const PackOptions& options, const std::string& provenance, int threads);

const char* nameOf(AssetPrecision precision);  // "f32", "f16", "i8"

struct SizeOf {
    std::string section;
    std::size_t bytes;
};
// Bytes of every section, in the order of the schema; what containers and padding take comes last.
std::vector<SizeOf> sectionSizes(const AssetView& asset, std::size_t file_size);

}  // namespace penumbra
