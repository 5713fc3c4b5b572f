#pragma once
// Reflection product operators of paper 000 section 4 and docs/formulas.md section 3: f cos_i ~= sum of k terms U^b(wi)
// W^b(wo), each side projected on SH. sh/reflection_operator.h turns u into M^b.
#include <string>

#include "fit/reflectance/shading_error.h"
#include "formats/stage/brdf_file.h"
#include "sh/brdf.h"

namespace penumbra {

enum class OperatorSource {
    kSlices,   // k terms of C, by the SVD whitened with the cosine-weighted Gram of the view functions: the default
    kTable,    // paper 000, corrected: SVD of the tabulated BRDF in the measures wi and wo cos_o; u of order 8
    kLiteral,  // paper 000 as printed, kept as reference: unweighted SVD of a 16 x 32 latitude-longitude table, u of
               // order 4, w zero below the horizon
};
OperatorSource parseOperatorSource(const std::string& name);  // UsageError
const char* nameOf(OperatorSource source);

// `brdf` holds the slices of `source`; count 1..kMaxOperators. There are more or fewer where `count` would cut a pair
// of equal singular values, and fewer where the BRDF has no more terms.
BrdfOperators fitOperators(const RgbBrdf& source, const BrdfFile& brdf, OperatorSource from, int count, int threads);

// Bytes of M^b and w of all channels in single precision, as the paper stores them: k (n^4 + E) a channel.
std::size_t expandedBytes(const BrdfOperators& operators, int light_order, const Convention& convention);

// Adds to brdf.errors what is measured on the reference scenes: shading_d5, shading_a4 (light of order 4, the slices as
// they are), and shading_operators, shading_operators_d5 where there are any (A4, D5).
void measureShading(const RgbBrdf& source, BrdfFile& brdf, int threads);

}  // namespace penumbra
