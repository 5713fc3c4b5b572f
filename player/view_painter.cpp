#include "player/view_painter.h"

#include <chrono>

#include "player/visibility_lobe.h"

namespace penumbra {

constexpr double kLobeRadius = 0.14;  // of visibility 1, in radii of the scene

FrameView paneView(const ViewState& state, const Rectangle& area, double scene_radius, Vec3 offset) {
    Camera camera = state.camera;
    camera.target = camera.target - toDouble(offset);
    FrameView view;
    clipFromModel(camera, double(area.width) / area.height, scene_radius, view.clip_from_model);
    view.eye = toFloat(cameraPosition(camera));
    view.error_max = state.error_max;
    view.display = state.display;
    return view;
}

// Differences of vertex values are formed on the CPU, and the error's figures are.
bool ScenePainter::needsValues(const ViewState& state) const {
    return path_ == EvaluationPath::kCpu || shownCompare(state) == Compare::kDifference ||
           state.channel == Channel::kError || state.component.has_value();
}

// GL counts rows from below.
static void setPane(const Pane& pane, int window_height) {
    const auto below = [&](const Rectangle& r) { return window_height - r.y - r.height; };
    gl::Viewport(pane.area.x, below(pane.area), pane.area.width, pane.area.height);
    gl::Scissor(pane.clip.x, below(pane.clip), pane.clip.width, pane.clip.height);
}

ModelPainter& ScenePainter::modelPainter(const Key& key, const Character& character) {
    const auto found = model_painters_.find(key);
    if (found != model_painters_.end()) return found->second;
    return model_painters_
        .try_emplace(key, character.asset, key.channel, character.shading.get(), key.shown == Shown::kTruth)
        .first->second;
}

void ScenePainter::drawCharacter(std::size_t index, Shown shown, bool on_cpu, const FrameView& view, PaintCost& cost) {
    const Character& character = *scene_->characters[index];
    if (shown == Shown::kTruth && !character.truth_frame) shown = Shown::kModel;
    const Key key{index, shown, character.channel};
    const auto start = std::chrono::steady_clock::now();
    if (on_cpu) {
        const auto at = value_painters_.try_emplace(key, character.asset.mesh.triangles, character.channel).first;
        at->second.upload(character.vertices.positions, character.values[std::size_t(shown)]);
    } else {
        ModelPainter& painter = modelPainter(key, character);
        painter.setPose(*character.evaluator, character.interpolation->bones());
        if (shown == Shown::kTruth) painter.setNumbers(character.truth_numbers);
    }
    cost.upload += std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
    FrameView shown_view = view;
    if (character.plain) shown_view.display = DisplayTransform();
    if (on_cpu)
        value_painters_.at(key).draw(shown_view);
    else
        model_painters_.at(key).draw(shown_view);
}

// Over everything that is in the pane.
void ScenePainter::drawLobe(const ViewState& state, const Pane& pane, double radius) {
    const auto [index, vertex] = *state.picked;
    const Character& character = *scene_->characters[index];
    const VertexFigures figures = figuresOf(character, vertex);
    const bool truth = pane.shown == Shown::kTruth && !figures.truth.empty();
    const std::span<const float> numbers = truth ? figures.truth : figures.model;
    const FrameVertices& at = character.vertices;
    Shape lobe =
        visibilityLobe(character.asset.model.convention, numbers, localFrame(at.normals[vertex], at.tangents[vertex]),
                       at.positions[vertex], float(kLobeRadius * radius));
    FrameView view = paneView(state, pane.area, radius, character.offset);
    view.display = DisplayTransform();
    shadeLobe(lobe, view.eye);
    if (!lobe_) lobe_.emplace(lobe.triangles, Channel::kShaded);
    lobe_->upload(lobe.positions, lobe.values);
    gl::Clear(GL_DEPTH_BUFFER_BIT);
    lobe_->draw(view);
}

void ScenePainter::draw(const ViewState& state, int window_height, const Rectangle& picture, PaintCost& cost) {
    cost = {};
    const double radius = boundsOf(*scene_).radius();
    gl::Disable(GL_SCISSOR_TEST);
    gl::ClearColor(0, 0, 0, 1);
    gl::Clear(GL_COLOR_BUFFER_BIT);  // under the panels
    gl::Enable(GL_SCISSOR_TEST);
    gl::Enable(GL_DEPTH_TEST);
    gl::Disable(GL_CULL_FACE);
    gl::Disable(GL_BLEND);
    for (const Pane& pane : panesOf(state, picture)) {
        if (pane.clip.width == 0) continue;
        setPane(pane, window_height);
        gl::ClearColor(0.11f, 0.12f, 0.13f, 1);
        gl::Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        backdrop_.draw(*scene_, state, paneView(state, pane.area, radius, {}),
                       double(pane.area.width) / pane.area.height);
        for (std::size_t i = 0; i < scene_->characters.size(); ++i)
            drawCharacter(i, pane.shown, needsValues(state),
                          paneView(state, pane.area, radius, scene_->characters[i]->offset), cost);
        if (state.picked) drawLobe(state, pane, radius);
    }
    gl::Disable(GL_SCISSOR_TEST);
    checkGl("drawing the scene");
}

}  // namespace penumbra
