#include "runtime/shade/shading_set.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "formats/asset/other_sides.h"
#include "runtime/shade/sun_lobes.h"

namespace penumbra {

ShadingSet::ShadingSet(const AssetView& asset, const ShadingChoice& choice)
    : asset_(&asset), choice_(choice), path_(shadePaths().back()) {
    assert(asset.hasCharacter() && !asset.materials.empty() && !asset.lights.empty());
    makeTables();
    ambient_weights_.resize(std::size_t(asset.model.convention.size()));
    ambientWeights(asset.model.convention, ambient_weights_);
    if (asset.model.indirect) bounced_ = makeBouncedLight(asset.model.indirect->axes, lights_[light_].whole());
    material_of_slot_ = asset.slot_material;
    material_of_slot_.resize(std::max<std::size_t>(1, asset.mesh.slots.size()));
    sortVertices();
    findOtherSides();
}

void ShadingSet::makeTables() {
    for (const LightView& light : asset_->lights) orders_.push_back(light.order);
    std::sort(orders_.begin(), orders_.end());
    orders_.erase(std::unique(orders_.begin(), orders_.end()), orders_.end());
    for (const LightView& light : asset_->lights) {
        lights_.emplace_back(light, hasForm(light, choice_.light_form) ? choice_.light_form : LightForm::kRotation);
        const auto order = std::lower_bound(orders_.begin(), orders_.end(), light.order);
        order_of_light_.push_back(std::size_t(order - orders_.begin()));
    }
    for (const MaterialView& material : asset_->materials) {
        std::vector<MaterialTables>& of_orders = tables_.emplace_back();
        std::vector<BrdfLobe>& own = own_lobes_.emplace_back(material.lobes.begin(), material.lobes.end());
        if (material.membrane) own = {BrdfLobe{BrdfModel::kLambert, {}, material.membrane->rho}};
        if (asset_->transfer) continue;  // it reads the lobe alone
        if (!hasReflectance(material, choice_.reflectance)) continue;
        if (material.membrane && !asset_->mesh.two_sided) continue;
        for (const int order : orders_)
            of_orders.emplace_back(asset_->model.convention, order, material, choice_.reflectance);
    }
    if (!asset_->surface) return;
    surface_terms_ = surfaceTermsOf(*asset_->surface);
    for (std::size_t axis = 0; axis < 2 && surface_terms_.slopes > 0; ++axis)
        for (const int order : orders_)
            slopes_[axis].push_back(slopeTables(asset_->model.convention, order, int(axis)));
    if (!asset_->transfer) joint_ = JointTables(*asset_, orders_);
}

// Sorts vertices by slot (counting sort). It is stable, so that a slot's vertices stay in the order of the arrays.
void ShadingSet::sortVertices() {
    const std::span<const std::uint16_t> slot_of_vertex = asset_->mesh.slot_of_vertex;
    const std::size_t vertices = asset_->mesh.positions.size();
    first_of_slot_.assign(slotCount() + 1, 0);
    first_of_slot_.back() = vertices;
    if (slotCount() == 1) return;
    std::vector<std::size_t> next(slotCount() + 1);
    for (const std::uint16_t slot : slot_of_vertex) ++next[slot + 1u];
    for (std::size_t s = 0; s < slotCount(); ++s) next[s + 1] += next[s];
    first_of_slot_ = next;
    order_.resize(vertices);
    for (std::size_t v = 0; v < vertices; ++v) order_[next[slot_of_vertex[v]]++] = std::uint32_t(v);
    if (std::is_sorted(order_.begin(), order_.end())) order_.clear();
}

void ShadingSet::findOtherSides() {
    const MeshView& mesh = asset_->mesh;
    free_sight_ = freeSight(asset_->model.convention);
    if (!mesh.two_sided) return;
    other_side_ = penumbra::otherSides(mesh);
}

bool isLambert(const MaterialView& material) {
    return material.lobes.size() == 1 && material.lobes[0].model == BrdfModel::kLambert && material.lobe_error == 0 &&
           !material.membrane;
}

bool ShadingSet::hasMaterial(std::size_t material) const {
    return asset_->transfer ? isLambert(asset_->materials[material]) : !tables_[material].empty();
}

bool ShadingSet::hasLight(std::size_t light) const { return lights_[light].form() == choice_.light_form; }

void ShadingSet::setParameter(std::size_t material, double value) {
    const std::optional<ChangingParameter> parameter = changingParameter(asset_->materials[material]);
    assert(parameter && hasMaterial(material));
    std::vector<BrdfLobe>& lobes = own_lobes_[material];
    checkParameter(lobes[parameter->lobe].model, parameter->index, value, parameter->least, parameter->most);
    for (std::size_t i = 0; i < lobes.size(); ++i)
        if (parameter->lobes >> i & 1) lobes[i].parameters[parameter->index] = float(value);
    for (MaterialTables& tables : tables_[material])
        if (isLive(material))
            tables.setLobe(lobes.front());
        else
            tables.setStep(value);
    ++material_version_;
}

std::span<const BrdfLobe> ShadingSet::lobesOf(std::size_t material) const { return own_lobes_[material]; }

void ShadingSet::setMaterial(std::size_t slot, std::size_t material) {
    assert(slot < slotCount() && hasMaterial(material));
    material_of_slot_[slot] = std::uint16_t(material);
    ++material_version_;
}

void ShadingSet::setMaterial(std::size_t material) {
    for (std::size_t slot = 0; slot < slotCount(); ++slot) setMaterial(slot, material);
}

void ShadingSet::setLight(std::size_t light) {
    assert(light < lights_.size() && hasLight(light));
    light_ = light;
    lights_[light].setSuns(suns_on_);
    setLightRotation(rotation_);
}

void ShadingSet::setLight(std::size_t light, std::span<const float> sh, double seconds) {
    assert(light < lights_.size());
    lights_[light].setCoefficients(sh, seconds);
    setLight(light);
}

void ShadingSet::replaceLight(std::size_t light, const LightView& by) {
    assert(light < lights_.size());
    lights_[light].setLight(by);
    setLight(light);
}

void ShadingSet::setSuns(bool on) {
    assert(!on || choice_.light_form == LightForm::kRotation);
    suns_on_ = on;
    // The first light of an asset may lack the form. setLight() of one that has it follows then.
    if (hasLight(light_)) setLight(light_);
}

void ShadingSet::factorLive(std::size_t light, int count, double time_constant) {
    assert(light < lights_.size());
    lights_[light].factorLive(count, time_constant);
}

void ShadingSet::setLightRotation(const Mat3& rotation) {
    rotation_ = rotation;
    lights_[light_].setRotation(rotation);
    if (asset_->model.indirect) bounced_ = makeBouncedLight(asset_->model.indirect->axes, lights_[light_].whole());
}

void ShadingSet::shade(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const {
    shadePass(0, vertices, eye, radiance);
}

const MaterialTables* ShadingSet::tablesOf(std::size_t slot, std::size_t pass) const {
    const std::size_t order = order_of_light_[light_];
    if (pass == 0) return &tables_[material_of_slot_[slot]][order];
    if (!showsSurface(slot)) return nullptr;
    const SurfaceMaterials& materials = asset_->surface->slots[slot].materials;
    if (pass < kFirstStepPass) {
        const bool bumpy = asset_->surface->slots[slot].use(TextureRole::kNormal).any();
        return bumpy ? &slopes_[pass - 1][order] : nullptr;
    }
    const std::size_t step = (pass - kFirstStepPass) / 2;
    if (step >= materials.steps) return nullptr;
    const bool is_f0 = (pass - kFirstStepPass) % 2 == 0;
    const std::vector<MaterialTables>& tables = tables_[is_f0 ? materials.f0[step] : materials.f90[step]];
    return tables.empty() ? nullptr : &tables[order];
}

void ShadingSet::shadeTerms(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const {
    if (!surface_on_) return shadePass(0, vertices, eye, terms);
    VertexFrames piece = vertices;
    for (std::size_t slot = 0; slot < slotCount() && piece.begin < vertices.end; ++slot) {
        piece.end = std::min(vertices.end, first_of_slot_[slot + 1]);
        if (piece.end <= piece.begin) continue;
        if (path_.shade_terms && showsSurface(slot) && joint_.has(slot))
            shadeJoint(slot, piece, eye, terms);
        else
            shadePasses(piece, eye, terms);
        piece.begin = piece.end;
    }
}

void ShadingSet::shadeJoint(std::size_t slot, const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const {
    const std::size_t count = terms.size() / this->terms();
    const ShadeTerms joint = joint_.view(slot, order_of_light_[light_], count);
    path_.shade_terms(joint, lights_[light_].view(), inputOf(vertices, eye, terms.first(count)), vertices.begin,
                      vertices.end);
    addEmission(slot, vertices.begin, vertices.end, terms.first(count));
    // Clears the terms that other slots have and this one lacks.
    const auto clear = [&](std::size_t first, std::size_t end) {
        for (std::size_t t = first; t < end; ++t)
            for (std::size_t n = vertices.begin; n < vertices.end; ++n)
                terms[t * count + (order_.empty() ? n : order_[n])] = {};
    };
    const std::size_t first_step = 1 + surface_terms_.slopes;
    if (!joint.has_slopes) clear(1, first_step);
    clear(first_step + 2 * asset_->surface->slots[slot].materials.steps, this->terms());
}

void ShadingSet::shadePasses(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const {
    const std::size_t count = terms.size() / this->terms();
    const auto term = [&](std::size_t t) { return terms.subspan(t * count, count); };
    shadePass(0, vertices, eye, term(0));
    const std::size_t slopes = surface_terms_.slopes;
    for (std::size_t pass = 0; pass < 2 * surface_terms_.steps; ++pass)
        shadePass(kFirstStepPass + pass, vertices, eye, term(1 + slopes + pass));
    if (slopes == 0) return;
    shadePass(1, vertices, eye, term(1));
    shadePass(2, vertices, eye, term(2));
    for (std::size_t at = vertices.begin; at < vertices.end; ++at) {
        const std::size_t v = order_.empty() ? at : order_[at];
        const Vec3 x = term(1)[v], y = term(2)[v], tangent = vertices.tangents[v];
        const Vec3 bitangent = cross(vertices.normals[v], tangent);
        for (std::size_t c = 0; c < 3; ++c) term(1 + c)[v] = tangent * x[int(c)] + bitangent * y[int(c)];
    }
}

ShadeInput ShadingSet::inputOf(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const {
    const ModelView& model = asset_->model;
    assert(vertices.indirect.empty() || vertices.indirect.size() == radiance.size() * kIndirectStride);
    ShadeInput input = shadeInput(vertices, model.stride, model.convention.size(), eye, radiance);
    if (!order_.empty()) input.order = order_.data();
    if (showsBounces() && !vertices.indirect.empty()) {
        input.indirect = vertices.indirect.data();
        input.bounced = bounced_.data();
        input.ambient = ambient_weights_.data();
    }
    assert(vertices.received.empty() || vertices.received.size() == radiance.size());
    if (bounces_ != Bounces::kDirect && !vertices.received.empty()) {
        input.received = vertices.received.data();
        input.ambient = ambient_weights_.data();
    }
    input.direct = bounces_ != Bounces::kIndirect;
    return input;
}

void ShadingSet::shadePass(std::size_t pass, const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const {
    if (asset_->transfer) return shadeTransfer(vertices, radiance);
    const ShadeInput input = inputOf(vertices, eye, radiance);
    const ShadeLight light = lights_[light_].view();
    // The range may cover several slots; each gets a call with its own material.
    std::size_t begin = vertices.begin;
    for (std::size_t slot = 0; slot < slotCount() && begin < vertices.end; ++slot) {
        const std::size_t stop = std::min(vertices.end, first_of_slot_[slot + 1]);
        if (stop <= begin) continue;
        const MaterialTables* const tables = tablesOf(slot, pass);
        if (!tables)
            for (std::size_t n = begin; n < stop; ++n) radiance[order_.empty() ? n : order_[n]] = {};
        else if (pass == 0 && isMembrane(material_of_slot_[slot]))
            shadeMembrane(slot, input, begin, stop);
        else
            path_.shade(tables->view(), light, input, begin, stop);
        if (pass == 0) addEmission(slot, begin, stop, radiance);
        begin = stop;
    }
}

void ShadingSet::shadeSome(std::span<const std::uint32_t> some, const VertexFrames& vertices, Vec3 eye,
                           std::span<Vec3> radiance) const {
    assert(!asset_->transfer);
    ShadeInput input = inputOf(vertices, eye, radiance);
    input.order = some.data();
    const ShadeLight light = lights_[light_].view();
    const std::span<const std::uint16_t> slots = asset_->mesh.slot_of_vertex;
    const auto slotAt = [&](std::size_t n) { return slots.empty() ? std::size_t(0) : slots[some[n]]; };
    for (std::size_t begin = 0, end = 0; begin < some.size(); begin = end) {
        const std::size_t slot = slotAt(begin);
        while (end < some.size() && slotAt(end) == slot) ++end;
        if (isMembrane(material_of_slot_[slot]))
            shadeMembrane(slot, input, begin, end);
        else
            path_.shade(materialView(slot), light, input, begin, end);
        const Vec3 emission = asset_->materials[material_of_slot_[slot]].emission;
        if (emission == Vec3{}) continue;
        for (std::size_t n = begin; n < end; ++n) radiance[some[n]] += emission;
    }
}

void ShadingSet::addEmission(std::size_t slot, std::size_t begin, std::size_t end, std::span<Vec3> radiance) const {
    const Vec3 emission = asset_->materials[material_of_slot_[slot]].emission;
    if (emission == Vec3{}) return;
    for (std::size_t n = begin; n < end; ++n) radiance[order_.empty() ? n : order_[n]] += emission;
}

// L = rho/pi E + tau/pi E of the other side. The table of a membrane is that of a white surface, so that it gives E/pi.
void ShadingSet::shadeMembrane(std::size_t slot, const ShadeInput& input, std::size_t begin, std::size_t end) const {
    constexpr std::size_t kPiece = 64;
    const Membrane& membrane = *asset_->materials[material_of_slot_[slot]].membrane;
    const ShadeMaterial white = materialView(slot);
    const ShadeLight light = lights_[light_].view();
    for (std::size_t first = begin; first < end; first += kPiece) {
        const std::size_t stop = std::min(end, first + kPiece);
        const auto vertex = [&](std::size_t n) { return input.order ? input.order[n] : n; };
        std::array<Vec3, kPiece> through;
        std::array<std::uint32_t, kPiece> sides;
        for (std::size_t n = first; n < stop; ++n) sides[n - first] = other_side_[vertex(n)];
        ShadeInput other = input;
        other.order = sides.data();
        other.packed = through.data();
        other.packed_first = 0;
        if (membrane.open_back) other.coefficients = free_sight_.data(), other.stride = 0;
        path_.shade(white, light, input, first, stop);
        path_.shade(white, light, other, 0, stop - first);
        for (std::size_t n = first; n < stop; ++n) {
            Vec3& radiance = input.radiance[vertex(n)];
            radiance = membrane.rho * radiance + membrane.tau * through[n - first];
        }
    }
}

void ShadingSet::shadeTransfer(const VertexFrames& vertices, std::span<Vec3> radiance) const {
    const auto stride = std::size_t(asset_->model.stride);
    assert(vertices.end <= radiance.size() && vertices.coefficients.size() == radiance.size() * stride);
    const std::span<const Vec3> light = lights_[light_].sh();
    const std::size_t n = std::min(light.size(), asset_->transfer->coefficients());
    for (std::size_t at = vertices.begin; at < vertices.end; ++at) {
        const std::size_t v = order_.empty() ? at : order_[at];
        Vec3 sum;
        for (std::size_t c = 0; c < n; ++c) sum += light[c] * vertices.coefficients[v * stride + c];
        radiance[v] = sum;
    }
    reflect(vertices.begin, vertices.end, radiance);
}

void ShadingSet::reflect(std::size_t begin, std::size_t end, std::span<Vec3> light) const {
    std::size_t slot = 0;
    for (std::size_t at = begin; at < end; ++at) {
        while (at >= first_of_slot_[slot + 1]) ++slot;
        // An asset may give a slot a material that cannot be on; it stays black.
        const MaterialView& material = asset_->materials[material_of_slot_[slot]];
        const Vec3 albedo = isLambert(material) ? material.lobes[0].color : Vec3{};
        Vec3& value = light[order_.empty() ? at : order_[at]];
        for (int c = 0; c < 3; ++c) value[c] *= albedo[c] * float(std::numbers::inv_pi);
        if (material.emission != Vec3{}) value += material.emission;
    }
}

void ShadingSet::addSuns(const VertexFrames& vertices, std::span<const float> visible, Vec3 eye,
                         std::span<Vec3> radiance) const {
    assert(vertices.end <= radiance.size() && visible.size() == suns().size() * radiance.size());
    const std::span<const Vec3> normals = vertices.normals;
    const std::span<const Sun> all = suns();
    std::size_t slot = 0;
    for (std::size_t at = vertices.begin; at < vertices.end; ++at) {
        while (at >= first_of_slot_[slot + 1]) ++slot;
        const std::span<const BrdfLobe> lobes = lobesOf(material_of_slot_[slot]);
        const std::size_t v = order_.empty() ? at : order_[at];
        const std::optional<Membrane>& membrane = asset_->materials[material_of_slot_[slot]].membrane;
        for (std::size_t s = 0; s < all.size(); ++s) {
            // Light through a membrane falls on its other side.
            const std::size_t lit = membrane && dot(normals[v], all[s].direction) < 0 ? other_side_[v] : v;
            if (lit != v) {
                const float share = membrane->open_back ? 1 : visible[s * radiance.size() + lit];
                radiance[v] += all[s].irradiance * membrane->tau *
                               (share * dot(normals[lit], all[s].direction) * std::numbers::inv_pi_v<float>);
                continue;
            }
            const float share = visible[s * radiance.size() + v], cosine = dot(normals[v], all[s].direction);
            if (!(share > 0 && cosine > 0)) continue;
            const LobeSurface surface = lobeSurface(vertices.positions[v], normals[v], vertices.tangents[v], eye);
            radiance[v] += all[s].irradiance * sunLobes(lobes, surface, all[s].direction, cosine) * (share * cosine);
        }
    }
}

}  // namespace penumbra
