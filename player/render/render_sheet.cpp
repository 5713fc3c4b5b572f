#include "player/render/render_sheet.h"

#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "player/render/caption_text.h"

namespace penumbra {

constexpr float kPanelGrey = 0.0452f;  // behind pictures without a background: sRGB 60 / 255

std::vector<Panel> picturesOf(const SheetOptions& sheet, Channel channel) {
    std::vector<Panel> pictures;
    for (const SheetPanel panel : sheet.panels)
        pictures.push_back(
            panel == SheetPanel::kError
                ? Panel{channel == Channel::kTransferError ? channel : Channel::kError, VisibilitySource::kModel}
            : panel == SheetPanel::kTruth ? Panel{channel, VisibilitySource::kTruth}
                                          : Panel{channel, VisibilitySource::kModel});
    return pictures;
}

bool showsError(const SheetOptions& sheet, Channel channel) {
    for (const Panel& picture : picturesOf(sheet, channel))
        if (needsTruth(picture.channel)) return true;
    return false;
}

// --- Words ----------------------------------------------------------------------------------------------------------

namespace {

std::string formatted(const char* format, double value) {
    char text[64];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

std::vector<std::string> nameItems(const ListedFrame& at, const AnimationView& animation) {
    const ClipView& clip = animation.clips[at.clip];
    std::vector<std::string> items = {std::string(clip.name) + " " + std::to_string(at.number),
                                      formatted("%.3f s", animation.times[at.frame])};
    if (clip.held_out) items.push_back("held out");
    return items;
}

}  // namespace

std::vector<std::string> captionOf(const FrameRecord& record, const AnimationView& animation) {
    std::vector<std::string> items = nameItems(record.at, animation);
    const auto add = [&](Figure figure, const char* format) {
        const double value = figureOf(record, figure);
        if (std::isfinite(value)) items.push_back(formatted(format, value));
    };
    add(Figure::kAmbientMean, "E %.4f");
    add(Figure::kAmbientMax, "max %.4f");
    add(Figure::kRmsV, "V %.4f");
    add(Figure::kRelative, "rel %.4f");
    add(Figure::kImageRmse, "rmse %.2f/255");
    add(Figure::kFlip, "flip %.4f");
    add(Figure::kOutOfRange, "out %.3f");
    return items;
}

namespace {

std::vector<std::string> titleOf(const BatchPlan& plan) {
    const AssetView& asset = *plan.look.asset;
    std::vector<std::string> items = {std::filesystem::path(asset.name).filename(),
                                      "channel " + std::string(nameOf(plan.options.channel))};
    if (plan.look.shaded) {
        std::string materials;
        for (const std::size_t material : plan.look.material_of_slot)
            if (const std::string name(asset.materials[material].name); materials.find(name) == std::string::npos)
                materials += (materials.empty() ? "" : ", ") + name;
        items.push_back("material " + materials);
        items.push_back("light " + std::string(asset.lights[plan.look.light].name));
    }
    if (plan.look.truth) items.push_back("truth " + std::filesystem::path(plan.look.truth->name).filename().string());
    return items;
}

std::string legendOf(const SheetOptions& sheet) {
    std::string legend;
    for (const SheetPanel panel : sheet.panels)
        legend += (legend.empty() ? "" : " | ") + std::string(wordOf(kPanelWords, panel));
    return legend;
}

// --- Layout and drawing ---------------------------------------------------------------------------------------------

// Returns a record with as many figures as there can be, each as wide as it can be.
FrameRecord widestRecord(const ListedFrame& at, const BatchPlan& plan) {
    FrameRecord record{at};
    record.out_of_range = 10;
    if (plan.look.truth) record.errors = ErrorSums{1, 1, 0, 0, 0, plan.relative_error ? 1.0 : std::nan("")};
    if (plan.image_error) record.image = ImageError{1, 3 * 100.0 * 100.0, 0, std::size_t(plan.flip)};
    return record;
}

}  // namespace

SheetLayout planSheet(const SheetOptions& sheet, const BatchPlan& plan) {
    const int smaller = std::min(plan.options.width, plan.options.height);
    if (sheet.shrink > smaller)
        throw BadOption("shrink", "must be at most " + std::to_string(smaller) + ", the picture's smaller side, not " +
                                      std::to_string(sheet.shrink));
    SheetLayout tiles;
    tiles.panels = int(sheet.panels.size());
    tiles.tile_width = plan.options.width / sheet.shrink;
    tiles.tile_height = plan.options.height / sheet.shrink;
    tiles.title_lines = 2;
    for (const ListedFrame& at : plan.chosen.frames) {
        const std::vector<std::string> caption = captionOf(widestRecord(at, plan), plan.look.asset->animation);
        tiles.caption_lines = std::max(tiles.caption_lines, int(wrapItems(caption, tiles.cellWidth()).size()));
    }
    const SheetLayout first = layoutSheet(plan.chosen.frames.size(), tiles, sheet.columns);
    tiles.title_lines = 1 + int(wrapItems(titleOf(plan), first.width - 2 * SheetLayout::kMargin).size());
    return layoutSheet(plan.chosen.frames.size(), tiles, first.columns);
}

SheetCell sheetCell(const SheetOptions& sheet, const BatchPlan& plan, std::vector<Image> pictures, float exposure) {
    const Vec3 background = plan.options.background.value_or(Vec3{kPanelGrey, kPanelGrey, kPanelGrey});
    const std::vector<Panel> panels = picturesOf(sheet, plan.options.channel);
    SheetCell cell;
    for (std::size_t p = 0; p < pictures.size(); ++p) {
        const float factor = panels[p].channel == Channel::kShaded ? exposure : 1;
        cell.panels.push_back(overBackground(
            shrunk(forDisplay(std::move(pictures[p]), panels[p].channel), sheet.shrink), factor, background));
    }
    return cell;
}

Image finishSheet(const SheetOptions& sheet, const BatchPlan& plan, std::vector<SheetCell> cells,
                  std::span<const FrameRecord> records, const GateResult* gate) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
        cells[i].caption = captionOf(records[i], plan.look.asset->animation);
        if (plan.look.truth && !records[i].errors) cells[i].caption.push_back("no truth");
    }
    if (gate)
        for (const std::size_t i : gate->failed) cells[i].marked = true;
    const double error_max = showsError(sheet, plan.options.channel) ? double(plan.options.error_max) : 0;
    return drawSheet({titleOf(plan), legendOf(sheet), error_max, std::move(cells)}, planSheet(sheet, plan));
}

}  // namespace penumbra
