#pragma once
// What shading reads of one light, in one of three forms, and its rotation while the program runs.
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "player/runtime/exact_light_lobes.h"
#include "player/runtime/shade_kernel.h"

namespace penumbra {

// How the light gets into every vertex' frame.
enum class LightForm {
    kLobes,     // the asset's fitted zonal lobes, turned by turning their axes (paper 000 section 5.4): as exact as the
                // fit
    kFixed,     // 2 order - 1 zonal lobes on fixed axes that together are the light exactly
    kRotation,  // the exact SH rotation: turns about z and fixed quarter turns about x
};
bool hasForm(const LightView& light, LightForm form);

// The light's lobes in one of the first two forms.
LightLobes lobesOf(const LightView& light, LightForm form);

// R(X(90)), the entries that are not zero: y turns to z.
std::vector<TurnTerm> quarterTurn(int order);

class LightTables {
public:
    // hasForm(light, form)
    LightTables(const LightView& light, LightForm form);

    // The light as `rotation` turns it in the model frame, L'(s) = L(rotation^T s): of the light as it came, not of how
    // it was turned before. Allocates nothing.
    void setRotation(const Mat3& rotation);
    // Another light of at most this order, [n^2, 3], as it comes: not turned until setRotation(). kRotation only.
    // Allocates nothing.
    void setCoefficients(std::span<const float> sh);
    int order() const { return order_; }
    LightForm form() const { return form_; }
    const LightLobes& lobes() const { return lobes_; }   // turned; kLobes and kFixed
    const std::vector<Vec3>& sh() const { return sh_; }  // turned; kRotation
    ShadeLight view() const;

private:
    int order_;
    LightForm form_;
    LightLobes lobes_;
    std::vector<Vec3> sh_, original_;  // of kRotation the coefficients, else `original_` has the axes
    std::vector<TurnTerm> turns_;
    std::vector<float> basis_a_, basis_b_;
};

}  // namespace penumbra
