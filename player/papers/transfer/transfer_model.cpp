#include "player/papers/transfer/transfer_model.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "runtime/shade/material_tables.h"

namespace penumbra {

namespace {

constexpr int kErrorOrder = 6;          // order of E_transfer for models of visibility (Nowrouzezahrai 2007)
constexpr std::size_t kLitPiece = 512;  // vertices of a task

std::string whatItHas(const AssetView& asset) { return asset.name + " has linear transfer"; }

}  // namespace

bool hasVisibility(const AssetView& asset) { return !asset.transfer; }

void refuseForTransfer(const AssetView& asset, const TransferAsk& ask) {
    if (hasVisibility(asset)) return;
    const std::string what = whatItHas(asset);
    if (ask.clusters) throw BadOption("channel", what + ", which has no clusters");
    if (ask.lobe) throw BadOption("lobe", what + ", which is not visibility");
    if (ask.gpu) throw BadOption("path", what + ", which the CPU evaluates");
    if (ask.crowd) throw BadOption("characters", what + "; crowds are of models of visibility");
}

void requireDiffuse(const AssetView& asset, const ShadingChoice& shading, std::span<const std::size_t> materials) {
    if (hasVisibility(asset)) return;
    const std::string what = whatItHas(asset);
    if (shading.light_form != LightForm::kRotation)
        throw BadOption("light_form", what + ", which takes the light exactly");
    if (shading.reflectance != Reflectance::kSlices) throw BadOption("reflectance", what + ", which is diffuse");
    for (const std::size_t m : materials)
        if (!isLambert(asset.materials[m]))
            throw BadOption("brdf", what + ", which is diffuse, and the material \"" +
                                        std::string(asset.materials[m].name) + "\" is not lambert");
}

bool shadeTransfer(Evaluator& evaluator, const ShadingSet& shading, int threads, std::vector<Vec3>& radiance) {
    if (!evaluator.transfer()) return false;
    radiance.resize(evaluator.vertexCount());
    evaluator.transfer()->setLight(shading.lightTables().sh());
    parallelFor((radiance.size() + kLitPiece - 1) / kLitPiece, threads, [&](std::size_t i) {
        const std::size_t begin = i * kLitPiece, end = std::min(radiance.size(), begin + kLitPiece);
        const std::span<Vec3> piece = std::span(radiance).subspan(begin, end - begin);
        evaluator.transfer()->irradiance(begin, end, piece);
        for (Vec3& v : piece)
            for (int c = 0; c < 3; ++c) v[c] = std::max(v[c], 0.0f);
    });
    shading.reflect(0, radiance.size(), radiance);
    return true;
}

int bandsOfTruth(const AssetView& asset, const AssetView& truth) {
    const int order = asset.model.convention.order;
    if (hasVisibility(asset) && truth.truth.is_transfer)
        throw InvalidInput(truth.name + ": holds diffuse transfer, and the asset's model is of visibility");
    // Transfer takes one more band of visibility than it has.
    return hasVisibility(asset) || truth.truth.is_transfer ? order : order + 1;
}

int transferErrorOrder(const AssetView& asset, const AssetView& truth) {
    return asset.transfer ? asset.transfer->order : std::min(kErrorOrder, truth.truth.order - 1);
}

std::vector<std::string> linesOfTransfer(const AssetView& asset) {
    if (hasVisibility(asset)) return {};
    const TransferView& transfer = *asset.transfer;
    return {"linear transfer, order " + std::to_string(transfer.order),
            std::to_string(transfer.inputs()) + " inputs, " + std::to_string(transfer.outputs()) + " outputs a map"};
}

}  // namespace penumbra
