// The part of penumbra.h that handles materials, light and radiance.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "runtime/capi/capi_handles.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxSlotAssets = 65535, kMaxSlotMaterials = 65535;

ShadingChoice choiceOf(const penumbra_shading_options& options) {
    if (options.reflectance != PENUMBRA_SLICES && options.reflectance != PENUMBRA_OPERATORS)
        throw UsageError("reflectance is not a penumbra_reflectance");
    if (int(options.light_form) < 0 || int(options.light_form) > PENUMBRA_LOBES)
        throw UsageError("light_form is not a penumbra_light_form");
    if (options.caller_light_order < 0 || options.caller_light_order > kMaxOrder)
        throw UsageError("caller_light_order is " + std::to_string(options.caller_light_order) + ", allowed are 0.." +
                         std::to_string(kMaxOrder));
    if (options.caller_light_order > 0 && options.light_form != PENUMBRA_ROTATION)
        throw Unsupported("a light of the caller needs light_form PENUMBRA_ROTATION");
    constexpr LightForm kForms[] = {LightForm::kRotation, LightForm::kFixed, LightForm::kLobes};
    return {options.reflectance == PENUMBRA_SLICES ? Reflectance::kSlices : Reflectance::kOperators,
            kForms[options.light_form]};
}

// Adds an asset. The first one brings the model; the others bring materials and lights.
void addAsset(const penumbra_asset* asset, penumbra_shading& shading) {
    requirePointer(asset, "asset");
    const AssetView& view = asset->data->view;
    const bool first = shading.assets.empty();
    shading.assets.push_back(asset->data);
    if (first) {
        shading.view = view;
        return;
    }
    const auto append = [](auto& list, const auto& more) { list.insert(list.end(), more.begin(), more.end()); };
    append(shading.view.materials, view.materials);
    append(shading.view.lights, view.lights);
}

void addCallerLight(int order, penumbra_shading& shading) {
    if (order == 0) return;
    shading.caller_light.resize(3 * std::size_t(coefficientCount(order)));
    shading.view.lights.push_back({"caller", order, shading.caller_light, {}});
}

// Tells why a material cannot be on.
const char* lackOf(const AssetView& asset, std::size_t material) {
    if (asset.transfer) return " is not lambert, and transfer is diffuse";
    if (asset.materials[material].membrane && !asset.mesh.two_sided)
        return " is a membrane, which needs a two-sided mesh";
    return " has no operators";
}

// Switches on a light and materials that have what the options ask for. Where the asset's choice lacks it, this takes
// the first one that has it.
void chooseUsable(ShadingSet& set, std::size_t materials, std::size_t lights) {
    std::size_t light = 0, material = 0;
    while (light < lights && !set.hasLight(light)) ++light;
    if (light == lights) throw Unsupported("no light has lobes");
    while (material < materials && !set.hasMaterial(material)) ++material;
    if (material == materials)
        throw Unsupported("no material can be on: material 0" + std::string(lackOf(set.asset(), 0)));
    set.setLight(light);
    for (std::size_t slot = 0; slot < set.slotCount(); ++slot)
        if (!set.hasMaterial(set.materialOfSlot()[slot])) set.setMaterial(slot, material);
}

ChangingParameter parameterOf(const penumbra_shading* shading, std::size_t material) {
    requirePointer(shading, "shading");
    requireIndex("material", material, shading->view.materials.size());
    const ShadingSet& set = *shading->set;
    const std::optional<ChangingParameter> parameter = changingParameter(shading->view.materials[material]);
    if (!parameter || !set.hasMaterial(material))
        throw Unsupported("material " + std::to_string(material) + " has no parameter that changes");
    return *parameter;
}

}  // namespace

Mat3 rotationFrom(const float* rotation) {
    requirePointer(rotation, "rotation");
    Mat3 r;
    std::copy_n(rotation, 9, r.m.begin());
    const Mat3 product = r * transposed(r), cofactors = cofactor(r);
    bool fine = true;
    for (int i = 0; i < 9; ++i)  // R R^T = 1 and R equals its cofactors; NaN fails too
        fine = fine && std::abs(product.m[i] - (i % 4 == 0)) < 1e-3f && std::abs(cofactors.m[i] - r.m[i]) < 2e-3f;
    if (!fine) throw UsageError("rotation is not orthonormal with determinant 1");
    return r;
}

}  // namespace penumbra

using namespace penumbra;

penumbra_status penumbra_shading_create(const penumbra_asset* asset, const penumbra_asset* const* more,
                                        size_t more_count, const penumbra_shading_options* options,
                                        penumbra_shading** shading, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        if (more_count > 0) requirePointer(more, "more");
        if (more_count > kMaxSlotAssets) throw Unsupported("there are more than 65535 assets");
        const penumbra_shading_options chosen = options ? *options : penumbra_shading_options{};
        const ShadingChoice choice = choiceOf(chosen);
        auto made = std::make_unique<penumbra_shading>();
        addAsset(asset, *made);
        for (std::size_t i = 0; i < more_count; ++i) addAsset(more[i], *made);
        addCallerLight(chosen.caller_light_order, *made);
        AssetView& view = made->view;
        if (!view.hasCharacter()) throw Unsupported(view.name + ": has no model");
        if (view.materials.empty()) throw Unsupported(view.name + ": there is no material");
        if (view.materials.size() > kMaxSlotMaterials) throw Unsupported("there are more than 65535 materials");
        if (view.lights.empty()) throw Unsupported(view.name + ": there is no light");
        view.slot_material.resize(std::max<std::size_t>(1, view.mesh.slots.size()));
        if (choice != ShadingChoice())
            refuseTransfer<Unsupported>(view, "transfer is diffuse, and takes the light exactly (PENUMBRA_ROTATION)");
        made->set.emplace(view, choice);
        chooseUsable(*made->set, view.materials.size(), view.lights.size());
        if (!view.transfer) made->layout = shadingLayout(*made->set);
        *shading = made.release();
    });
}

void penumbra_shading_destroy(penumbra_shading* shading) { delete shading; }

penumbra_status penumbra_shading_set_simd(penumbra_shading* shading, penumbra_simd simd, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        shading->set->usePath(pathOf(simd, shadePaths()));
    });
}

size_t penumbra_shading_slot_count(const penumbra_shading* shading) { return shading ? shading->set->slotCount() : 0; }

size_t penumbra_shading_material_count(const penumbra_shading* shading) {
    return shading ? shading->view.materials.size() : 0;
}

size_t penumbra_shading_light_count(const penumbra_shading* shading) {
    return shading ? shading->view.lights.size() : 0;
}

size_t penumbra_shading_material_of(const penumbra_shading* shading, size_t slot) {
    return shading && slot < shading->set->slotCount() ? shading->set->materialOfSlot()[slot] : PENUMBRA_NONE;
}

size_t penumbra_shading_light(const penumbra_shading* shading) {
    return shading ? shading->set->light() : PENUMBRA_NONE;
}

penumbra_status penumbra_shading_set_material(penumbra_shading* shading, size_t slot, size_t material,
                                              penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requireIndex("material", material, shading->view.materials.size());
        if (slot != PENUMBRA_ALL_SLOTS) requireIndex("slot", slot, shading->set->slotCount());
        if (!shading->set->hasMaterial(material))
            throw Unsupported("material " + std::to_string(material) + lackOf(shading->view, material));
        if (slot == PENUMBRA_ALL_SLOTS)
            shading->set->setMaterial(material);
        else
            shading->set->setMaterial(slot, material);
    });
}

penumbra_status penumbra_shading_set_light(penumbra_shading* shading, size_t light, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        requireIndex("light", light, shading->view.lights.size());
        if (!shading->set->hasLight(light)) throw Unsupported("light " + std::to_string(light) + " has no lobes");
        shading->set->setLight(light);
    });
}

penumbra_status penumbra_shading_set_material_parameter(penumbra_shading* shading, size_t material, const char* name,
                                                        double value, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(name, "name");
        const ChangingParameter parameter = parameterOf(shading, material);
        if (name != parameter.name)
            throw Unsupported("material " + std::to_string(material) + " has no parameter \"" + name + "\", only \"" +
                              std::string(parameter.name) + "\"");
        try {
            shading->set->setParameter(material, value);
        } catch (const std::invalid_argument& wrong) {
            throw UsageError(wrong.what());
        }
    });
}

penumbra_status penumbra_shading_get_material_parameter(const penumbra_shading* shading, size_t material,
                                                        penumbra_parameter* out, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(out, "out");
        const ChangingParameter parameter = parameterOf(shading, material);
        *out = {parameter.name.data(), double(shading->set->lobesOf(material)[0].parameters[parameter.index]),
                parameter.least, parameter.most};
    });
}

penumbra_status penumbra_shading_set_light_rotation(penumbra_shading* shading, const float rotation[9],
                                                    penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        shading->set->setLightRotation(rotationFrom(rotation));
    });
}

penumbra_status penumbra_shading_shade(const penumbra_shading* shading, const float eye[3],
                                       const penumbra_vertices* vertices, float* radiance, penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        const Vec3 from = pointFrom("eye", eye);
        requireCoefficients(vertices);
        const std::size_t n = shading->view.mesh.positions.size();
        const VertexFrames frames = framesOf(vertices, n, std::size_t(shading->view.model.stride));
        requirePointer(radiance, "radiance");
        if (vertices->bounced) requireBounces(shading->view);
        shading->set->shade(frames, from, vectors(radiance, n));
    });
}

penumbra_status penumbra_shading_set_bounces(penumbra_shading* shading, penumbra_bounces bounces,
                                             penumbra_error* error) {
    return guarded(error, [&] {
        requirePointer(shading, "shading");
        if (int(bounces) < 0 || int(bounces) > PENUMBRA_BOUNCED_LIGHT)
            throw UsageError("bounces is not a penumbra_bounces");
        constexpr Bounces kShown[] = {Bounces::kBoth, Bounces::kDirect, Bounces::kIndirect};
        shading->set->setBounces(kShown[bounces]);
    });
}
