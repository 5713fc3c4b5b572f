#include <imgui.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>

#include "player/frame/visibility_lobe.h"
#include "player/papers/transfer/transfer_model.h"
#include "player/view/vertex_figures.h"
#include "player/view/window/view_widgets.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

std::string text(std::string_view view) { return std::string(view); }

std::size_t bytesOf(const NumbersView& numbers) {
    return numbers.count * bytesPerNumber(numbers.precision) + numbers.scale.size_bytes();
}

void modelLines(const AssetView& asset) {
    const ModelView& model = asset.model;
    for (const std::string& line : linesOfTransfer(asset)) ImGui::TextUnformatted(line.c_str());
    if (!hasVisibility(asset)) return;
    std::size_t bytes = 0, components = 0;
    for (const ClusterView& cluster : model.clusters) {
        bytes += bytesOf(cluster.mean) + bytesOf(cluster.basis);
        components += cluster.components();
    }
    std::string features = nameOf(model.features);
    std::replace(features.begin(), features.end(), '-', ' ');
    ImGui::Text("model %s of %s", nameOf(model.kind), features.c_str());
    ImGui::Text("convention %s, %d numbers a vertex", model.convention.name().c_str(), model.convention.size());
    ImGui::Text("%zu clusters, %.1f components each", model.clusters.size(),
                double(components) / double(model.clusters.size()));
    ImGui::Text("visibility %.0f bytes a vertex, %s", double(bytes) / double(asset.mesh.positions.size()),
                nameOf(model.clusters.front().basis.precision));
    ImGui::Text("quantisation error %.2g", double(model.quantization_error));
    if (!model.composition) return;
    const CompositionView& composed = *model.composition;
    ImGui::Text("composed of %zu parts, local within %d steps", composed.parts.size(), composed.local_steps);
    ImGui::Text("fields %.2f MB, %s residual", double(composed.byteCount()) / 1e6,
                composed.residual.empty() ? "no" : "with a");
}

}  // namespace

void assetPanel(const Character& character) {
    const AssetView& asset = character.asset;
    const std::size_t vertices = asset.mesh.positions.size();
    std::size_t held_out = 0;
    for (const ClipView& clip : asset.animation.clips) held_out += clip.held_out;
    ImGui::TextWrapped("%s", std::filesystem::path(asset.name).filename().c_str());
    ImGui::Text("%.2f MB, %.0f bytes a vertex", double(character.file_bytes) / 1e6,
                double(character.file_bytes) / double(vertices));
    ImGui::Text("%zu vertices, %zu triangles", vertices, asset.mesh.triangles.size() / 3);
    ImGui::Text("%zu joints, %zu slots", asset.animation.jointCount(),
                std::max<std::size_t>(1, asset.mesh.slots.size()));
    ImGui::Text("%zu clips, %zu held out, %zu frames", asset.animation.clips.size(), held_out,
                asset.animation.frameCount());
    modelLines(asset);
}

namespace {

// The model's coefficients of visibility beside the truth's, and the scores of the cluster.
void coefficientTable(const Character& character, const VertexFigures& figures) {
    const std::vector<int> indices = character.asset.model.convention.indices();
    if (!ImGui::BeginTable("numbers", 3, ImGuiTableFlags_RowBg)) return;
    for (std::size_t i = 0; i < figures.model.size(); ++i) {
        const int band = bandOfIndex(indices[i]);
        ImGui::TableNextColumn();
        ImGui::Text("v %d,%d", band, indices[i] - shIndex(band, 0));
        ImGui::TableNextColumn();
        ImGui::Text("%+.4f", double(figures.model[i]));
        ImGui::TableNextColumn();
        if (!figures.truth.empty()) ImGui::Text("%+.4f", double(figures.truth[i]));
    }
    ImGui::EndTable();
    std::string scores = "scores";
    for (const float score : figures.scores) {
        char number[16];
        std::snprintf(number, sizeof number, " %.3g", double(score));
        scores += number;
    }
    ImGui::TextWrapped("%s", scores.c_str());
}

}  // namespace

void vertexPanel(const Scene& scene, const PickedVertex& picked) {
    const Character& character = *scene.characters[picked.character];
    const VertexFigures figures = figuresOf(character, picked.vertex);
    ImGui::TextDisabled("Vertex %zu, cluster %zu (%s)", picked.vertex, figures.cluster, text(figures.joint).c_str());
    ImGui::Text("E of the model %.4f", double(figures.model_ambient));
    if (!figures.truth.empty())
        ImGui::Text("E of the truth %.4f, error %+.4f", double(figures.true_ambient),
                    double(figures.model_ambient - figures.true_ambient));
    if (!ImGui::TreeNode("coefficients and scores")) return;
    coefficientTable(character, figures);
    ImGui::TreePop();
}

void factorPanel(const Scene& scene, ViewState& state) {
    const Character& character = *scene.characters[state.inspect.picked->character];
    const VisibilityFactor* shown = shownFactor(scene, state);
    const float column = 0.65f * ImGui::GetContentRegionAvail().x;
    for (const VisibilityFactor& factor : *character.posed.factors) {
        if (ImGui::Selectable(nameOf(character.asset, factor.choice).c_str(), &factor == shown))
            state.inspect.factor = factor.choice;
        ImGui::SameLine(column);
        if (factor.choice.kind == FactorKind::kResidual)
            ImGui::Text("%+.4f (x %.0f)", double(factor.ambient), double(kResidualEnlargement));
        else
            ImGui::Text(" %.4f", double(factor.ambient));
    }
}

namespace {

// Marks the training range on the slider that was drawn last, which goes from `least` to `most`.
void markRange(const ComponentFigures& figures, float least, float most) {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    const auto at = [&](float score) { return low.x + (high.x - low.x) * (score - least) / (most - least); };
    ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(at(figures.least), high.y - 3), ImVec2(at(figures.most), high.y),
                                              IM_COL32(120, 200, 120, 255));
}

// Draws a slider that goes half as far again as training went, both ways.
bool scoreSlider(std::size_t component, const ComponentFigures& figures, float& score) {
    const float room = std::max(0.5f * (figures.most - figures.least), 1e-6f);
    const float least = std::min(figures.least - room, score), most = std::max(figures.most + room, score);
    char label[64];
    std::snprintf(label, sizeof label, "%zu: %%+.3g  (%.0f%%%%)", component, 100 * double(figures.share));  // a format
    ImGui::PushID(int(component));
    ImGui::SetNextItemWidth(-1);
    const bool changed = ImGui::SliderFloat("##score", &score, least, most, label);
    markRange(figures, least, most);
    ImGui::PopID();
    return changed;
}

}  // namespace

void componentPanel(const Scene& scene, ViewState& state) {
    const Character& character = *scene.characters[state.inspect.picked->character];
    const std::size_t cluster = clusterAt(character.asset, state.inspect.picked->vertex);
    const Cached<std::size_t, std::vector<ComponentFigures>>& components = character.timeline.components;
    if (components.key() != cluster || components->empty()) {
        ImGui::TextDisabled("reading the training poses");
        return;
    }
    ImGui::Text("cluster %zu: score (share of variance)", cluster);
    if (ImGui::SmallButton("as the pose has them (Z)")) state.inspect.score_edit.reset();
    const std::span<const float> scores = character.posed.evaluator->scores(cluster);
    for (std::size_t k = 0; k < scores.size(); ++k) {
        float score = scores[k];
        if (!scoreSlider(k, (*components)[k], score)) continue;
        if (!state.inspect.score_edit || state.inspect.score_edit->character != state.inspect.picked->character ||
            state.inspect.score_edit->cluster != cluster)
            state.inspect.score_edit =
                ScoreEdit{state.inspect.picked->character, cluster, std::vector<float>(scores.size())};
        state.inspect.score_edit->added[k] += score - scores[k];
    }
}

}  // namespace penumbra
