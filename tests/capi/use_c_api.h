#pragma once
#include "tests/capi/packed_asset.h"

namespace penumbra::capi_test {

// Does what an engine does with bytes that somebody sent: everything that the C interface offers, once in every form.
// Returns the status of opening them. It serves tests on hostile bytes.
inline penumbra_status useBytes(const void* bytes, std::size_t size, penumbra_error* error) {
    penumbra_asset* opened = nullptr;
    const penumbra_status status = penumbra_asset_open_memory(bytes, size, PENUMBRA_COPY, &opened, error);
    if (status != PENUMBRA_OK) return status;
    const Asset asset(opened);
    const penumbra_asset_info info = infoOf(asset);
    for (std::size_t j = 0; j < info.joint_count; ++j)
        penumbra_asset_find_joint(asset.get(), penumbra_asset_joint_name(asset.get(), j));
    for (std::size_t clip = 0; clip < info.clip_count; ++clip) penumbra_asset_frame_at(asset.get(), clip, 0.1);
    const Character character = capi_test::character(asset);
    if (!character) return status;
    Frame frame(info);
    const std::size_t frames = std::min<std::size_t>(info.frame_count, 2);
    for (std::size_t f = 0; f < frames; ++f) penumbra_character_set_frame(character.get(), f, nullptr);
    const std::vector<float> rotations(3 * info.joint_count, 0.1f);
    penumbra_character_set_rotations(character.get(), nullptr, rotations.data(), rotations.size(), nullptr);
    for (std::size_t i = 0; i < info.input_count; ++i)
        penumbra_asset_find_input(asset.get(), penumbra_asset_input_name(asset.get(), i));
    const std::vector<float> inputs(info.input_count, 0.5f);
    if (info.deforming)
        for (const std::size_t count : {info.source_vertex_count, info.vertex_count}) {
            const std::vector<float> positions(3 * count, 0.2f);
            const auto order = penumbra_vertex_order(count == info.vertex_count);
            penumbra_character_set_positions(character.get(), order, positions.data(), count, inputs.data(),
                                             inputs.size(), nullptr);
        }
    if (penumbra_asset_bounces(asset.get())) frame.bounced.resize(PENUMBRA_BOUNCED_STRIDE * info.vertex_count);
    frame.evaluate(character.get(), info, 2);
    const penumbra_vertices vertices = frame.vertices();
    std::vector<float> transfer(9 * info.vertex_count);
    penumbra_character_transfer(character.get(), 3, &vertices, transfer.data(), nullptr);
    std::vector<float> spheres(4 * penumbra_asset_sphere_count(asset.get()) + 1);
    penumbra_character_get_spheres(character.get(), nullptr, spheres.data(), nullptr);
    const penumbra_asset* casters[] = {asset.get()};
    penumbra_scene* made = nullptr;
    if (penumbra_scene_create(casters, 1, &made, nullptr) == PENUMBRA_OK) {
        const Scene scene(made);
        const float place[12] = {1, 0, 0, 0.5f, 0, 1, 0, 0, 0, 0, 1, 0}, up[3] = {0, 1, 0};
        penumbra_scene_set_caster(scene.get(), 0, character.get(), place, nullptr);
        const penumbra_points point{place, up, 1};
        float e = 0, all[25];
        penumbra_scene_ambient(scene.get(), PENUMBRA_NONE, &point, &e, nullptr);
        penumbra_scene_transfer(scene.get(), PENUMBRA_NONE, &point, all, nullptr);
        const penumbra_vertices some = frame.vertices(0, std::min<std::size_t>(info.vertex_count, 64));
        penumbra_scene_cast(scene.get(), PENUMBRA_NONE, character.get(), nullptr, &some, nullptr);
    }
    for (const penumbra_shading_options& options : {penumbra_shading_options{PENUMBRA_SLICES, PENUMBRA_ROTATION, 3},
                                                    {PENUMBRA_SLICES, PENUMBRA_FIXED_LOBES, 0},
                                                    {PENUMBRA_OPERATORS, PENUMBRA_LOBES, 0}}) {
        const Shading shading = capi_test::shading(asset, options);
        for (std::size_t m = 0; m < penumbra_shading_material_count(shading.get()); ++m)
            for (std::size_t l = 0; l < penumbra_shading_light_count(shading.get()); ++l) {
                penumbra_shading_set_material(shading.get(), PENUMBRA_ALL_SLOTS, m, nullptr);
                penumbra_shading_set_light(shading.get(), l, nullptr);
                frame.shade(shading.get(), 0, info.vertex_count);
            }
    }
    return status;
}

}  // namespace penumbra::capi_test
