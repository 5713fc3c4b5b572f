#pragma once
// The shadow maps of the window's suns, and what suns need of each mesh.
#include <optional>

#include "player/draw/sunlight.h"
#include "player/view/view_scene.h"

namespace penumbra {

class ViewSunlight {
public:
    // `scene` outlives this object.
    explicit ViewSunlight(const Scene& scene);
    ViewSunlight(const ViewSunlight&) = delete;  // the sunlight points to the table

    // Draws the maps anew where a pose, a place, the light or its turn has changed, and takes the lobes that materials
    // have now. Everyone in the scene casts.
    // updateScene() must have been called. Leaves the window's framebuffer bound.
    void shine(const ViewState& state);
    const Sunlight& sunlight() const { return sunlight_; }
    // Returns what suns need of a character, and takes mirrors out of `values`, what its vertices show to `eye` (in its
    // model frame). The spans are valid until the next call for the character.
    SunlitSurface surfaceOf(std::size_t character, Vec3 eye, std::span<Vec3> values);
    // The same for the points of a ground with heights; `eye` is in the scene.
    SunlitSurface fieldSurface(Vec3 eye, std::span<Vec3> values);
    // Returns the lobes of a character's slots, for ModelPainter.
    std::span<const SlotLobes> slotLobes(std::size_t character) const { return casters_[character].slot_lobes; }
    // Returns the lobes of ground whose colour is multiplied by one of kTileShades; a ground with heights has no tiles.
    LobeRange groundLobes(float shade) const;
    std::span<const BrdfLobe> lobes() const { return table_.lobes(); }  // lobes of the whole scene
    SlotLobes fieldSlotLobes() const { return table_.slotLobes(groundLobes(1)); }
    BrdfModels groundModels() const { return table_.models(ground_); }

private:
    struct Caster {
        std::vector<Vec3> positions;  // in the scene
        std::uint64_t material_version = 0;
        std::vector<LobeRange> lobes;       // one for each vertex
        std::vector<SlotLobes> slot_lobes;  // one for each slot
        std::vector<float> sight;           // sight of its mirrors
    };
    const Scene* scene_;
    LobeTable table_;
    Sunlight sunlight_;
    std::vector<Caster> casters_;
    std::vector<Vec3> field_points_;  // points of a ground with heights, which casts
    std::vector<std::uint32_t> field_triangles_;
    std::vector<LobeRange> field_lobes_;
    std::vector<float> field_sight_;
    std::vector<LobeRange> ground_;  // one for each of kTileShades
    Cached<SunsKey> shone_;          // key of the drawn maps
    Cached<SunsKey> placed_;         // where casters_ and field_points_ stand, whatever the light
    Cached<LightKey> reflected_;     // the light that mirrors reflect

    void draw(const ViewState& state, const SunsKey& key);
    void addGround();
    void updateLobes();
    void placeCasters();
};

}  // namespace penumbra
