#pragma once
// Holds the materials and lights of an asset, made ready when it is opened, and tells which of them are on. Every
// change afterwards is a few stores (a turned light: one SH rotation); it allocates nothing and makes no table anew.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "runtime/shade/indirect_light.h"
#include "runtime/shade/joint_tables.h"
#include "runtime/shade/shading.h"
#include "runtime/shade/surface_terms.h"

namespace penumbra {

// Tells whether a material is exactly one Lambert lobe.
bool isLambert(const MaterialView& material);

class ShadingSet {
public:
    // `asset` has a character, materials and lights, and outlives the set. Transfer is diffuse: of an asset of transfer
    // only Lambert materials can be on (isLambert()), and only LightForm::kRotation. At first asset.slot_material and
    // light 0 are on.
    explicit ShadingSet(const AssetView& asset, const ShadingChoice& choice = {});

    const AssetView& asset() const { return *asset_; }
    const ShadingChoice& choice() const { return choice_; }
    // Tells whether a material or light has what `choice` asks for (operators, fitted lobes); otherwise it cannot be
    // on.
    bool hasMaterial(std::size_t material) const;
    bool hasLight(std::size_t light) const;

    std::size_t slotCount() const { return material_of_slot_.size(); }  // 1 for a mesh without slots
    std::span<const std::uint16_t> materialOfSlot() const { return material_of_slot_; }
    std::size_t light() const { return light_; }
    const Mat3& lightRotation() const { return rotation_; }
    const LightTables& lightTables() const { return lights_[light_]; }  // the current light, turned

    // Tells whether the material is a lobe whose parameter may change (sh/brdf/mirror_lobe.h).
    bool isLive(std::size_t material) const { return asset_->materials[material].isLive(); }
    // Tells whether the material's slices are interpolated between steps of its parameter.
    bool hasSteps(std::size_t material) const { return asset_->materials[material].hasSteps(); }
    // Changes the parameter of a live material or of one with steps (changingParameter()), such as the exponent of
    // phong-live, from the next shade() on. Throws std::invalid_argument, with one sentence that names the parameter
    // and its range. Allocates nothing else.
    void setParameter(std::size_t material, double value);
    // Returns the lobes of a material for light from one direction, with the parameter as it is set.
    std::span<const BrdfLobe> lobesOf(std::size_t material) const;
    // Tells whether a material is a membrane, whose two sides are shaded and mixed.
    bool isMembrane(std::size_t material) const { return asset_->materials[material].membrane.has_value(); }
    // [V], the vertex of the other side of a two-sided mesh; empty for another.
    std::span<const std::uint32_t> otherSides() const { return other_side_; }
    // Returns M of a live material for the highest order of the lights (LiveLobe::matrix()).
    std::span<const SparseTerm> liveMatrix(std::size_t material) const {
        return tables_[material].back().live().matrix();
    }

    // Returns A of a channel of a material with slices or operators, with its parameter as it is set.
    std::span<const ViewTerm> viewTermsOf(std::size_t material, std::size_t channel) const {
        return tables_[material].back().viewTermsOf(channel);
    }

    void setMaterial(std::size_t slot, std::size_t material);
    void setMaterial(std::size_t material);  // sets every slot
    void setLight(std::size_t light);        // the light is turned as the last one was
    // Replaces a light by one of at most its order, [n^2, 3], turned as the last one was, and switches it on. Only
    // for LightForm::kRotation.
    void setLight(std::size_t light, std::span<const float> sh, double seconds = 0);
    // Replaces a light by one of at most its order with suns of its own, turned as the last one was, and switches it
    // on. Only for LightForm::kRotation.
    void replaceLight(std::size_t light, const LightView& by);
    // Suns are off at first: the light is shaded as it is. While they are on, shade() gives the light without its suns,
    // and the caller adds visibility times irradiance times BRDF of each of suns(). Only for LightForm::kRotation.
    void setSuns(bool on);
    bool sunsOn() const { return suns_on_; }
    // Finds up to `count` suns, smoothed over time, in every light that setLight() replaces; its `seconds` is the time
    // since the last one. LightTables::factorLive() has the rest.
    void factorLive(std::size_t light, int count, double time_constant = 0.1);
    std::span<const Sun> suns() const { return lights_[light_].suns(); }  // suns of the current light, turned
    // Turns the light by `rotation` in the model frame, L'(s) = L(rotation^T s), from how the asset has it.
    void setLightRotation(const Mat3& rotation);
    // Sets which bounced light the vertices show. It takes the whole light, suns or not.
    void setBounces(Bounces bounces) { bounces_ = bounces; }
    Bounces bounces() const { return bounces_; }
    bool showsBounces() const { return asset_->model.indirect && bounces_ != Bounces::kDirect; }
    std::span<const Vec3, kBouncedLight> bouncedLight() const { return bounced_; }  // for the current light, turned
    // Grows with every change of materials. What was uploaded for an older version is stale.
    std::uint64_t materialVersion() const { return material_version_; }

    // Replaces the fastest path of this processor, which is the default. Tests go through all of shadePaths().
    void usePath(const ShadePath& path) { path_ = path; }
    // Computes the radiance towards `eye` of those vertices that stand at [begin, end) of shadingOrder(). Pieces that
    // cover [0, V) together shade every vertex once. vertices.indirect counts where showsBounces(), and
    // vertices.received unless bounces() is kDirect. Everything else is as in VertexShader::shade().
    void shade(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const;
    // Shades `some` vertices alone, each as shade() does. Those of one slot stand together. An asset of transfer does
    // not take this call.
    void shadeSome(std::span<const std::uint32_t> some, const VertexFrames& vertices, Vec3 eye,
                   std::span<Vec3> radiance) const;
    // The asset has pictures on its mesh, and they are shown where the material of a slot is that of its surface. Then
    // one radiance a vertex is not enough: a fragment joins terms() of them with its pictures
    // (formats/common/surface.h, docs/formulas.md, section 18). Hidden at first, and always of an asset without
    // pictures, and where operators reflect.
    void showSurface() { surface_on_ = asset_->surface && choice_.reflectance == Reflectance::kSlices; }
    void hideSurface() { surface_on_ = false; }
    bool showsSurface() const { return surface_on_; }
    bool showsSurface(std::size_t slot) const {
        return surface_on_ && material_of_slot_[slot] == asset_->surface->slots[slot].materials.diffuse;
    }
    const SurfaceTerms& surfaceTerms() const { return surface_terms_; }
    std::size_t terms() const { return surface_on_ ? surface_terms_.count() : 1; }
    // Computes all terms(), [terms, V]; the first is what shade() computes. Others are 0 where a slot does not show its
    // surface.
    void shadeTerms(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const;
    // Turns light that reached vertices (l . t, of those that shade() would shade) into what an asset of transfer sends
    // to any eye: albedo / pi times it.
    void reflect(std::size_t begin, std::size_t end, std::span<Vec3> light) const;
    // Adds what suns() add to the radiance of these vertices: sum over suns of visible E f(omega_i, omega_o) cos.
    // `visible` is [suns, V], the share of each sun that reaches a vertex past everything, its own body included.
    // Everything else is as in shade(), but the coefficients are not read.
    void addSuns(const VertexFrames& vertices, std::span<const float> visible, Vec3 eye,
                 std::span<Vec3> radiance) const;
    // Returns what the kernel reads for a slot.
    ShadeMaterial materialView(std::size_t slot) const {
        return tables_[material_of_slot_[slot]][order_of_light_[light_]].view();
    }
    // The passes of shadeTerms(), and what the kernel reads for a slot in one of them, if it shows anything then.
    std::size_t passes() const { return surface_on_ ? kFirstStepPass + 2 * surface_terms_.steps : 1; }
    std::optional<ShadeMaterial> materialView(std::size_t slot, std::size_t pass) const {
        const MaterialTables* const tables = tablesOf(slot, pass);
        return tables ? std::optional(tables->view()) : std::nullopt;
    }
    // Returns how many vertices a slot has.
    std::size_t vertexCount(std::size_t slot) const { return first_of_slot_[slot + 1] - first_of_slot_[slot]; }
    // [V], with the vertices of one slot together; empty means the mesh's own order.
    std::span<const std::uint32_t> shadingOrder() const { return order_; }

private:
    const AssetView* asset_;
    ShadingChoice choice_;
    std::vector<int> orders_;                          // orders that lights have, ascending
    std::vector<std::vector<MaterialTables>> tables_;  // [material][orders_]; empty where hasMaterial() is false
    std::vector<std::vector<BrdfLobe>> own_lobes_;  // [material] with changed parameters; of a membrane its white one
    std::vector<LightTables> lights_;               // a light without the form has the exact rotation and is never on
    std::vector<std::size_t> order_of_light_;       // index into orders_
    std::vector<std::uint16_t> material_of_slot_;
    std::vector<std::size_t> first_of_slot_;  // [slots + 1], into the shading order
    std::vector<std::uint32_t> order_;
    std::vector<std::uint32_t> other_side_;
    std::vector<float> free_sight_;
    std::size_t light_ = 0;
    bool suns_on_ = false;
    Bounces bounces_ = Bounces::kBoth;
    std::array<Vec3, kBouncedLight> bounced_{};
    std::vector<float> ambient_weights_;
    Mat3 rotation_;
    std::uint64_t material_version_ = 1;
    ShadePath path_;
    bool surface_on_ = false;
    SurfaceTerms surface_terms_;
    std::array<std::vector<MaterialTables>, 2> slopes_;  // [orders_] each; empty without normal maps
    JointTables joint_;

    void makeTables();
    void shadeTransfer(const VertexFrames& vertices, std::span<Vec3> radiance) const;
    void sortVertices();
    void findOtherSides();
    ShadeInput inputOf(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const;
    // Shades the terms of a slot at once, or one by one.
    void shadeJoint(std::size_t slot, const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const;
    void shadePasses(const VertexFrames& vertices, Vec3 eye, std::span<Vec3> terms) const;
    // Which materials the slots have in a pass: those that are on, a slope along an axis (1, 2), then A and B of each
    // roughness.
    static constexpr std::size_t kFirstStepPass = 3;
    void shadePass(std::size_t pass, const VertexFrames& vertices, Vec3 eye, std::span<Vec3> radiance) const;
    // Returns the tables of a slot in a pass, or null where it shows nothing.
    const MaterialTables* tablesOf(std::size_t slot, std::size_t pass) const;
    // Adds what a slot sends out by itself.
    void addEmission(std::size_t slot, std::size_t begin, std::size_t end, std::span<Vec3> radiance) const;
    void shadeMembrane(std::size_t slot, const ShadeInput& input, std::size_t begin, std::size_t end) const;
};

}  // namespace penumbra
