#pragma once
// Says what is wrong where E of an asset is most wrong.
#include <array>
#include <string>
#include <vector>

#include "formats/common/words.h"
#include "pack/check/check_asset.h"
#include "pack/check/worst_pairs.h"

namespace penumbra {

// The part of the model that adds most to the error of a place, in the error's direction.
enum class PlaceCause {
    kSunkenDark,   // the vertex is inside a far part, which darkens it; the truth does so less
    kSunkenLight,  // the vertex is at or inside the surface of a far part; the truth darkens it more
    kFarParts,     // far parts hide the wrong amount in another way
    kComponents,   // the local components cannot say what the truth has
    kRegression,   // the scores of the components are wrong
    kOutOfRange,   // the same, in a pose that is far from all training poses
    kBorder,       // the local model or the residual jumps where two clusters meet
    kResidual,     // the residual adds the error
    kPacking,      // dropped components and bytes
    kUnknown       // the truth has no local moments, or the model has none
};
inline constexpr Word<PlaceCause> kPlaceCauseWords[] = {{"sunken, too dark", PlaceCause::kSunkenDark},
                                                        {"sunken, too light", PlaceCause::kSunkenLight},
                                                        {"far parts", PlaceCause::kFarParts},
                                                        {"local components", PlaceCause::kComponents},
                                                        {"local regression", PlaceCause::kRegression},
                                                        {"out of range", PlaceCause::kOutOfRange},
                                                        {"cluster border", PlaceCause::kBorder},
                                                        {"residual", PlaceCause::kResidual},
                                                        {"packing", PlaceCause::kPacking},
                                                        {"unknown", PlaceCause::kUnknown}};

// A pose this far out of range counts as one that training frames do not have, about radians.
constexpr double kFarOutOfRange = 0.2;

// One (vertex, frame) pair. NaN: not measured. The steps lead from the truth to the model: e_truth + darkening +
// far_rest + components + regression + residual + packing = e_model.
struct WorstPlace {
    std::string clip, part;  // part: joint of the part that the vertex belongs to
    std::size_t number = 0;  // index of the frame in its clip
    double time = 0;         // seconds
    bool held_out = false;
    std::uint32_t point = 0;  // vertex of the bake
    Vec3 position, normal;    // in the pose
    double e_truth = 0, e_model = 0;
    double out_of_range = 0;  // Evaluator::outOfRange()
    bool border = false;      // a triangle at the vertex has a vertex of another cluster
    double border_jump = 0;   // largest difference of the error over such a triangle edge
    // The following are set for composed assets.
    double e_local_truth, e_local_spanned, e_local_model;  // E of the true local visibility, of its projection on the
                                                           // components, and of the model's local visibility
    double e_far;                                          // E of the visibility past far parts
    double darkening;                                      // being inside of far parts
    double far_rest;                                       // all else that true local x far has wrong
    // Where the model has near parts, `regression` is all that the local model has wrong, `components` is 0, and
    // `e_local_spanned` is not measured.
    double components, regression, residual, packing;
    std::string deepest_part, largest_part;  // the far part that the vertex lies deepest in or nearest to; the far part
                                             // that hides most
    double depth;                            // below the surface of the deepest part, in rest diagonals; < 0 outside
    double darkened;                         // by the deepest part, 0..1
    double hidden;                           // share of the sphere that the largest part hides

    WorstPlace();
};
PlaceCause causeOf(const WorstPlace& place);

// Describes pairs that a check with these arguments has collected. Reads each of their frames once more.
std::vector<WorstPlace> describePlaces(const AssetView& asset, const VisibilityReader& truth,
                                       const CheckReferences& references, std::span<const PlaceError> pairs,
                                       int threads);

// Writes a row for each place below a row of names (RFC 4180). What was not measured is empty.
std::string placesCsv(std::span<const WorstPlace> places);

}  // namespace penumbra
