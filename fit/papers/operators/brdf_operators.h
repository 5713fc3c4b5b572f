#pragma once
// Reflection product operators (Nowrouzezahrai 2009 section 4, docs/formulas.md section 3): f cos_i ~= a sum of k terms
// U^b(wi) W^b(wo) whose sides are both projected on SH. sh/brdf/reflection_operator.h turns u into M^b.
#include <string>

#include "fit/reflectance/shading_error.h"
#include "formats/common/words.h"
#include "sh/brdf/brdf.h"

namespace penumbra {

enum class OperatorSource {
    // The default: k terms of C by an SVD, whitened with the cosine-weighted Gram matrix of the view functions.
    kSlices,
    kTable,  // Nowrouzezahrai 2009, corrected: SVD of the tabulated BRDF in the measures wi and wo cos_o, with u of
             // order 8
    // Nowrouzezahrai 2009 as printed, kept as a reference: SVD of a 16 x 32 latitude-longitude table without weights,
    // with u of order 4 and w zero below the horizon.
    kLiteral,
};
inline constexpr Word<OperatorSource> kOperatorSourceWords[] = {
    {"slices", OperatorSource::kSlices}, {"table", OperatorSource::kTable}, {"literal", OperatorSource::kLiteral}};
constexpr std::string_view nameOf(OperatorSource source) { return wordOf(kOperatorSourceWords, source); }

// Fits `count` terms, 1 <= count <= kMaxOperators. `brdf` holds the slices of `source`. The result has more or fewer
// terms where `count` would cut a pair of equal singular values, and fewer where the BRDF has no more terms.
BrdfOperators fitOperators(const RgbBrdf& source, const BrdfFile& brdf, OperatorSource from, int count, int threads);

// Returns the bytes of M^b and w of all channels in single precision, as the paper stores them: k (n^4 + E) numbers a
// channel.
std::size_t expandedBytes(const BrdfOperators& operators, int light_order, const Convention& convention);

// Adds the shading errors of the operators to brdf.errors: shading_operators (A4) and shading_operators_d5 (D5). The
// light has order 4.
void measureOperators(const ShadingTruth& truth, BrdfFile& brdf);

}  // namespace penumbra
