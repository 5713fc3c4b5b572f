#include "runtime/shade/light_tables.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "sh/sh_rotation.h"

namespace penumbra {

namespace {

// Makes the normalised associated Legendre recurrences in z, divided by sin^m, with the Condon-Shortley sign. The
// factor sqrt 2 of real harmonics is in the start value.
void basisRecurrence(std::vector<float>& a, std::vector<float>& b) {
    a.assign(kMaxOrder * kMaxOrder, 0);
    b.assign(kMaxOrder * kMaxOrder, 0);
    double start = std::sqrt(1 / (4 * std::numbers::pi));
    for (int m = 0; m < kMaxOrder; ++m) {
        if (m > 0) start *= -std::sqrt((2 * m + 1) / (2.0 * m));
        a[std::size_t(m * kMaxOrder + m)] = float(m > 0 ? std::numbers::sqrt2 * start : start);
        for (int l = m + 1; l < kMaxOrder; ++l) {
            const double scale = std::sqrt((4.0 * l * l - 1) / (double(l) * l - m * m));
            const double previous = std::sqrt(((l - 1.0) * (l - 1) - m * m) / (4.0 * (l - 1) * (l - 1) - 1));
            a[std::size_t(l * kMaxOrder + m)] = float(scale);
            b[std::size_t(l * kMaxOrder + m)] = float(scale * previous);
        }
    }
}

}  // namespace

bool hasForm(const LightView& light, LightForm form) {
    return form != LightForm::kLobes || !light.lobes.directions.empty();
}

LightLobes lobesOf(const LightView& light, LightForm form) {
    if (form == LightForm::kFixed) return makeLightLobes(light);
    LightLobes lobes;
    lobes.directions.assign(light.lobes.directions.begin(), light.lobes.directions.end());
    const std::span<const float> z = light.lobes.coefficients;
    for (std::size_t at = 0; at + 2 < z.size(); at += 3) {
        const auto band = int(at / 3 % std::size_t(light.order));
        const auto scale = float(std::sqrt(4 * std::numbers::pi / (2 * band + 1)));
        lobes.weights.push_back(scale * Vec3{z[at], z[at + 1], z[at + 2]});
    }
    return lobes;
}

std::vector<TurnTerm> quarterTurn(int order) {
    const ShRotationD rotation = makeShRotation(order, Mat3d{{1, 0, 0, 0, 0, -1, 0, 1, 0}});
    std::vector<TurnTerm> terms;
    const double* block = rotation.blocks.data();
    for (int l = 0; l < order; block += (2 * l + 1) * (2 * l + 1), ++l)
        for (int row = 0; row <= 2 * l; ++row)
            for (int column = 0; column <= 2 * l; ++column)
                if (const double value = block[row * (2 * l + 1) + column]; std::abs(value) > 1e-12)
                    terms.push_back({std::uint16_t(l * l + row), std::uint16_t(l * l + column), float(value)});
    return terms;
}

LightTables::LightTables(const LightView& light, LightForm form) : order_(light.order), form_(form) {
    assert(hasForm(light, form));
    basisRecurrence(basis_a_, basis_b_);
    setWhole(light.sh);
    if (form == LightForm::kRotation) {
        for (std::size_t i = 0; i < light.sh.size(); i += 3)
            original_.push_back({light.sh[i], light.sh[i + 1], light.sh[i + 2]});
        sh_ = original_;
        turns_ = quarterTurn(order_);
        sun_count_ = light.suns.size();
        std::copy(light.suns.begin(), light.suns.end(), suns_.begin());
        turned_suns_ = suns_;
        window_.assign(light.window.begin(), light.window.end());
        window_.reserve(kMaxOrder);
    } else {
        lobes_ = lobesOf(light, form);
        original_ = lobes_.directions;
    }
}

void LightTables::setWhole(std::span<const float> sh) {
    for (std::size_t i = 0; i < whole_.size(); ++i)
        whole_[i] = 3 * i < sh.size() ? Vec3{sh[3 * i], sh[3 * i + 1], sh[3 * i + 2]} : Vec3{};
    whole_original_ = whole_;
}

void LightTables::setRotation(const Mat3& rotation) {
    std::array<float, kIndirectCoefficients> channel, turned;
    const ShRotation turn_whole = makeShRotation(kIndirectOrder, rotation);
    for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < channel.size(); ++i) channel[i] = whole_original_[i][c];
        apply(turn_whole, std::span<const float>(channel), std::span<float>(turned));
        for (std::size_t i = 0; i < channel.size(); ++i) whole_[i][c] = turned[i];
    }
    if (form_ != LightForm::kRotation) {
        for (std::size_t d = 0; d < original_.size(); ++d) lobes_.directions[d] = rotation * original_[d];
        return;
    }
    const ShRotation turn = makeShRotation(order_, rotation);
    std::array<float, coefficientCount(kMaxOrder)> from, to;
    const std::size_t count = original_.size();
    const std::span<const Sun> suns = std::span(suns_).first(suns_on_ ? sun_count_ : 0);
    std::array<float, 3 * coefficientCount(kMaxOrder)> whole;
    for (std::size_t i = 0; i < count; ++i)
        for (int c = 0; c < 3; ++c) whole[3 * i + std::size_t(c)] = original_[i][c];
    subtractSuns(suns, window_, std::span(whole).first(3 * count));
    for (std::size_t s = 0; s < suns.size(); ++s) {
        turned_suns_[s] = suns[s];
        turned_suns_[s].direction = rotation * suns[s].direction;
    }
    for (int c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < count; ++i) from[i] = whole[3 * i + std::size_t(c)];
        apply(turn, std::span<const float>(from).first(count), std::span(to).first(count));
        for (std::size_t i = 0; i < count; ++i) sh_[i][c] = to[i];
    }
}

void LightTables::setCoefficients(std::span<const float> sh, double seconds) {
    assert(form_ == LightForm::kRotation && sh.size() % 3 == 0 && sh.size() <= 3 * original_.size());
    for (std::size_t i = 0; i < original_.size(); ++i)
        original_[i] = 3 * i < sh.size() ? Vec3{sh[3 * i], sh[3 * i + 1], sh[3 * i + 2]} : Vec3{};
    sh_ = original_;
    setWhole(sh);
    window_.clear();
    sun_count_ = 0;
    if (factor_) findSuns(seconds);
}

void LightTables::setLight(const LightView& light) {
    assert(form_ == LightForm::kRotation && light.order <= order_ && light.suns.size() <= kMaxSuns);
    for (std::size_t i = 0; i < original_.size(); ++i)
        original_[i] =
            3 * i < light.sh.size() ? Vec3{light.sh[3 * i], light.sh[3 * i + 1], light.sh[3 * i + 2]} : Vec3{};
    sh_ = original_;
    setWhole(light.sh);
    sun_count_ = light.suns.size();
    std::copy(light.suns.begin(), light.suns.end(), suns_.begin());
    turned_suns_ = suns_;
    window_.assign(light.window.begin(), light.window.end());
    // Bands that the light lacks have nothing of its suns.
    if (window_.empty() && light.order < order_) window_.assign(std::size_t(light.order), 1.0f);
    if (!window_.empty()) window_.resize(std::size_t(order_));
}

void LightTables::setSuns(bool on) {
    assert(!on || form_ == LightForm::kRotation);
    suns_on_ = on;
}

void LightTables::factorLive(int count, double time_constant) {
    assert(form_ == LightForm::kRotation && count >= 0 && count <= kMaxSuns);
    filter_ = SunSmoothing(time_constant);
    factor_.reset();
    if (count > 0) factor_.emplace(order_, count);
}

// Finds the suns of original_. Those without light are left out, and the filter fades what was there.
void LightTables::findSuns(double seconds) {
    std::array<double, 3 * coefficientCount(kMaxOrder)> sh;
    for (std::size_t i = 0; i < original_.size(); ++i)
        for (int c = 0; c < 3; ++c) sh[3 * i + std::size_t(c)] = original_[i][c];
    const FactoredLight found = factor_->factor(std::span(sh).first(3 * original_.size()));
    std::array<SunD, kMaxSuns> suns;
    std::size_t count = 0;
    for (std::size_t i = 0; i < std::size_t(found.count); ++i)
        if (luminance(found.candidates[i].sun.irradiance) > 0) suns[count++] = found.candidates[i].sun;
    for (const SunD& sun : filter_.update(std::span(suns).first(count), std::size_t(factor_->suns()), seconds))
        suns_[sun_count_++] = floatSun(sun);
}

ShadeLight LightTables::view() const {
    ShadeLight view{};
    view.order = order_;
    view.lobes = form_ != LightForm::kRotation;
    view.axes = lobes_.directions.data();
    view.lobe = lobes_.weights.data();
    view.axis_count = lobes_.directions.size();
    view.sh = sh_.data();
    view.turns = turns_.data();
    view.turn_count = turns_.size();
    view.basis_a = basis_a_.data();
    view.basis_b = basis_b_.data();
    return view;
}

}  // namespace penumbra
