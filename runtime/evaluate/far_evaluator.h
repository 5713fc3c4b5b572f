#pragma once
// What the far parts of a composed asset, and its near ones, leave visible at its vertices as they are skinned now
// (docs/formulas.md, section 7).
#include <array>
#include <memory>
#include <span>
#include <vector>

#include "runtime/evaluate/combine.h"
#include "runtime/evaluate/far_anchors.h"
#include "runtime/evaluate/skinning.h"

namespace penumbra {

// Whether near parts are multiplied in. Checks leave them out where the truth already has them.
enum class NearFactors : std::uint8_t { kWith, kWithout };

class FarEvaluator {
public:
    // `asset` has a composition, and must outlive this object. Copies share what is laid out.
    explicit FarEvaluator(const AssetView& asset);

    void setPose(std::span<const Affine> bones) { pose_.set(decoded_->tables, bones); }
    void setQuality(FarQuality quality) { quality_ = quality; }
    void setNearFactors(NearFactors factors) { near_factors_ = factors; }
    const FarTables& tables() const { return decoded_->tables; }
    const FarLayout& layout() const { return decoded_->layouts[std::size_t(quality_)]; }
    std::span<const PosedPart> posed() const { return pose_.posed; }

    // Writes far[v * kFarCoefficients + i] for the cluster's vertices (farVisibility() and multiplyByNear(),
    // sh/far/far_visibility.h), in an array of all vertices. Calls on different clusters may run at the same time.
    void evaluate(const FarPath& path, const PosedMesh& mesh, std::size_t cluster, std::span<float> far) const;

private:
    struct Decoded {
        FarTables tables;
        std::array<FarLayout, 2> layouts;  // kFull, kFast
        explicit Decoded(const AssetView& asset);
    };
    std::shared_ptr<const Decoded> decoded_;
    FarPose pose_;
    FarQuality quality_ = FarQuality::kFull;
    NearFactors near_factors_ = NearFactors::kWith;
    mutable std::vector<float> anchors_;  // [FarLayout::values] of the larger layout; clusters write different places

    void evaluateRun(const FarPath& path, const PosedMesh& mesh, const FarRun& run, std::size_t cluster,
                     std::span<float> far) const;
};

}  // namespace penumbra
