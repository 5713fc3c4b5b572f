#pragma once
// Makes the contact sheet of a run: its panels and its captions.
#include "player/render/contact_sheet.h"
#include "player/render/error_gate.h"
#include "player/render/render_batch.h"

namespace penumbra {

enum class SheetPanel { kModel, kTruth, kError };
inline constexpr Word<SheetPanel> kPanelWords[] = {
    {"model", SheetPanel::kModel}, {"truth", SheetPanel::kTruth}, {"error", SheetPanel::kError}};

struct SheetOptions {
    std::filesystem::path file = {};  // "" = none
    std::vector<SheetPanel> panels = {};
    int columns = 0;  // 0: chosen by layoutSheet()
    int shrink = 1;   // a tile's pixels are means of squares of as many
};

std::vector<Panel> picturesOf(const SheetOptions& sheet, Channel channel);
bool showsError(const SheetOptions& sheet, Channel channel);

// Lays out every frame of the plan before anything is drawn. Throws BadOption when the sheet would be too large.
SheetLayout planSheet(const SheetOptions& sheet, const BatchPlan& plan);

// Returns clip, frame, time, held out, and the figures that were measured.
std::vector<std::string> captionOf(const FrameRecord& record, const AnimationView& animation);

// Makes the panels of one frame as they go on the sheet, without its caption. A picture without pixels stays paper.
// `exposure` is a factor on the colours of shaded panels.
SheetCell sheetCell(const SheetOptions& sheet, const BatchPlan& plan, std::vector<Image> pictures, float exposure);

// Joins the `cells` of all records, in their order. Frames that failed in `gate`, which may be null, have red
// captions.
Image finishSheet(const SheetOptions& sheet, const BatchPlan& plan, std::vector<SheetCell> cells,
                  std::span<const FrameRecord> records, const GateResult* gate);

}  // namespace penumbra
