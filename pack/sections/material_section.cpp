#include "pack/sections/material_section.h"

#include <array>
#include <cmath>
#include <span>

#include "formats/common/errors.h"
#include "sh/brdf/slice_form.h"

namespace penumbra {

namespace {

// The channel that has the largest entry, and the factors of the others if all three are that channel times a factor.
struct Channels {
    std::size_t strongest = 0;
    std::array<double, 3> color{1, 1, 1};
    bool proportional = true;
};

Channels channelsOf(const BrdfFile& brdf) {
    const std::vector<double>& slices = brdf.slices;
    std::size_t largest = 0;
    for (std::size_t i = 0; i < slices.size(); ++i)
        if (std::abs(slices[i]) > std::abs(slices[largest])) largest = i;
    const double top = slices.empty() ? 0 : slices[largest];
    Channels channels;
    channels.strongest = largest % 3;
    for (std::size_t c = 0; c < 3 && top != 0; ++c) channels.color[c] = slices[largest / 3 * 3 + c] / top;
    const auto differs = [&](const std::vector<double>& values, double limit) {
        for (std::size_t i = 0; i < values.size(); ++i)
            if (std::abs(values[i] - channels.color[i % 3] * values[i / 3 * 3 + channels.strongest]) > limit)
                return true;
        return false;
    };
    double top_u = 0;
    for (double u : brdf.operators.u) top_u = std::max(top_u, std::abs(u));
    channels.proportional = !differs(slices, 1e-6 * std::abs(top)) && !differs(brdf.operators.u, 1e-6 * top_u) &&
                            (!brdf.steps || !differs(brdf.steps->slices, 1e-6 * std::abs(top)));
    // u holds the colour, and w does not.
    for (std::size_t i = 0; i < brdf.operators.w.size(); ++i)
        channels.proportional &= brdf.operators.w[i] == brdf.operators.w[i / 3 * 3 + channels.strongest];
    return channels;
}

// Reorders [count, 3], a part of a vector, to [channels, count].
std::vector<float> byChannel(std::span<const double> values, const Channels& channels) {
    std::vector<float> numbers;
    for (std::size_t c = 0; c < (channels.proportional ? 1 : 3); ++c)
        for (std::size_t i = 0; i < values.size() / 3; ++i)
            numbers.push_back(float(values[3 * i + (channels.proportional ? channels.strongest : c)]));
    return numbers;
}

// Returns [steps, channels, J^2 E].
std::vector<float> stepsByChannel(const BrdfSteps& steps, const Channels& channels) {
    std::vector<float> all;
    const std::size_t size = steps.slices.size() / steps.values.size();
    for (std::size_t s = 0; s < steps.values.size(); ++s) {
        const std::vector<float> one = byChannel(std::span(steps.slices).subspan(s * size, size), channels);
        all.insert(all.end(), one.begin(), one.end());
    }
    return all;
}

std::vector<fbs::BrdfLobe> storedLobes(const std::vector<BrdfLobe>& lobes) {
    std::vector<fbs::BrdfLobe> stored;
    for (const BrdfLobe& lobe : lobes)
        stored.emplace_back(std::uint8_t(lobe.model), flatbuffers::span<const float, 4>(lobe.parameters.data(), 4),
                            flatbuffers::span<const float, 3>(&lobe.color.x, 3));
    return stored;
}

}  // namespace

void checkMaterial(const BrdfFile& brdf) {
    const BrdfOperators& operators = brdf.operators;
    if (operators.count > 0 && operators.view_index != brdf.even_index)
        throw Unsupported("material \"" + brdf.name + "\": operators from \"" + operators.source +
                          "\" are for comparisons only: their view functions are not even in z");
}

Offset<fbs::Material> writeMaterial(FlatBufferBuilder& builder, const BrdfFile& brdf) {
    checkMaterial(brdf);
    const BrdfOperators& operators = brdf.operators;
    const Channels channels = channelsOf(brdf);
    std::vector<float> color(3, 1.0f);
    if (brdf.isLive())
        color = {brdf.lobes[0].color.x, brdf.lobes[0].color.y, brdf.lobes[0].color.z};
    else if (channels.proportional)
        std::copy(channels.color.begin(), channels.color.end(), color.begin());
    const auto name = builder.CreateString(brdf.name);
    const auto color_vector = builder.CreateVector(color);
    const int j = brdf.slice_order, view = brdf.view_order;
    const std::vector<float> all = byChannel(brdf.slices, channels);
    const std::vector<float> of_steps = brdf.steps ? stepsByChannel(*brdf.steps, channels) : std::vector<float>();
    // The slices of the start are among those of the steps.
    const SliceForm form = brdf.isLive() ? SliceForm::kGeneral : mostCompactForm(j, view, brdf.steps ? of_steps : all);
    Offset<flatbuffers::Vector<float>> slices;
    if (!brdf.isLive()) slices = writeVector<float>(builder, compactSlices(form, j, view, all));
    Offset<fbs::Operators> operator_table;
    if (operators.count > 0) {
        const auto u = writeVector<float>(builder, byChannel(operators.u, channels));
        const auto w = writeVector<float>(builder, byChannel(operators.w, channels));
        operator_table =
            fbs::CreateOperators(builder, std::uint8_t(operators.count), std::uint8_t(operators.order), u, w);
    }
    const std::vector<fbs::BrdfLobe> stored = storedLobes(brdf.lobes);
    builder.ForceVectorAlignment(stored.size(), sizeof(fbs::BrdfLobe), 16);
    const auto lobes = builder.CreateVectorOfStructs(stored);
    Offset<flatbuffers::Vector<float>> membrane;
    if (brdf.membrane) {
        const auto& [rho, tau, open_back] = *brdf.membrane;
        membrane = builder.CreateVector(std::vector<float>{rho.x, rho.y, rho.z, tau.x, tau.y, tau.z});
    }
    Offset<flatbuffers::Vector<float>> emission;
    if (brdf.emission != Vec3{})
        emission = builder.CreateVector(std::vector<float>{brdf.emission.x, brdf.emission.y, brdf.emission.z});
    Offset<flatbuffers::Vector<double>> steps;
    Offset<flatbuffers::Vector<float>> step_slices;
    if (brdf.steps) {
        steps = writeVector<double>(builder, brdf.steps->values);
        step_slices = writeVector<float>(builder, compactSlices(form, j, view, of_steps));
    }
    return fbs::CreateMaterial(builder, name, std::uint8_t(j), std::uint8_t(view), channels.proportional ? 1 : 3,
                               color_vector, fbs::SliceForm(form), slices, lobes, float(brdf.lobe_error),
                               operator_table, membrane, brdf.membrane && brdf.membrane->open_back, steps, step_slices,
                               brdf.steps ? std::uint8_t(brdf.steps->parameter) : std::uint8_t(0),
                               brdf.steps ? float(brdf.steps->error) : 0,
                               brdf.steps ? brdf.steps->lobes : std::uint8_t(1), emission);
}

}  // namespace penumbra
