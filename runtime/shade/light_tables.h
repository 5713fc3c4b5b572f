#pragma once
// Holds what shading reads of one light, in one of three forms, and turns the light while the program runs.
#include <array>
#include <optional>
#include <span>
#include <vector>

#include "formats/asset/asset_file.h"
#include "runtime/shade/exact_light_lobes.h"
#include "runtime/shade/shade_kernel.h"
#include "sh/light/sun_smoothing.h"

namespace penumbra {

// Tells how the light gets into the frame of every vertex.
enum class LightForm {
    kLobes,  // the asset's fitted zonal lobes: their axes turn (Nowrouzezahrai 2009 section 5.4); as exact as the fit
    kFixed,  // 2 order - 1 zonal lobes on fixed axes, which together are the light exactly
    kRotation,  // the exact SH rotation: turns about z and fixed quarter turns about x
};
// Tells whether the light has what the form needs: kLobes needs lobes in the asset.
bool hasForm(const LightView& light, LightForm form);

// Returns the light's lobes in one of the first two forms.
LightLobes lobesOf(const LightView& light, LightForm form);

// Returns the entries of R(X(90)) that are not zero. X(90) turns y to z.
std::vector<TurnTerm> quarterTurn(int order);

class LightTables {
public:
    // The light must have the form: hasForm(light, form).
    LightTables(const LightView& light, LightForm form);

    // Turns the light by `rotation` in the model frame, L'(s) = L(rotation^T s). This always turns the light as it
    // came, not as it was turned before. Allocates nothing.
    void setRotation(const Mat3& rotation);
    // Replaces the light by another of at most its order, [n^2, 3]. It is not turned until setRotation(). It has the
    // suns that factorLive() finds, or none. The filter of the suns goes on by `seconds`. Only for kRotation. Allocates
    // nothing.
    void setCoefficients(std::span<const float> sh, double seconds = 0);

    // The same with the suns that `light` brings: factorLive() finds none in it. Its other forms and its picture are
    // not read.
    void setLight(const LightView& light);

    // Suns are off at first. While they are on, what is shaded is the light without its suns, and suns() has them: the
    // light's own, or those of setCoefficients(). The next setRotation() shows the change. Only kRotation has suns.
    void setSuns(bool on);
    bool sunsOn() const { return suns_on_; }
    // From now on setCoefficients() finds up to `count` suns in each light, smoothed over time (SunSmoothing); 0: no
    // more. This makes tables. Throws std::invalid_argument for a time constant that is negative or not finite.
    void factorLive(int count, double time_constant);
    std::span<const Sun> suns() const { return std::span(turned_suns_).first(suns_on_ ? sun_count_ : 0); }  // turned
    int order() const { return order_; }
    LightForm form() const { return form_; }
    const LightLobes& lobes() const { return lobes_; }   // turned; only for kLobes and kFixed
    const std::vector<Vec3>& sh() const { return sh_; }  // turned; only for kRotation
    ShadeLight view() const;
    // The whole light in bands 0..2, its suns too, turned: what surfaces reflect to one another. Every form has it.
    std::span<const Vec3, kIndirectCoefficients> whole() const { return whole_; }

private:
    int order_;
    LightForm form_;
    LightLobes lobes_;
    std::array<Vec3, kIndirectCoefficients> whole_{}, whole_original_{};
    std::vector<Vec3> sh_, original_;  // original_: coefficients of kRotation, axes of the other forms
    std::vector<TurnTerm> turns_;
    std::vector<float> basis_a_, basis_b_;
    std::vector<float> window_;  // window of the suns' bands, or empty
    std::array<Sun, kMaxSuns> suns_{}, turned_suns_{};
    std::size_t sun_count_ = 0;
    bool suns_on_ = false;
    std::optional<LightFactor> factor_;
    SunSmoothing filter_;

    void findSuns(double seconds);
    void setWhole(std::span<const float> sh);
};

}  // namespace penumbra
