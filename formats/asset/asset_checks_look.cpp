// Checks what a mesh looks like: materials, lights, and which material each slot has.
#include <bit>
#include <cmath>
#include <cstddef>

#include "asset_generated.h"
#include "formats/asset/asset_checks.h"
#include "formats/asset/asset_field.h"
#include "sh/brdf/brdf_range.h"
#include "sh/brdf/mirror_lobe.h"

namespace penumbra {

namespace {

OperatorsView operatorsOf(const fbs::Operators& stored, const Field& at, const MaterialView& material) {
    OperatorsView operators;
    operators.count = stored.count();
    operators.order = stored.order();
    checkRange(at / "count", operators.count, 1, kMaxOperators);
    checkRange(at / "order", operators.order, 1, kMaxOrder);
    const int even = material.view_order * (material.view_order + 1) / 2, sets = material.channels * operators.count;
    operators.u = floatsOf(stored.u(), at / "u", std::uint64_t(sets * coefficientCount(operators.order)));
    operators.w = floatsOf(stored.w(), at / "w", std::uint64_t(sets * even));
    return operators;
}

// Unfolds the numbers of a compact form here, so that nobody else needs to know of forms.
void setSlices(const fbs::Material& stored, const Field& at, MaterialView& material) {
    const int j = material.slice_order, view = material.view_order;
    if (!stored.slices()) return;  // a live material; checkLive() checks it
    checkRange(at / "slice_form", std::int64_t(stored.slice_form()), 0, std::int64_t(SliceForm::kIsotropic));
    material.slice_form = SliceForm(stored.slice_form());
    material.stored_slices = floatsOf(stored.slices(), at / "slices",
                                      std::uint64_t(material.channels) * entryCount(material.slice_form, j, view));
    material.slices = material.stored_slices;
    if (material.slice_form == SliceForm::kGeneral) return;
    material.unfolded =
        std::make_shared<const std::vector<float>>(expandSlices(material.slice_form, j, view, material.stored_slices));
    material.slices = *material.unfolded;
}

// The file holds lobes as the run time does, so that they are read in place.
static_assert(sizeof(BrdfLobe) == 32 && sizeof(fbs::BrdfLobe) == 32 && offsetof(BrdfLobe, parameters) == 4 &&
              offsetof(BrdfLobe, color) == 20);

std::span<const BrdfLobe> brdfLobesOf(const fbs::Material& stored, const Field& at) {
    if (!stored.lobes()) at.fail("is missing");
    checkRange(at, std::int64_t(stored.lobes()->size()), 1, kMaxBrdfLobes);
    const std::span lobes(reinterpret_cast<const BrdfLobe*>(stored.lobes()->Data()), stored.lobes()->size());
    for (std::size_t i = 0; i < lobes.size(); ++i)
        at[i].require(isValid(lobes[i]), "has an unknown model, or a parameter or a colour out of range");
    return lobes;
}

// Without slices, a lobe about the mirror direction is all that there is.
void checkLive(const fbs::Material& stored, const Field& at, const MaterialView& material) {
    const bool is_lobe = material.lobes.size() == 1 && isMirrorLobe(material.lobes[0].model);
    (at / "slices").require(is_lobe, "is missing, and the lobes are not one lobe about the mirror direction");
    (at / "channels").require(material.channels == 1, "is not 1, as a material without slices has it");
    (at / "operators").require(!stored.operators(), "is given for a material without slices");
    (at / "membrane").require(!material.membrane, "is given for a material without slices");
}

// Checks which lobes the steps change: all have the parameter, by one name and with one value.
void checkChange(const fbs::Material& stored, const Field& at, MaterialView& material) {
    material.step_parameter = stored.step_parameter();
    material.step_lobes = stored.step_lobes();
    const Field lobes = at / "step_lobes";
    lobes.require(material.step_lobes != 0 && material.step_lobes >> material.lobes.size() == 0,
                  "names lobes that do not exist");
    const BrdfLobe& first = material.lobes[std::size_t(std::countr_zero(material.step_lobes))];
    for (std::size_t i = 0; i < material.lobes.size(); ++i) {
        if (!(material.step_lobes >> i & 1)) continue;
        const std::span<const BrdfParameter> known = parametersOf(material.lobes[i].model);
        checkRange(at / "step_parameter", std::int64_t(material.step_parameter), 0, std::int64_t(known.size()) - 1);
        const std::string_view name = parametersOf(first.model)[material.step_parameter].name;
        lobes.require(
            name == known[material.step_parameter].name &&
                material.lobes[i].parameters[material.step_parameter] == first.parameters[material.step_parameter],
            "have no parameter in common");
    }
}

// Steps are of lobes, which the material is. `material` has all else.
void setSteps(const fbs::Material& stored, const Field& at, MaterialView& material) {
    const Field here = at / "steps";
    material.step_error = stored.step_error();
    (at / "step_error").require(std::isfinite(material.step_error) && material.step_error >= 0, "is not 0 or more");
    if (!stored.steps()) {
        here.require(!stored.step_slices() && stored.step_parameter() == 0 && stored.step_lobes() == 1 &&
                         material.step_error == 0,
                     "are missing, but there are numbers of them");
        return;
    }
    here.require(
        !material.slices.empty() && !material.membrane && !stored.operators() && material.lobe_error == 0,
        "are given, but the material is not one lobe or more, all exact, with slices, without operators or a membrane");
    checkChange(stored, at, material);
    const BrdfLobe& lobe = material.lobes[std::size_t(std::countr_zero(material.step_lobes))];
    material.steps = spanOf<double>(stored.steps(), here);
    const std::size_t count = material.steps.size();
    checkRange(here, std::int64_t(count), 2, std::int64_t(kMaxBrdfSteps));
    const auto [name, fallback, least, most] = parametersOf(lobe.model)[material.step_parameter];
    for (std::size_t s = 0; s < count; ++s) {
        here[s].require(material.steps[s] >= least && material.steps[s] <= most, "is out of the parameter's range");
        here[s].require(s == 0 || material.steps[s] > material.steps[s - 1], "is not above the one before");
    }
    const float now = lobe.parameters[material.step_parameter];
    here.require(now >= float(material.steps.front()) && now <= float(material.steps.back()),
                 "do not enclose the parameter of the lobe");
    const int j = material.slice_order, view = material.view_order;
    const std::size_t entries = entryCount(material.slice_form, j, view);
    material.stored_step_slices =
        floatsOf(stored.step_slices(), at / "step_slices", count * std::size_t(material.channels) * entries);
    material.step_slices = material.stored_step_slices;
    if (material.slice_form == SliceForm::kGeneral) return;
    material.unfolded_steps = std::make_shared<const std::vector<float>>(
        expandSlices(material.slice_form, j, view, material.stored_step_slices));
    material.step_slices = *material.unfolded_steps;
}

std::optional<Membrane> membraneOf(const fbs::Material& stored, const Field& at) {
    if (!stored.membrane()) {
        (at / "membrane_open").require(!stored.membrane_open(), "is set for a material without membrane");
        return std::nullopt;
    }
    const auto* values = stored.membrane();
    checkRange(at / "membrane", std::int64_t(values->size()), 6, 6);
    const Membrane membrane{{values->Get(0), values->Get(1), values->Get(2)},
                            {values->Get(3), values->Get(4), values->Get(5)},
                            stored.membrane_open()};
    if (const std::string problem = findProblem(membrane); !problem.empty()) (at / "membrane").fail(problem);
    return membrane;
}

Vec3 emissionOf(const fbs::Material& stored, const Field& at) {
    if (!stored.emission()) return {};
    const auto* values = stored.emission();
    checkRange(at, std::int64_t(values->size()), 3, 3);
    const Vec3 emission{values->Get(0), values->Get(1), values->Get(2)};
    for (int c = 0; c < 3; ++c) at.require(std::isfinite(emission[c]) && emission[c] >= 0, "is not 0 or more");
    return emission;
}

MaterialView materialOf(const fbs::Material& stored, const Field& at) {
    MaterialView material;
    material.name = textOf(stored.name());
    material.slice_order = stored.slice_order();
    material.view_order = stored.view_order();
    material.channels = stored.channels();
    checkRange(at / "slice_order", material.slice_order, 1, kMaxOrder);
    checkRange(at / "view_order", material.view_order, 1, kMaxOrder);
    (at / "channels").require(material.channels == 1 || material.channels == 3, "must be 1 or 3");
    if (!stored.color() || stored.color()->size() != 3) (at / "color").fail("must have 3 elements");
    material.color = {stored.color()->Get(0), stored.color()->Get(1), stored.color()->Get(2)};
    (at / "color").require(std::isfinite(dot(material.color, {1, 1, 1})), "is not finite");
    setSlices(stored, at, material);
    if (stored.operators()) material.operators = operatorsOf(*stored.operators(), at / "operators", material);
    material.lobes = brdfLobesOf(stored, at / "lobes");
    material.lobe_error = stored.lobe_error();
    (at / "lobe_error").require(std::isfinite(material.lobe_error) && material.lobe_error >= 0, "is not 0 or more");
    material.membrane = membraneOf(stored, at);
    if (material.isLive()) checkLive(stored, at, material);
    setSteps(stored, at, material);
    material.emission = emissionOf(stored, at / "emission");
    (at / "emission").require(!material.membrane || material.emission == Vec3{}, "is given for a membrane");
    return material;
}

std::span<const Sun> sunsOf(const fbs::Light& stored, const Field& at) {
    static_assert(sizeof(Sun) == 7 * sizeof(float));
    const auto suns = spanOf<Sun>(stored.suns(), at);
    checkRange(at, std::int64_t(suns.size()), 0, kMaxSuns);
    checkFinite(at, suns);
    for (std::size_t i = 0; i < suns.size(); ++i) {
        checkUnit(at[i], std::span(&suns[i].direction, 1));
        for (int c = 0; c < 3; ++c) at[i].require(suns[i].irradiance[c] >= 0, "has a negative irradiance");
        at[i].require(suns[i].radius >= 0 && suns[i].radius < 1.6f, "has a radius that is not in [0, 1.6)");
    }
    return suns;
}

PictureView pictureOf(const fbs::Light& stored, const Field& at) {
    PictureView picture;
    picture.width = stored.picture_width(), picture.height = picture.width / 2;
    checkRange(at / "picture_width", picture.width, 0, kMaxPictureWidth);
    (at / "picture_width").require(picture.width % 2 == 0, "is odd");
    const Field texels = at / "picture";
    picture.texels = spanOf<std::uint16_t>(stored.picture(), texels);
    checkCount(texels, picture.texels, 3 * std::uint64_t(picture.width) * std::uint64_t(picture.height));
    // Finite halves that are not negative are below infinity as integers. -0 is refused too; no writer makes it.
    for (const std::uint16_t half : picture.texels)
        texels.require(half < 0x7c00, "has a texel that is negative or not finite");
    return picture;
}

LightView lightOf(const fbs::Light& stored, const Field& at) {
    LightView light;
    light.name = textOf(stored.name());
    light.order = stored.order();
    checkRange(at / "order", light.order, 1, kMaxOrder);
    light.sh = floatsOf(stored.sh(), at / "sh", 3 * std::uint64_t(coefficientCount(light.order)));
    if (const fbs::Lobes* lobes = stored.lobes()) {
        const Field here = at / "lobes";
        light.lobes.directions = spanOf<Vec3>(lobes->directions(), here / "directions");
        const std::size_t count = light.lobes.directions.size();
        checkRange(here / "directions", std::int64_t(count), 1, kMaxLobes);
        checkFinite(here / "directions", light.lobes.directions);
        checkUnit(here / "directions", light.lobes.directions);
        light.lobes.coefficients = floatsOf(lobes->coefficients(), here / "coefficients",
                                            3 * std::uint64_t(count) * std::uint64_t(light.order));
    }
    light.suns = sunsOf(stored, at / "suns");
    if (stored.window()) {
        light.window = floatsOf(stored.window(), at / "window", std::uint64_t(light.order));
        for (const float weight : light.window)
            (at / "window").require(weight >= 0 && weight <= 1, "has a factor that is not in [0, 1]");
    }
    light.picture = pictureOf(stored, at);
    return light;
}

}  // namespace

void checkLooks(const AssetView& asset, const Field& file) {
    for (std::size_t m = 0; m < asset.materials.size(); ++m) {
        const MaterialView& material = asset.materials[m];
        const Field at = (file / "materials")[m];
        if (material.membrane && asset.has_mesh)
            (at / "membrane").require(asset.mesh.two_sided, "is given, but the mesh is not two-sided");
    }
}

std::vector<MaterialView> materialsOf(const fbs::Asset& asset, const Field& at) {
    std::vector<MaterialView> materials;
    if (!asset.materials()) return materials;
    checkRange(at, std::int64_t(asset.materials()->size()), 0, std::int64_t(kMaxMaterials));
    std::size_t tables = 0;  // vectors of a file may be shared, so its size does not bound what they unfold to
    for (const fbs::Material* material : *asset.materials()) {
        tables += 1 + (material->steps() ? material->steps()->size() : 0);
        at.require(tables <= kMaxMaterials, "have more than 4096 tables together");
        materials.push_back(materialOf(*material, at[materials.size()]));
    }
    checkUniqueNames(at, materials);
    return materials;
}

std::vector<LightView> lightsOf(const fbs::Asset& asset, const Field& at) {
    std::vector<LightView> lights;
    if (!asset.lights()) return lights;
    for (const fbs::Light* light : *asset.lights()) lights.push_back(lightOf(*light, at[lights.size()]));
    checkUniqueNames(at, lights);
    return lights;
}

std::vector<std::uint16_t> slotMaterialsOf(const fbs::Asset& stored, const Field& at, const AssetView& asset) {
    const std::size_t slots = asset.mesh.slots.size();
    const auto chosen = spanOf<std::uint16_t>(stored.slot_material(), at / "slot_material");
    if (asset.materials.empty() || chosen.empty()) {
        checkCount(at / "slot_material", chosen, 0);
        return std::vector<std::uint16_t>(asset.materials.empty() ? 0 : slots, 0);
    }
    checkCount(at / "slot_material", chosen, slots);
    checkIndices(at / "slot_material", chosen, asset.materials.size());
    return {chosen.begin(), chosen.end()};
}

}  // namespace penumbra
