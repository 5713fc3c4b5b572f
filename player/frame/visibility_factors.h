#pragma once
// Takes the visibility of one vertex of a composed asset apart: visibility = local x far + residual, far = the product
// over all far parts (docs/formulas.md, section 7).
#include <string>
#include <string_view>
#include <vector>

#include "runtime/evaluate/evaluator.h"

namespace penumbra {

enum class FactorKind {
    kWhole,     // what is drawn
    kLocal,     // what the vertex sees past the parts near it in the skeleton
    kFar,       // what all far parts leave visible
    kPart,      // what one far part leaves visible
    kResidual,  // what is added to local x far
};
struct FactorChoice {
    FactorKind kind = FactorKind::kWhole;
    std::size_t part = 0;  // of the asset, only for kPart
    bool operator==(const FactorChoice&) const = default;
};

struct VisibilityFactor {
    FactorChoice choice;
    Convention convention;            // a far factor has more bands than the model
    std::vector<float> coefficients;  // in the vertex' local frame
    float ambient = 0;                // E of these numbers; of the residual what it adds to E before E is clamped
};

// Returns the joint that a part moves with, by which the part is called. One that stands still has its number instead.
std::string nameOfPart(const AssetView& asset, std::size_t part);
// Returns the part that is called `word`, or of the only one whose name begins so. Throws BadOption, which names
// `option` and what there is.
std::size_t findPart(const AssetView& asset, std::string_view word, const std::string& option);
// Returns, for instance, "local" or "far: LeftArm".
std::string nameOf(const AssetView& asset, const FactorChoice& choice);

// Returns the factors of a vertex in the evaluator's pose: the whole, local, far, residual if the asset has one, then
// the far parts that block anything there, those that take most of E first. Of an asset that is not composed it is the
// whole alone.
std::vector<VisibilityFactor> visibilityFactors(const Evaluator& evaluator, std::size_t vertex);

// Returns one of these factors; a far part that blocks nothing has one too. It throws BadOption for a residual that
// the asset has not, for a part that is not far from the vertex, and for any factor but the whole where the asset is
// not composed.
VisibilityFactor visibilityFactor(const Evaluator& evaluator, std::size_t vertex, const FactorChoice& choice);

// Reads "whole", "local", "far", "residual", or the joint of a part or how only its name begins. Throws BadOption for
// other words.
FactorChoice parseFactor(const AssetView& asset, std::string_view word);

}  // namespace penumbra
