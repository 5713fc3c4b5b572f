#pragma once
// A small asset as bytes, with everything that the C interface can ask for, and handles that give themselves back.
#include <cmath>
#include <memory>
#include <vector>

#include "pack/pack_asset.h"
#include "runtime/penumbra.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::capi_test {

struct Recipe {
    synthetic::TubeOptions tube = {};
    AssetPrecision precision = AssetPrecision::kI8;
    bool slots = true;  // "body/skin", "body/cloth" with materials "lambert" and "tinted"
    bool materials = true, lights = true;
    bool bounces = false;    // light that bounces
    std::uint32_t seed = 3;  // seed of the light
};

// "lambert" has no operators; "tinted" has them and three channels.
inline std::vector<BrdfFile> materials() {
    BrdfFile tinted = synthetic::lambert({0.9, 0.5, 0.2});
    tinted.name = "tinted";
    for (std::size_t i = 0; i < tinted.slices.size(); ++i) tinted.slices[i] += 0.03 * std::sin(1.3 * double(i));
    tinted.operators = {2, 3, {}, tinted.even_index, {}, "table"};
    for (std::size_t i = 0; i < 2 * 9 * 3; ++i) tinted.operators.u.push_back(0.2 * std::sin(0.9 * double(i)));
    for (std::size_t i = 0; i < 2 * tinted.even_index.size() * 3; ++i)
        tinted.operators.w.push_back(std::cos(0.4 * double(i)));
    return {synthetic::lambert(), tinted};
}

// "uniform" of order 3 has no lobes; "noise" of order 4 has two.
inline std::vector<LightFile> lights(std::uint32_t seed) {
    std::vector<LightFile> lights = {synthetic::light(3, 0), synthetic::light(4, 0.3, seed)};
    lights[1].lobes = {"joint", {{0, 0, 1}, {0.6, -0.8, 0}}, {}, 0, 0};
    for (int i = 0; i < 2 * 4 * 3; ++i) lights[1].lobes.coefficients.push_back(std::sin(0.7 * i));
    return lights;
}

inline std::vector<std::byte> packed(const Recipe& recipe = {}) {
    Model model = synthetic::tubeModel(recipe.tube);
    if (recipe.bounces) synthetic::addIndirect(model);
    if (recipe.slots) {
        model.mesh.slots = {"body/skin", "body/cloth"};
        for (std::size_t v = 0; v < model.mesh.vertexCount(); ++v)
            model.mesh.slot_of_vertex.push_back(std::uint16_t(v % 2));
    }
    const auto brdfs = recipe.materials ? materials() : std::vector<BrdfFile>{};
    const auto sky = recipe.lights ? lights(recipe.seed) : std::vector<LightFile>{};
    PackOptions options{.precision = recipe.precision};
    if (recipe.slots && recipe.materials) options.slots = {{"cloth", "tinted"}};
    return packAsset(model, brdfs, sky, options, "{}", 1).bytes;
}

struct GiveBack {
    void operator()(penumbra_scene* scene) const { penumbra_scene_destroy(scene); }
    void operator()(penumbra_asset* asset) const { penumbra_asset_close(asset); }
    void operator()(penumbra_character* character) const { penumbra_character_destroy(character); }
    void operator()(penumbra_shading* shading) const { penumbra_shading_destroy(shading); }
};
using Asset = std::unique_ptr<penumbra_asset, GiveBack>;
using Character = std::unique_ptr<penumbra_character, GiveBack>;
using Scene = std::unique_ptr<penumbra_scene, GiveBack>;
using Shading = std::unique_ptr<penumbra_shading, GiveBack>;

inline Asset open(const std::vector<std::byte>& bytes) {
    penumbra_asset* asset = nullptr;
    penumbra_asset_open_memory(bytes.data(), bytes.size(), PENUMBRA_BORROW, &asset, nullptr);
    return Asset(asset);
}

inline Character character(const Asset& asset) {
    penumbra_character* character = nullptr;
    penumbra_character_create(asset.get(), &character, nullptr);
    return Character(character);
}

inline Shading shading(const Asset& asset, const penumbra_shading_options& options = {}) {
    penumbra_shading* shading = nullptr;
    penumbra_shading_create(asset.get(), nullptr, 0, &options, &shading, nullptr);
    return Shading(shading);
}

inline penumbra_asset_info infoOf(const Asset& asset) {
    penumbra_asset_info info;
    penumbra_asset_get_info(asset.get(), &info);
    return info;
}

// The arrays of a frame, and all calls of one frame in `pieces` pieces. Every status is or-ed into the result.
struct Frame {
    std::vector<float> positions, normals, tangents, coefficients, ambient, radiance;
    std::vector<float> bounced;  // empty: no light bounces
    const float eye[3] = {0.5f, 1, 3};

    explicit Frame(const penumbra_asset_info& info)
        : positions(3 * info.vertex_count, -7.0f),
          normals(positions),
          tangents(positions),
          coefficients(info.stride * info.vertex_count, -7.0f),
          ambient(info.vertex_count, -7.0f),
          radiance(positions) {}

    penumbra_vertices vertices(std::size_t first, std::size_t count) {
        float* const bounces = bounced.empty() ? nullptr : bounced.data();
        return {positions.data(), normals.data(), tangents.data(), coefficients.data(), bounces, first, count, nullptr};
    }
    penumbra_vertices vertices() { return vertices(0, ambient.size()); }
    int evaluate(const penumbra_character* c, const penumbra_asset_info& info, std::size_t pieces = 1) {
        int status = 0;
        const auto piece = [&](std::size_t i) {
            const std::size_t vertex = info.vertex_count * i / pieces;
            return vertices(vertex, info.vertex_count * (i + 1) / pieces - vertex);
        };
        for (std::size_t i = 0; i < pieces; ++i) {
            const penumbra_vertices some = piece(i);
            const std::size_t cluster = info.cluster_count * i / pieces;
            status |= penumbra_character_evaluate(c, cluster, info.cluster_count * (i + 1) / pieces - cluster, &some,
                                                  nullptr);
            status |= penumbra_character_skin(c, &some, nullptr);
        }
        for (std::size_t i = 0; i < pieces; ++i) {
            const penumbra_vertices some = piece(i);
            status |= penumbra_character_ambient(c, &some, ambient.data(), nullptr);
        }
        return status;
    }
    // Casts on all vertices that are in the arrays.
    int cast(const penumbra_scene* scene, std::size_t except, const penumbra_character* c, const float* to_scene,
             penumbra_error* error = nullptr) {
        const penumbra_vertices all = vertices();
        return penumbra_scene_cast(scene, except, c, to_scene, &all, error);
    }
    int shade(const penumbra_shading* s, std::size_t first, std::size_t count) {
        const penumbra_vertices some = vertices(first, count);
        return penumbra_shading_shade(s, eye, &some, radiance.data(), nullptr);
    }
};

}  // namespace penumbra::capi_test
