#pragma once
// Packs a model, materials and lights into the run-time asset.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/asset/asset_file.h"
#include "formats/common/slot_choice.h"
#include "formats/common/sphere_blockers.h"
#include "formats/stage/brdf_file.h"
#include "formats/stage/light_file.h"
#include "formats/stage/model_file.h"
#include "pack/sections/surface_section.h"

namespace penumbra {

constexpr double kBouncedBytes = 60;  // a vertex

struct PackOptions {
    // Precision of the visibility basis. I8 keeps the mean and the regressors' input basis in half precision.
    std::optional<AssetPrecision> precision = {};     // unset: I8, or what max_error asks for
    std::optional<double> max_error = {};             // bound on Packed::quantization_error, > 0
    std::optional<double> max_bytes_per_vertex = {};  // bound on modelBytes() / V, > 0
    // [slots] the material of each slot, "" for the first; none: all have the first. The choices go before these.
    std::vector<std::string> slot_materials = {};
    std::vector<SlotChoice> slots = {};
    bool playback = true;          // store the positions of a deforming mesh in every frame
    SphereBlockers blockers = {};  // none, or those of the model's character (checkCharacter())
    // Bound on the light that bounces, > 0. Unset: kBouncedBytes, or none where the precision alone is given.
    std::optional<double> indirect_bytes_per_vertex = {};
    // The pictures on the mesh. Slots that `slots` do not name then have the diffuse materials of their surface.
    std::optional<SurfaceLook> surface = {};
};

struct Packed {
    std::vector<std::byte> bytes;  // 16-byte aligned
    AssetPrecision precision = AssetPrecision::kI8;
    // rms of (numbers of this asset - numbers of the F32 asset with all components) / rms of (numbers of that asset -
    // mean) over the training frames, both computed by the run-time evaluator. The asset stores it.
    double quantization_error = 0;
    double dropped_error = 0;                        // the part of it that was predicted for the dropped components
    std::size_t components = 0, all_components = 0;  // over all clusters: how many are kept, and how many the model has
    // The same of light that bounces; zeros without.
    double indirect_error = 0;
    std::size_t indirect_components = 0, all_indirect_components = 0;
};

// Packs a model. A precision alone keeps every component as the model has it. Otherwise components are turned to the
// principal axes of what the model predicts, and those that add least for their bytes are dropped (compress_model.h).
// With max_bytes_per_vertex it drops as few as meet the bound, with max_error as many as the bound allows (in the
// coarsest precision that does), and with neither 1e-3 of the squared signal. Throws InvalidInput when a material or
// a light is given twice. Throws UsageError when a bound cannot be met, when the two bounds contradict each other,
// and when a slot or its material does not exist. The result is the same for any number of threads.
Packed packAsset(const Model& model, std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                 const PackOptions& options, const std::string& provenance, int threads);

// Packs materials and lights without a model, for viewers that add them to what they show. Throws InvalidInput as
// packAsset() does.
std::vector<std::byte> packLibrary(std::span<const BrdfFile> materials, std::span<const LightFile> lights,
                                   const std::string& provenance);

constexpr const char* kBouncedSection = "bounced light";
struct SizeOf {
    std::string section;
    std::size_t bytes;
};
// Returns the bytes of every section in the order of the schema; containers and padding come last.
std::vector<SizeOf> sectionSizes(const AssetView& asset, std::size_t file_size);
// Returns the bytes of the visibility model: everything except mesh, skin, animation, truth, materials, lights and
// blockers, and except the fields of a composed model, which stand in a row of their own. Names and layout count.
std::size_t modelBytes(const AssetView& asset, std::size_t file_size);
// Returns for each cluster, and then for each cluster of a residual, the bytes of one component with its row of the
// regression weights; 0 without components.
std::vector<double> componentBytes(const AssetView& asset);

}  // namespace penumbra
