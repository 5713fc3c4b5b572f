#pragma once
// Holds what the shading kernel reads of a material that is a lobe about the mirror direction (sh/brdf/mirror_lobe.h).
// Only the values of M depend on the lobe; all else is constant. So the lobe may change in every frame.
#include <vector>

#include "runtime/shade/shade_kernel.h"
#include "sh/brdf/brdf_lobe.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/visibility_convention.h"

namespace penumbra {

// Numbers d of a convention as moments b over the hemisphere, the numbers of convention B: b_i = offset_i + sum of
// value * d_from over the terms with to = i. For D the terms are G_ij = integral over the hemisphere of y_i y_j, and
// one band more than d has pays; a second one does not (docs/accuracy.md). A and B have their own order.
struct MomentForm {
    int order = 0;
    std::vector<SparseTerm> terms;  // by (to, from); from is a position among the numbers
    std::vector<float> offset;      // [order^2]
    std::vector<float> sky;         // [order] sqrt(4 pi) b_l0 of a vertex from which nothing is hidden
};
MomentForm momentForm(const Convention& convention);

class LiveLobe {
public:
    // Needs isMirrorLobe(lobe.model).
    LiveLobe(const Convention& convention, int light_order, const BrdfLobe& lobe);

    // Makes M of another lobe. Allocates nothing.
    void set(const BrdfLobe& lobe);
    // M without the colour, by (i, j). A smaller light order has the first of these entries.
    std::span<const SparseTerm> matrix() const { return matrix_; }
    ShadeLive view() const;

private:
    MomentForm moment_form_;
    std::vector<SparseTerm> turn_, turn_back_, matrix_;
    MirrorLobeSum sum_;
    std::vector<double> moments_, values_;
    std::vector<float> albedo_;
};

}  // namespace penumbra
