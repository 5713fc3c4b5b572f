#include "runtime/shade/shading_layout.h"

#include <algorithm>
#include <cassert>
#include <tuple>

namespace penumbra {

std::size_t ShadingLayout::entryCount() const {
    return views.size() + (choice.reflectance == Reflectance::kOperators ? products.size() : 0);
}

std::size_t ShadingLayout::materialTexels() const { return emissionTexel() + (emission ? 1 : 0) + (membranes ? 2 : 0); }

std::size_t ShadingLayout::directTexels() const {
    const auto order = std::size_t(light_order), lobes = std::size_t(lobe_count);
    return 1 + (choice.light_form == LightForm::kRotation ? order * order : lobes + lobes * order);
}

namespace {

auto keyOf(const ProductEntry& e) { return std::tuple(e.i, e.j, e.k); }

void addViews(const MaterialView& material, ShadingLayout& layout) {
    for (const ViewTerm& term : viewTerms(material, layout.choice.reflectance, 0))
        layout.views.push_back({term.k, term.e});
    std::sort(layout.views.begin(), layout.views.end());
    layout.views.erase(std::unique(layout.views.begin(), layout.views.end()), layout.views.end());
}

// Tells which k any material has views of. Entries of another k never count.
std::vector<bool> usedOf(const ShadingLayout& layout) {
    std::vector<bool> used(std::size_t(coefficientCount(kMaxOrder)));
    for (const ShadingLayout::View& view : layout.views) used[view.k] = true;
    return used;
}

// Adds the entries of one material's operators that the layout does not have yet.
void addOperatorProducts(const MaterialView& material, ShadingLayout& layout) {
    const std::vector<ProductEntry> more =
        operatorProduct(layout.convention, layout.light_order, material, 0, usedOf(layout));
    std::vector<ProductEntry> merged;
    std::set_union(layout.products.begin(), layout.products.end(), more.begin(), more.end(), std::back_inserter(merged),
                   [](const ProductEntry& a, const ProductEntry& b) { return keyOf(a) < keyOf(b); });
    layout.products = std::move(merged);
}

// Calls body(axis, material) for both slopes.
template <class Body>
void forSlopes(const Convention& convention, const Body& body) {
    for (std::size_t axis = 0; axis < kSlopeAxes; ++axis) {
        const std::vector<float> slices = slopeSlices(convention, int(axis));
        body(axis, slopeMaterial(convention, slices));
    }
}

void addSlopes(const ShadingSet& set, ShadingLayout& layout, int& slice_order) {
    layout.slopes = set.surfaceTerms().slopes > 0;
    layout.term_passes = (layout.slopes ? kSlopeAxes : 0) + 2 * set.surfaceTerms().steps;
    if (!layout.slopes) return;
    forSlopes(layout.convention, [&](std::size_t, const MaterialView& slope) { addViews(slope, layout); });
    slice_order = std::max(slice_order, layout.convention.order);
}

void addLights(const ShadingSet& set, ShadingLayout& layout) {
    const std::vector<LightView>& lights = set.asset().lights;
    for (std::size_t l = 0; l < lights.size(); ++l) {
        if (!set.hasLight(l)) continue;
        layout.light_order = std::max(layout.light_order, lights[l].order);
        const auto lobes = int(lights[l].lobes.directions.size());
        if (layout.choice.light_form == LightForm::kLobes) layout.lobe_count = std::max(layout.lobe_count, lobes);
    }
    if (layout.choice.light_form == LightForm::kFixed) layout.lobe_count = 2 * layout.light_order - 1;
}

}  // namespace

ShadingLayout shadingLayout(const ShadingSet& set) {
    const AssetView& asset = set.asset();
    ShadingLayout layout;
    layout.convention = asset.model.convention;
    layout.choice = set.choice();
    layout.bounces = asset.model.indirect.has_value();
    addLights(set, layout);
    int slice_order = 1;
    if (set.showsSurface()) addSlopes(set, layout, slice_order);
    for (std::size_t m = 0; m < asset.materials.size(); ++m) {
        if (!set.hasMaterial(m)) continue;
        const MaterialView& material = asset.materials[m];
        layout.live_count += material.isLive();
        layout.stepped_count += material.hasSteps();
        layout.membranes |= material.membrane.has_value();
        layout.emission |= material.emission != Vec3{};
        if (material.isLive()) continue;
        layout.channels = std::max(layout.channels, material.channels);
        layout.view_order = std::max(layout.view_order, material.view_order);
        slice_order = std::max(slice_order, material.slice_order);
        addViews(material, layout);
    }
    if (layout.live_count > 0)
        layout.live_entries = MirrorLobeSum(layout.light_order, momentForm(layout.convention).order).entries().size();
    if (layout.choice.reflectance == Reflectance::kSlices)
        layout.products = sliceProduct(layout.convention, layout.light_order, slice_order, usedOf(layout));
    else
        for (std::size_t m = 0; m < asset.materials.size(); ++m)
            if (set.hasMaterial(m) && !set.isLive(m)) addOperatorProducts(asset.materials[m], layout);
    return layout;
}

namespace {

std::size_t indexOf(const ShadingLayout& layout, const ViewTerm& term) {
    const ShadingLayout::View view{term.k, term.e};
    return std::size_t(std::lower_bound(layout.views.begin(), layout.views.end(), view) - layout.views.begin());
}

// Returns the material's entries of one channel, in the layout's order; what the material lacks stays 0.
std::vector<float> entriesOf(const ShadingLayout& layout, const MaterialView& material, int channel) {
    std::vector<float> values(layout.entryCount());
    for (const ViewTerm& term : viewTerms(material, layout.choice.reflectance, channel))
        values[indexOf(layout, term)] = term.value;
    if (layout.choice.reflectance == Reflectance::kSlices) return values;
    for (const ProductEntry& e :
         operatorProduct(layout.convention, layout.light_order, material, channel, usedOf(layout))) {
        const auto at =
            std::lower_bound(layout.products.begin(), layout.products.end(), e,
                             [](const ProductEntry& a, const ProductEntry& b) { return keyOf(a) < keyOf(b); });
        values[layout.views.size() + std::size_t(at - layout.products.begin())] = e.value;
    }
    return values;
}

void writeEntries(const ShadingLayout& layout, const MaterialView& material, std::span<float> out) {
    for (int c = 0; c < layout.channels; ++c) {
        const std::vector<float> values = entriesOf(layout, material, std::min(c, material.channels - 1));
        for (std::size_t i = 0; i < values.size(); ++i)
            out[layout.channels == 3 ? 4 * i + std::size_t(c) : i] = values[i];
    }
}

}  // namespace

std::vector<float> materialData(const ShadingLayout& layout, const ShadingSet& set) {
    const std::vector<MaterialView>& materials = set.asset().materials;
    const std::size_t size = 4 * layout.materialTexels();
    std::vector<float> data((materials.size() + (layout.slopes ? kSlopeAxes : 0)) * size);
    float live = 0, stepped = 0;
    for (std::size_t m = 0; m < materials.size(); ++m) {
        if (!set.hasMaterial(m)) continue;
        const MaterialView& material = materials[m];
        const std::span<float> out = std::span(data).subspan(m * size, size);
        for (int c = 0; c < 3; ++c) out[std::size_t(c)] = material.color[c];
        for (int c = 0; layout.emission && c < 3; ++c)
            out[4 * layout.emissionTexel() + std::size_t(c)] = material.emission[c];
        if (material.membrane) {
            const auto& [rho, tau, open_back] = *material.membrane;
            for (std::size_t c = 0; c < 3; ++c) out[size - 8 + c] = rho[int(c)], out[size - 4 + c] = tau[int(c)];
            out[size - 5] = open_back ? 2 : 1;
        }
        if (material.isLive()) {
            out[3] = ++live;
            continue;
        }
        if (material.hasSteps()) {
            out[3] = -++stepped;
            continue;
        }
        writeEntries(layout, material, out.subspan(4));
    }
    if (layout.slopes)
        forSlopes(layout.convention, [&](std::size_t axis, const MaterialView& slope) {
            const std::span<float> out = std::span(data).subspan((materials.size() + axis) * size, size);
            std::fill_n(out.begin(), 3, 1.0f);
            writeEntries(layout, slope, out.subspan(4));
        });
    return data;
}

void writeTermRows(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out) {
    assert(out.size() == set.slotCount() * (1 + layout.term_passes));
    std::fill(out.begin(), out.end(), -1.0f);
    const std::size_t slopes = set.asset().materials.size();
    const auto row = [&](std::size_t material) { return set.hasMaterial(material) ? float(material) : -1.0f; };
    float* at = out.data();
    for (std::size_t slot = 0; slot < set.slotCount(); ++slot, at += 1 + layout.term_passes) {
        at[0] = set.showsSurface(slot) ? 1.0f : 0.0f;
        if (!set.showsSurface(slot)) continue;
        const SlotSurface& look = set.asset().surface->slots[slot];
        float* next = at + 1;
        for (std::size_t axis = 0; layout.slopes && axis < kSlopeAxes; ++axis)
            *next++ = look.use(TextureRole::kNormal).any() ? float(slopes + axis) : -1.0f;
        for (std::size_t step = 0; step < look.materials.steps; ++step) {
            *next++ = row(look.materials.f0[step]);
            *next++ = row(look.materials.f90[step]);
        }
    }
}

namespace {

void writeLight(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out) {
    const LightTables& light = set.lightTables();
    assert(light.form() == layout.choice.light_form);
    const auto put = [&](std::size_t texel, Vec3 v) {
        for (int c = 0; c < 3; ++c) out[4 * texel + std::size_t(c)] = v[c];
    };
    if (layout.bounces) {
        const std::size_t first = layout.directTexels();
        for (std::size_t i = 0; set.showsBounces() && i < kBouncedLight; ++i) put(first + i, set.bouncedLight()[i]);
        out[4 * (first + kBouncedLight)] = set.bounces() == Bounces::kIndirect ? 1.0f : 0.0f;
    }
    if (light.form() == LightForm::kRotation) {
        for (std::size_t i = 0; i < light.sh().size(); ++i) put(1 + i, light.sh()[i]);
        return;
    }
    const LightLobes& lobes = light.lobes();
    out[0] = float(lobes.directions.size());
    const auto order = std::size_t(light.order()), padded = std::size_t(layout.light_order);
    const std::size_t weights = 1 + std::size_t(layout.lobe_count);
    for (std::size_t d = 0; d < lobes.directions.size(); ++d) {
        put(1 + d, lobes.directions[d]);
        for (std::size_t l = 0; l < order; ++l) put(weights + d * padded + l, lobes.weights[d * order + l]);
    }
}

// Writes the entries of materials with steps, as their parameters are set: [stepped_count, entryTexels(), 4].
void writeSteps(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out) {
    float* at = out.data();
    for (std::size_t m = 0; m < set.asset().materials.size(); ++m) {
        if (!set.hasSteps(m) || !set.hasMaterial(m)) continue;
        const int channels = set.asset().materials[m].channels;
        for (int c = 0; c < layout.channels; ++c)
            for (const ViewTerm& term : set.viewTermsOf(m, std::size_t(std::min(c, channels - 1)))) {
                const std::size_t i = indexOf(layout, term);
                at[layout.channels == 3 ? 4 * i + std::size_t(c) : i] = term.value;
            }
        at += 4 * layout.entryTexels();
    }
}

}  // namespace

void writeLightData(const ShadingLayout& layout, const ShadingSet& set, std::span<float> out) {
    assert(out.size() == 4 * layout.lightTexels());
    std::fill(out.begin(), out.end(), 0.0f);
    writeLight(layout, set, out.first(4 * layout.firstLiveTexel()));
    float* at = out.data() + 4 * layout.firstLiveTexel();
    for (std::size_t m = 0; m < set.asset().materials.size(); ++m) {
        if (!set.isLive(m) || !set.hasMaterial(m)) continue;
        const std::span<const SparseTerm> matrix = set.liveMatrix(m).first(layout.live_entries);
        for (std::size_t e = 0; e < matrix.size(); ++e) at[e] = matrix[e].value;
        at += 4 * layout.liveTexels();
    }
    writeSteps(layout, set, out.subspan(4 * layout.firstSteppedTexel()));
}

}  // namespace penumbra
