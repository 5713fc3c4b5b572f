#include "player/view/view_backdrop.h"

#include "player/view/view_look.h"

namespace penumbra {

bool showsGround(const Scene& scene, const ViewState& state) {
    return state.show.ground && shownCompare(state) != Compare::kDifference && scene.ground_file &&
           scene.ground.values.key() && (scene.field || cameraPosition(state.camera).y >= scene.ground_file->height);
}

void Backdrop::drawSky(const Scene& scene, const ViewState& state, const FrameView& view) {
    sky_.update(shownLightKey(scene, state), [&](std::optional<SkyPainter>& sky) {
        if (!sky) sky.emplace();
        sky->upload(shownSky(scene, state));
    });
    (*sky_)->draw(view, lightRotation(state));
}

namespace {

BrdfModels modelsOf(const ViewSunlight* suns) { return suns ? suns->groundModels() : 0; }

const Sunlight* sunlightOf(const ViewSunlight* suns) { return suns ? &suns->sunlight() : nullptr; }

}  // namespace

void Backdrop::drawGround(const Scene& scene, const FrameView& view, const ViewSunlight* suns) {
    const ShownGround& ground = scene.ground;
    if (tiles_.vertices.empty()) tiles_ = groundTiles(ground.vertices.side);
    ValuePainter& painter =
        ground_.try_emplace(suns != nullptr, tiles_.triangles, Channel::kShaded, Sides::kFading, modelsOf(suns))
            .first->second;
    uploaded_.update(*ground.values.key(), [&](auto&) {
        std::vector<Vec3> positions, values, normals, tangents;
        std::vector<LobeRange> lobes;
        for (std::size_t v = 0; v < tiles_.vertices.size(); ++v) {
            const std::uint32_t of_grid = tiles_.vertices[v];
            positions.push_back(ground.vertices.positions[of_grid]);
            values.push_back((*ground.values)[of_grid] * tiles_.shades[v]);
            if (!suns) continue;
            normals.push_back(ground.vertices.normals[of_grid]);
            tangents.push_back(ground.vertices.tangents[of_grid]);
            lobes.push_back(suns->groundLobes(tiles_.shades[v]));
        }
        painter.upload(positions, values, {normals, tangents, lobes});
    });
    FrameView plain = view;
    if (!ground.lit()) plain.display = DisplayTransform();
    const float size = float(scene.ground_file->size);
    plain.rim = {scene.ground_file->center.x, scene.ground_file->center.z, 0.4f * size, 0.5f * size};
    painter.draw(plain, sunlightOf(suns));
}

ViewField& Backdrop::fieldOnGpu(const Scene& scene) {
    field_on_gpu_ = true;
    if (!field_) field_.emplace(scene);
    return *field_;
}

void Backdrop::drawPlainGround(const Scene& scene, const FrameView& view, ViewSunlight* suns) {
    if (field_on_gpu_) return field_->draw(view, sunlightOf(suns));
    const GroundVertices& vertices = scene.ground.vertices;
    ValuePainter& painter =
        plain_ground_.try_emplace(suns != nullptr, vertices.triangles, Channel::kShaded, Sides::kBoth, modelsOf(suns))
            .first->second;
    if (scene.field && suns) {
        field_values_ = *scene.ground.values;
        const SunlitSurface surface = suns->fieldSurface(view.eye, field_values_);
        painter.upload(vertices.positions, field_values_, surface);
    } else {
        const std::vector<LobeRange> lobes(suns ? vertices.positions.size() : 0, suns ? suns->groundLobes(1) : 0);
        painter.upload(vertices.positions, *scene.ground.values, {vertices.normals, vertices.tangents, lobes});
    }
    painter.draw(view, sunlightOf(suns));
}

void Backdrop::draw(const Scene& scene, const ViewState& state, const FrameView& view, ViewSunlight* suns) {
    const ShadingSet* shading = scene.characters.front()->shown.shading.get();
    if (state.show.background && shading && state.show.channel == Channel::kShaded && !state.show.component &&
        shownCompare(state) != Compare::kDifference)
        drawSky(scene, state, view);
    if (!showsGround(scene, state)) return;
    if (!scene.field) return drawGround(scene, view, suns);
    FrameView plain = view;
    if (!scene.ground.lit()) plain.display = DisplayTransform();
    drawPlainGround(scene, plain, suns);
}

}  // namespace penumbra
