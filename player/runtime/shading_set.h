#pragma once
// The materials and lights of an asset, made ready when it is opened, and which of them are on: every change afterwards
// is a few stores (a turned light: one SH rotation), allocates nothing and makes no table anew.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "player/runtime/shading.h"

namespace penumbra {

class ShadingSet {
public:
    // `asset` has a model, materials and lights, and outlives the set. What is on at first: asset.slot_material and
    // light 0.
    explicit ShadingSet(const AssetView& asset, const ShadingChoice& choice = {});

    const AssetView& asset() const { return *asset_; }
    const ShadingChoice& choice() const { return choice_; }
    // A material or light without what `choice` asks for (operators, fitted lobes) cannot be on.
    bool hasMaterial(std::size_t material) const;
    bool hasLight(std::size_t light) const;

    std::size_t slotCount() const { return material_of_slot_.size(); }  // 1 for a mesh without slots
    std::span<const std::uint16_t> materialOfSlot() const { return material_of_slot_; }
    std::size_t light() const { return light_; }
    const Mat3& lightRotation() const { return rotation_; }
    const LightTables& lightTables() const { return lights_[light_]; }  // of the light that is on, turned

    void setMaterial(std::size_t slot, std::size_t material);
    void setMaterial(std::size_t material);  // of every slot
    void setLight(std::size_t light);        // it is turned as the last one was
    // Replaces a light by one of at most its order, [n^2, 3], turned as the last one was, and switches it on;
    // LightForm::kRotation only.
    void setLight(std::size_t light, std::span<const float> sh);
    // The light as `rotation` turns it in the model frame, L'(s) = L(rotation^T s); of the light as the asset has it.
    void setLightRotation(const Mat3& rotation);
    // Grow with every change of materials or of light: what was uploaded for an older one is stale.
    std::uint64_t materialVersion() const { return material_version_; }
    std::uint64_t lightVersion() const { return light_version_; }

    // The fastest path of this processor unless this is called: tests go through all of shadePaths().
    void usePath(const ShadePath& path) { path_ = path; }
    // Radiance towards `eye` of V (end - begin) / V of the vertices: those at [begin, end) of shadingOrder(), so that
    // pieces that cover [0, V) shade every vertex once. Everything else as VertexShader::shade().
    void shade(std::size_t begin, std::size_t end, std::span<const Vec3> positions, std::span<const Vec3> normals,
               std::span<const Vec3> tangents, std::span<const float> numbers, Vec3 eye,
               std::span<Vec3> radiance) const;
    // What the kernel reads for a slot, and how many vertices that has.
    ShadeMaterial materialView(std::size_t slot) const {
        return tables_[material_of_slot_[slot]][order_of_light_[light_]].view();
    }
    std::size_t vertexCount(std::size_t slot) const { return first_of_slot_[slot + 1] - first_of_slot_[slot]; }
    // [V], vertices of one slot together; empty for the mesh's own order.
    std::span<const std::uint32_t> shadingOrder() const { return order_; }

private:
    const AssetView* asset_;
    ShadingChoice choice_;
    std::vector<int> orders_;                          // that lights have, ascending
    std::vector<std::vector<MaterialTables>> tables_;  // [material][orders_]; empty where hasMaterial() is false
    std::vector<LightTables> lights_;                  // of a light without the form: the exact rotation, never on
    std::vector<std::size_t> order_of_light_;          // index into orders_
    std::vector<std::uint16_t> material_of_slot_;
    std::vector<std::size_t> first_of_slot_;  // [slots + 1], into the shading order
    std::vector<std::uint32_t> order_;
    std::size_t light_ = 0;
    Mat3 rotation_;
    std::uint64_t material_version_ = 1, light_version_ = 1;
    ShadePath path_;

    void makeTables();
    void sortVertices();
};

}  // namespace penumbra
