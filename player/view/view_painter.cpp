#include "player/view/view_painter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "formats/image/exposure.h"
#include "player/frame/visibility_lobe.h"
#include "player/gl/offscreen_target.h"
#include "player/papers/transfer/transfer_model.h"
#include "player/view/vertex_figures.h"
#include "player/view/view_look.h"

namespace penumbra {

FrameView paneView(const ViewState& state, const Rectangle& area, double scene_radius, const Affine& to_scene) {
    FrameView view;
    std::array<float, 16> from_scene;
    clipFromModel(state.camera, double(area.width) / area.height, scene_radius, from_scene);
    const auto& m = to_scene.m;
    for (std::size_t row = 0; row < 4; ++row)
        for (std::size_t column = 0; column < 4; ++column) {
            float sum = column == 3 ? from_scene[12 + row] : 0;
            for (std::size_t k = 0; k < 3; ++k) sum += from_scene[4 * k + row] * m[4 * k + column];
            view.clip_from_model[4 * column + row] = sum;
        }
    view.eye = transposed(to_scene.linear()) * (toFloat(cameraPosition(state.camera)) - to_scene.translation());
    view.error_max = state.show.error_max;
    view.display = state.display;
    view.scene_from_model = to_scene;
    return view;
}

// Differences of vertex values and the error's figures are computed on the CPU, and so are composed assets of more
// bands than their fields have or with a floor, shadows of others that do not join as a product, and whom a level
// ground lights.
bool ScenePainter::needsValues(const ViewState& state) const {
    const bool many_bands = std::ranges::any_of(scene_->characters, [](const auto& character) {
        const ModelView& model = character->asset.model;
        return !hasVisibility(character->asset) ||
               (model.composition && (model.convention.order > kFieldOrder || model.composition->floor));
    });
    return many_bands || path_ == EvaluationPath::kCpu || shownCompare(state) == Compare::kDifference ||
           state.show.channel == Channel::kError || state.show.component.has_value() ||
           shownCastMode(state) != CastMode::kProduct || groundCasts(*scene_, state) ||
           (scene_->field && (shownCompare(state) != Compare::kModel || state.show.shadows != Shadows::kBoth));
}

UpdateNeeds ScenePainter::needs(const ViewState& state, int threads) const {
    return {needsValues(state), !castsOnGpu(state), !fieldOnGpu(state), threads};
}

ViewSunlight* ScenePainter::sunsFor(const ViewState& state) { return showsSuns(*scene_, state) ? &*suns_ : nullptr; }

// Numbers that are given, as those of the truth are, have their shadows already.
bool ScenePainter::castsOnGpu(const ViewState& state) const {
    return !needsValues(state) && shownCompare(state) == Compare::kModel && state.show.shadows == Shadows::kBoth &&
           (scene_->cast->casterCount() > 0 || scene_->field);
}

namespace {

// Sets viewport and scissors. GL counts rows from below.
void setPane(const Pane& pane, int window_height) {
    const auto below = [&](const Rectangle& r) { return window_height - r.y - r.height; };
    gl::Viewport(pane.area.x, below(pane.area), pane.area.width, pane.area.height);
    gl::Scissor(pane.clip.x, below(pane.clip), pane.clip.width, pane.clip.height);
}

}  // namespace

ScenePainter::ScenePainter(const Scene& scene, EvaluationPath path) : scene_(&scene), path_(path) {
    std::map<const Vec3*, std::size_t> group_of_file;  // by where a file is mapped
    for (std::size_t i = 0; i < scene.characters.size(); ++i) {
        const Vec3* file = scene.characters[i]->asset.mesh.positions.data();
        const auto [found, is_new] = group_of_file.try_emplace(file, groups_.size());
        if (is_new) groups_.emplace_back();
        groups_[found->second].characters.push_back(i);
    }
}

namespace {

// A frame without truth shows its model wherever truth is asked for.
Shown shownOf(const Character& character, Shown shown) {
    return shown == Shown::kTruth && !*character.posed.truth_frame ? Shown::kModel : shown;
}

}  // namespace

void ScenePainter::poseCasters() {
    casters_.clear();
    for (const auto& character : scene_->characters)
        if (character->caster != kNobody)
            casters_.push_back({character->posed.evaluator.get(), *character->casts, character->posed.to_scene});
    if (!cast_) cast_.emplace(casters_);
    cast_->pose(casters_);
}

void ScenePainter::evaluate(Group& group, const ViewState& state, Shown shown, Vec3 eye) {
    const bool casts = castsOnGpu(state);
    const ViewSunlight* const suns = sunsFor(state);
    const Character& first = *scene_->characters[group.characters.front()];
    if (!group.asset)
        group.asset = std::make_shared<GlAsset>(first.asset, first.shown.shading.get(), first.posed.evaluator.get());
    std::optional<ModelPainter>& painter = group.painters[std::size_t(shown)];
    if (!painter) painter.emplace(group.asset, group.characters.size());
    CoefficientsKey shown_coefficients;
    shown_coefficients.shadows = state.show.shadows;
    posed_.clear();
    for (const std::size_t i : group.characters) {
        const Character& character = *scene_->characters[i];
        PosedCharacter& posed = posed_.emplace_back(
            PosedCharacter{character.posed.evaluator.get(), character.posed.to_scene, character.shown.shading.get()});
        if (shownOf(character, shown) == Shown::kTruth)
            posed.coefficients = *character.posed.truth_coefficients;
        else if (!casts && changesCoefficients(*scene_, i, shown_coefficients))
            posed.coefficients = character.posed.vertices.coefficients;
        posed.caster = character.caster;
        if (suns) posed.lobes = suns->slotLobes(i);
    }
    painter->evaluate(first.shown.channel, posed_, eye, casts ? &*cast_ : nullptr);
}

ScenePainter::Key ScenePainter::keyOf(const ViewState& state, std::size_t index, Shown shown) const {
    const Character& character = *scene_->characters[index];
    return {index, shownOf(character, shown), character.shown.channel, showsSuns(*scene_, state),
            showsPictures(character, state)};
}

// Characters of one file share its pictures.
PicturedMesh ScenePainter::picturesOf(const Character& character) {
    const ShadingSet* const shading = character.shown.shading.get();
    PicturedMesh mesh = pictures_.try_emplace(character.asset.mesh.positions.data(), shading).first->second;
    mesh.shading = shading;
    return mesh;
}

void ScenePainter::uploadValues(const ViewState& state, const Key& key) {
    const Character& character = *scene_->characters[key.character];
    std::span<const Vec3> values = character.shown.of(key.shown);
    const FrameVertices& vertices = character.posed.vertices;
    SunlitSurface surface{vertices.normals, vertices.tangents, {}};
    if (key.sunlit) {
        sunlit_values_.assign(values.begin(), values.end());
        values = sunlit_values_;
        const Vec3 from = toFloat(cameraPosition(state.camera)) - character.posed.to_scene.translation();
        surface = suns_->surfaceOf(key.character, transposed(character.posed.to_scene.linear()) * from, sunlit_values_);
    }
    auto at = value_painters_.find(key);
    if (at == value_painters_.end())
        at = value_painters_
                 .try_emplace(key, character.asset.mesh, character.shown.channel, Sides::kSeen,
                              key.sunlit ? kAllBrdfModels | kMembranes : 0,
                              key.pictured ? picturesOf(character) : PicturedMesh())
                 .first;
    at->second.upload(vertices.positions, values, surface);
}

void ScenePainter::prepare(const ViewState& state, const std::vector<Pane>& panes, double radius) {
    const bool casts = castsOnGpu(state);
    ViewField* const field = fieldOnGpu(state) ? &backdrop_.fieldOnGpu(*scene_) : nullptr;
    if (!field) backdrop_.drawFieldOfCpu();
    if (casts) {
        poseCasters();
        if (field) field->update();
        cast_->setHeights(field ? &field->heights() : nullptr);
    }
    if (showsSuns(*scene_, state)) {
        if (!suns_) suns_.emplace(*scene_);
        suns_->shine(state);
    }
    for (const Pane& pane : panes) {
        if (pane.clip.width == 0) continue;
        if (needsValues(state)) {
            for (std::size_t i = 0; i < scene_->characters.size(); ++i)
                uploadValues(state, keyOf(state, i, pane.shown));
            continue;
        }
        const Vec3 eye = paneView(state, pane.area, radius, {}).eye;
        for (Group& group : groups_) evaluate(group, state, pane.shown, eye);
        if (field && showsGround(*scene_, state)) field->evaluate(state, eye, *cast_, sunsFor(state));
    }
    if (casts) cast_->release();
}

void ScenePainter::drawCharacters(const ViewState& state, const Pane& pane, double radius,
                                  const std::optional<DisplayTransform>& display) {
    const ViewSunlight* const shining = sunsFor(state);
    const Sunlight* const suns = shining ? &shining->sunlight() : nullptr;
    if (!needsValues(state)) {
        FrameView view = paneView(state, pane.area, radius, {});
        view.display = display;
        for (const Group& group : groups_) group.painters[std::size_t(pane.shown)]->draw(view, suns);
        return;
    }
    for (std::size_t i = 0; i < scene_->characters.size(); ++i) {
        const Character& character = *scene_->characters[i];
        FrameView view = paneView(state, pane.area, radius, character.posed.to_scene);
        view.display = state.show.component ? DisplayTransform() : display;
        value_painters_.at(keyOf(state, i, pane.shown)).draw(view, suns);
    }
}

// Draws the boxes of all parts, or of the one far part whose lobe is drawn, and the spheres of those that cast by them.
void ScenePainter::drawBoxes(const ViewState& state, const Pane& pane, double radius) {
    const VisibilityFactor* factor = shownFactor(*scene_, state);
    const bool one = factor && factor->choice.kind == FactorKind::kPart;
    for (std::size_t i = 0; i < scene_->characters.size(); ++i) {
        const Character& character = *scene_->characters[i];
        if (one && state.inspect.picked->character != i) continue;
        FrameView view = paneView(state, pane.area, radius, character.posed.to_scene);
        view.display = DisplayTransform();
        const std::span<const Affine> bones = character.posed.evaluator->bones();
        if (!one && character.casts == CasterKind::kSpheres)
            overlays_.drawBoxes(sphereEdges(character.asset.blockers, bones), view);
        if (!character.posed.evaluator->composed() || (!one && character.casts == CasterKind::kSpheres)) continue;
        const CompositionView& composition = *character.asset.model.composition;
        std::vector<std::size_t> parts(one ? 1 : composition.parts.size(), one ? factor->choice.part : 0);
        if (!one) std::iota(parts.begin(), parts.end(), std::size_t(0));
        overlays_.drawBoxes(fieldBoxEdges(composition, bones, parts), view);
    }
}

// Draws the lobe over everything that is in the pane. The truth is known as a whole alone.
void ScenePainter::drawLobe(const ViewState& state, const Pane& pane, double radius) {
    const auto [index, vertex] = *state.inspect.picked;
    const Character& character = *scene_->characters[index];
    if (!hasVisibility(character.asset)) return;
    const VertexFigures figures = figuresOf(character, vertex);
    const bool truth = pane.shown == Shown::kTruth && !figures.truth.empty();
    const std::span<const float> coefficients = truth ? figures.truth : figures.model;
    VisibilityFactor drawn{{}, character.asset.model.convention, {coefficients.begin(), coefficients.end()}};
    const VisibilityFactor* factor = shownFactor(*scene_, state);
    if (factor && factor->choice.kind != FactorKind::kWhole) drawn = *factor;
    const FrameVertices& at = character.posed.vertices;
    FrameView view = paneView(state, pane.area, radius, character.posed.to_scene);
    view.display = DisplayTransform();
    overlays_.drawLobe(drawn, {at.positions[vertex], at.normals[vertex], at.tangents[vertex]},
                       float(kLobeRadius * boundsOf(*scene_).radius()), view);
}

void ScenePainter::drawPane(const ViewState& state, const Pane& pane, double radius, int window_height) {
    setPane(pane, window_height);
    gl::ClearColor(0.11f, 0.12f, 0.13f, 1);
    gl::Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    backdrop_.draw(*scene_, state, paneView(state, pane.area, radius, {}), sunsFor(state));
    // A difference is a number, which no tone mapping may bend.
    const bool number = pane.shown == Shown::kDifference;
    drawCharacters(state, pane, radius,
                   number ? DisplayTransform{state.display.exposure, ToneMap::kOff} : state.display);
    if (state.show.boxes) drawBoxes(state, pane, radius);
    if (state.inspect.picked) drawLobe(state, pane, radius);
}

namespace {

// Of what the planes of the camera must leave room for.
double shownRadius(const Scene& scene, const ViewState& state) {
    const double radius = boundsOf(scene).radius();
    return showsGround(scene, state) ? std::max(radius, scene.ground_file->size / 4) : radius;
}

}  // namespace

float ScenePainter::measureExposure(const ViewState& state, const Rectangle& picture) {
    constexpr int kHeight = 128;  // pixels, enough for a percentile
    const std::vector<Pane> panes = panesOf(state, picture);
    const Pane& pane = panes.front().clip.width > 0 ? panes.front() : panes.back();
    const double radius = shownRadius(*scene_, state), aspect = double(pane.area.width) / pane.area.height;
    prepare(state, {pane}, radius);
    const OffscreenTarget target(std::clamp(int(std::lround(kHeight * aspect)), 1, 4 * kHeight), kHeight, 1);
    gl::Disable(GL_SCISSOR_TEST);
    gl::Disable(GL_CULL_FACE);
    gl::Disable(GL_BLEND);
    target.begin();
    drawCharacters(state, pane, radius, std::nullopt);
    if (showsGround(*scene_, state) && scene_->ground.lit()) {
        FrameView view = paneView(state, pane.area, radius, {});
        view.display.reset();
        backdrop_.drawPlainGround(*scene_, view, sunsFor(state));
    }
    const float exposure = automaticExposure(target.read());
    gl::BindFramebuffer(GL_FRAMEBUFFER, 0);
    return exposure;
}

void ScenePainter::draw(const ViewState& state, int window_height, const Rectangle& picture, PaintCost& cost) {
    const double radius = shownRadius(*scene_, state);
    const std::vector<Pane> panes = panesOf(state, picture);
    const auto start = std::chrono::steady_clock::now();
    evaluate_timer_.begin();
    prepare(state, panes, radius);
    evaluate_timer_.end();
    cost.upload = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    draw_timer_.begin();
    gl::Disable(GL_SCISSOR_TEST);
    gl::ClearColor(0, 0, 0, 1);
    gl::Clear(GL_COLOR_BUFFER_BIT);  // under the panels
    gl::Enable(GL_SCISSOR_TEST);
    gl::Enable(GL_DEPTH_TEST);
    gl::Disable(GL_CULL_FACE);
    gl::Disable(GL_BLEND);
    for (const Pane& pane : panes)
        if (pane.clip.width > 0) drawPane(state, pane, radius, window_height);
    gl::Disable(GL_SCISSOR_TEST);
    draw_timer_.end();
    cost.gpu_evaluate = evaluate_timer_.milliseconds();
    cost.gpu_draw = draw_timer_.milliseconds();
    checkGl("drawing the scene");
}

}  // namespace penumbra
