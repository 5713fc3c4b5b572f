#include <imgui.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <numeric>
#include <optional>
#include <string>
#include <vector>

#include "player/view/vertex_figures.h"
#include "player/view/view_painter.h"
#include "player/view/window/view_widgets.h"

namespace penumbra {
namespace {

constexpr ImU32 kInk = IM_COL32(230, 230, 230, 255);

// Writes a text with a shadow, which is readable over a bright background too.
void write(ImVec2 at, const char* label) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.AddText(ImVec2(at.x + 1, at.y + 1), IM_COL32(0, 0, 0, 160), label);
    list.AddText(at, kInk, label);
}

// Draws a dark plate for texts and legends, which are then readable over any picture.
void plate(ImVec2 low, ImVec2 high) {
    const float margin = 0.4f * ImGui::GetFontSize();
    ImGui::GetBackgroundDrawList()->AddRectFilled(ImVec2(low.x - margin, low.y - margin),
                                                  ImVec2(high.x + margin, high.y + margin), IM_COL32(16, 18, 21, 190),
                                                  margin);
}

// Writes a text in lines of at most `width`. Returns the lower edge of its plate.
float writeOnPlate(ImVec2 at, const std::string& label, ImU32 color, float width) {
    width = std::max(width, 1.0f);
    const ImVec2 size = ImGui::CalcTextSize(label.c_str(), nullptr, false, width);
    plate(at, ImVec2(at.x + size.x, at.y + size.y));
    ImGui::GetBackgroundDrawList()->AddText(ImGui::GetFont(), ImGui::GetFontSize(), at, color, label.c_str(), nullptr,
                                            width);
    return at.y + size.y + 0.4f * ImGui::GetFontSize();
}

// Draws colours from below to above, and the numbers of `low` to `high` that they stand for, in the upper right corner
// of the picture: messages and the hint have its lower edge.
void scale(const Rectangle& picture, const char* what, std::span<const ImU32> colors, double low, double high) {
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    const float font = ImGui::GetFontSize(), width = 0.9f * font;
    const float height = std::min(8 * font, 0.35f * float(picture.height));
    const float x = float(picture.x + picture.width) - std::max(ImGui::CalcTextSize(what).x, 5 * font) - font;
    const float top = float(picture.y) + font, y = top + 2 * font;
    plate(ImVec2(x, top), ImVec2(float(picture.x + picture.width) - font, y + height + 0.5f * font));
    write(ImVec2(x, top), what);
    const std::size_t steps = colors.size() - 1;
    const auto heightOf = [&](std::size_t i) { return y + height * float(steps - i) / float(steps); };
    for (std::size_t i = 0; i < steps; ++i)
        list.AddRectFilledMultiColor(ImVec2(x, heightOf(i + 1)), ImVec2(x + width, heightOf(i)), colors[i + 1],
                                     colors[i + 1], colors[i], colors[i]);
    const std::size_t every = height / float(steps) < font ? steps / 2 : 1;  // leaves room for the numbers
    for (std::size_t i = 0; i <= steps; i += every) {
        char label[24];
        std::snprintf(label, sizeof label, "%.3g", low + (high - low) * double(i) / double(steps));
        write(ImVec2(x + 1.4f * width, heightOf(i) - 0.5f * font), label);
    }
}

ImU32 displayed(Vec3 linear) {
    const auto byte = [](float c) {
        const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f;
        return int(std::lround(255 * s));
    };
    return IM_COL32(byte(linear.x), byte(linear.y), byte(linear.z), 255);
}

void scales(const Scene& scene, const ViewState& state, const Rectangle& picture) {
    const bool compares = state.show.channel == Channel::kError || shownCompare(state) == Compare::kDifference;
    if (!state.show.component && compares && !whyNoTruth(scene, state).empty()) return;
    if (state.show.component) {
        std::array<ImU32, 5> colors;
        for (std::size_t i = 0; i < colors.size(); ++i) colors[i] = displayed(divergingColor(float(i) - 2, 2));
        const double most = double(scene.characters[state.selected]->shown.component->most);
        scale(picture, "change of E for a score of 1", colors, -most, most);
    } else if (state.show.channel == Channel::kError) {
        // viridis as in shaders/channel.frag, at quarters.
        static constexpr std::array<ImU32, 5> kViridis = {IM_COL32(71, 1, 85, 255), IM_COL32(59, 82, 139, 255),
                                                          IM_COL32(33, 145, 140, 255), IM_COL32(94, 201, 98, 255),
                                                          IM_COL32(253, 231, 37, 255)};
        scale(picture, "|E - truth|   [ ]", kViridis, 0, double(state.show.error_max));
    } else if (shownCompare(state) == Compare::kDifference) {
        std::array<ImU32, 5> colors;
        for (std::size_t i = 0; i < colors.size(); ++i) {
            const float part = float(i) / float(colors.size() - 1);
            colors[i] = displayed({part, part, part});
        }
        const bool exposed = state.show.channel == Channel::kShaded;
        scale(picture, exposed ? "|model - truth|, radiance" : "|E - truth|", colors, 0,
              1 / (double(state.show.difference_gain) * (exposed ? double(state.display.exposure) : 1)));
    }
}

// Projects a point to ImGui's coordinates. Returns nothing for one behind the camera.
std::optional<ImVec2> project(const FrameView& view, const Rectangle& area, Vec3 p) {
    const auto& m = view.clip_from_model;
    const auto row = [&](std::size_t i) { return m[i] * p.x + m[4 + i] * p.y + m[8 + i] * p.z + m[12 + i]; };
    const float w = row(3);
    if (!(w > 0)) return std::nullopt;
    return ImVec2(float(area.x) + float(area.width) * (0.5f + 0.5f * row(0) / w),
                  float(area.y) + float(area.height) * (0.5f - 0.5f * row(1) / w));
}

// Draws normals (blue), tangents (red) and their cross products (green) of vertices that face the eye, at most
// kMaxFrames.
void tangentFrames(const Character& character, const Pane& pane, const FrameView& view, float size) {
    constexpr std::size_t kMaxFrames = 1500;
    ImDrawList& list = *ImGui::GetBackgroundDrawList();
    list.PushClipRect(ImVec2(float(pane.clip.x), float(pane.clip.y)),
                      ImVec2(float(pane.clip.x + pane.clip.width), float(pane.clip.y + pane.clip.height)));
    const FrameVertices& at = character.posed.vertices;
    const std::size_t step = at.positions.size() / kMaxFrames + 1;
    for (std::size_t v = 0; v < at.positions.size(); v += step) {
        const Vec3 p = at.positions[v], n = at.normals[v], t = at.tangents[v];
        if (dot(view.eye - p, n) <= 0) continue;
        const std::optional<ImVec2> start = project(view, pane.area, p);
        const std::array<std::pair<Vec3, ImU32>, 3> axes = {{{t, IM_COL32(230, 70, 60, 255)},
                                                             {cross(n, t), IM_COL32(80, 200, 80, 255)},
                                                             {n, IM_COL32(90, 140, 255, 255)}}};
        for (const auto& [axis, color] : axes) {
            const std::optional<ImVec2> end = project(view, pane.area, p + axis * size);
            if (start && end) list.AddLine(*start, *end, color);
        }
    }
    list.PopClipRect();
}

// Returns the vertex that is nearest to the middle of its cluster.
std::size_t middleVertex(const Character& character, const ClusterView& cluster) {
    const std::span<const Vec3> positions =
        std::span(character.posed.vertices.positions).subspan(cluster.first_vertex, cluster.vertex_count);
    Vec3 middle;
    for (const Vec3& p : positions) middle += p / float(positions.size());
    const auto away = [&](const Vec3& p) { return length(p - middle); };
    return cluster.first_vertex + std::size_t(std::ranges::min_element(positions, {}, away) - positions.begin());
}

bool overlaps(const ImVec4& a, const ImVec4& b) { return a.x < b.z && b.x < a.z && a.y < b.w && b.y < a.w; }

// Writes names around points. Where names would cover one another, the first one is written.
class NameWriter {
public:
    void write(ImVec2 at, const std::string& name) {
        const ImVec2 size = ImGui::CalcTextSize(name.c_str());
        const ImVec4 box(at.x - size.x / 2, at.y - size.y / 2, at.x + size.x / 2, at.y + size.y / 2);
        if (std::ranges::any_of(taken_, [&](const ImVec4& other) { return overlaps(box, other); })) return;
        taken_.push_back(box);
        penumbra::write(ImVec2(box.x, box.y), name.c_str());
    }

private:
    std::vector<ImVec4> taken_;
};

// Writes number and joint of every cluster whose middle faces the eye, those of large clusters first.
void clusterNames(const Character& character, const Pane& pane, const FrameView& view) {
    NameWriter names;
    const std::vector<ClusterView>& clusters = character.asset.model.clusters;
    std::vector<std::size_t> order(clusters.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::ranges::stable_sort(order, std::greater(), [&](std::size_t c) { return clusters[c].vertex_count; });
    for (const std::size_t c : order) {
        const std::size_t v = middleVertex(character, clusters[c]);
        const Vec3 p = character.posed.vertices.positions[v];
        const std::optional<ImVec2> at = project(view, pane.area, p);
        if (!at || dot(view.eye - p, character.posed.vertices.normals[v]) <= 0) continue;
        const std::string_view joint = character.asset.animation.joint_names[std::size_t(clusters[c].joint)];
        names.write(*at, std::to_string(c) + " " + std::string(joint));
    }
}

void inPanes(const Scene& scene, const ViewState& state, const Rectangle& picture, auto&& draw) {
    const double radius = boundsOf(scene).radius();
    for (const Pane& pane : panesOf(state, picture))
        for (const auto& character : scene.characters)
            draw(*character, pane, paneView(state, pane.area, radius, character->posed.to_scene), float(radius));
}

}  // namespace

namespace {

// Writes the name of every part at the middle of its bounding sphere.
void partNames(const Character& character, const Pane& pane, const FrameView& view) {
    if (!character.posed.evaluator->composed()) return;
    const std::span<const PosedPart> posed = character.posed.evaluator->posedParts();
    NameWriter names;
    for (std::size_t p = 0; p < posed.size(); ++p)
        if (const std::optional<ImVec2> at = project(view, pane.area, posed[p].center))
            names.write(*at, nameOfPart(character.asset, p));
}

using Label = std::pair<std::string, ImU32>;

// Returns the name of a pane. Where it should show truth and there is none, it says so in another colour.
Label nameOfPane(const Scene& scene, const ViewState& state, Shown shown) {
    static constexpr std::array kNames = {"model", "baked truth", "difference"};
    const bool error = state.show.channel == Channel::kError && !state.show.component;
    const std::string_view problem = whyNoTruth(scene, state);
    if ((shown == Shown::kModel && !error) || problem.empty()) return {kNames[std::size_t(shown)], kInk};
    const char* instead = shown == Shown::kTruth ? ": this is the model"
                          : error                ? ": this is ambient visibility"
                                                 : ": nothing to compare with";
    return {std::string(problem) + instead, kMarked};
}

// Returns what is written over a pane, so that a screenshot tells what it shows.
std::vector<Label> labelsOf(const Scene& scene, const ViewState& state, Shown shown) {
    std::vector<Label> labels;
    if (scene.hasTruth()) labels.push_back(nameOfPane(scene, state, shown));
    if (state.inspect.score_edit) labels.emplace_back("scores changed (Z: back)", kMarked);
    const VisibilityFactor* const factor = shownFactor(scene, state);
    if (!factor || (shown == Shown::kTruth && factor->choice.kind == FactorKind::kWhole)) return labels;
    char label[160];
    std::snprintf(label, sizeof label, "lobe: %s, E %.4f",
                  nameOf(scene.characters[state.inspect.picked->character]->asset, factor->choice).c_str(),
                  double(factor->ambient));
    labels.emplace_back(label, kInk);
    return labels;
}

void paneLabels(const Scene& scene, const ViewState& state, const Rectangle& picture) {
    const float font = ImGui::GetFontSize();
    for (const Pane& pane : panesOf(state, picture)) {
        if (pane.clip.width == 0) continue;
        ImVec2 at(float(pane.clip.x) + font, float(pane.clip.y) + font);
        for (const auto& [label, color] : labelsOf(scene, state, pane.shown))
            at.y = writeOnPlate(at, label, color, float(pane.clip.width) - 2 * font) + 0.6f * font;
        const float left = float(pane.clip.x), top = float(pane.clip.y);
        if (pane.clip.x > picture.x)
            ImGui::GetBackgroundDrawList()->AddLine(ImVec2(left, top), ImVec2(left, top + float(pane.clip.height)),
                                                    IM_COL32(230, 230, 230, 160));
    }
}

}  // namespace

void drawOverlays(const Scene& scene, const ViewState& state, const Rectangle& picture) {
    if (state.show.frames)
        inPanes(scene, state, picture,
                [](const Character& character, const Pane& pane, const FrameView& view, float radius) {
                    tangentFrames(character, pane, view, 0.015f * radius);
                });
    if (state.show.channel == Channel::kClusters && !state.show.component)
        inPanes(scene, state, picture, [](const Character& character, const Pane& pane, const FrameView& view, float) {
            clusterNames(character, pane, view);
        });
    if (state.show.channel == Channel::kParts && !state.show.component)
        inPanes(scene, state, picture, [](const Character& character, const Pane& pane, const FrameView& view, float) {
            partNames(character, pane, view);
        });
    paneLabels(scene, state, picture);
    scales(scene, state, picture);
}

void drawMessage(const std::string& message, const Rectangle& picture) {
    const float margin = ImGui::GetFontSize(), width = float(picture.width) - 2 * margin;
    if (message.empty() || width <= 0) return;
    const float height = ImGui::CalcTextSize(message.c_str(), nullptr, false, width).y;
    writeOnPlate(ImVec2(float(picture.x) + margin, float(picture.y + picture.height) - margin - height), message, kInk,
                 width);
}

void drawHint(const Rectangle& picture) {
    static constexpr std::array<std::array<const char*, 2>, 3> kHint = {
        {{"Left drag: look around", "Right drag: turn the light"},
         {"Space: play", "Click: what a point sees"},
         {"F1: all keys", "F2: open a file"}}};
    const float font = ImGui::GetFontSize(), line = ImGui::GetTextLineHeightWithSpacing();
    const float column = ImGui::CalcTextSize(kHint[0][0]).x + 2 * font;
    const bool beside = column + ImGui::CalcTextSize(kHint[0][1]).x + 2 * font < float(picture.width);
    const float width = ImGui::CalcTextSize(kHint[0][1]).x + (beside ? column : 0), height = (beside ? 3 : 6) * line;
    const ImVec2 at(float(picture.x) + 0.5f * (float(picture.width) - width),
                    float(picture.y + picture.height) - height - font);
    plate(at, ImVec2(at.x + width, at.y + height));
    for (std::size_t row = 0; row < kHint.size(); ++row)
        for (std::size_t side = 0; side < 2; ++side)
            write(beside ? ImVec2(at.x + column * float(side), at.y + line * float(row))
                         : ImVec2(at.x, at.y + line * float(2 * row + side)),
                  kHint[row][side]);
}

}  // namespace penumbra
