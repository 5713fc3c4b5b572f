#pragma once
// The contact sheet of a run: which panels, what its captions say.
#include "player/render/contact_sheet.h"
#include "player/render/error_gate.h"
#include "player/render/render_batch.h"

namespace penumbra {

enum class SheetPanel { kModel, kTruth, kError };

struct SheetOptions {
    std::filesystem::path file = {};  // "" = none
    std::vector<SheetPanel> panels = {};
    int columns = 0;  // 0: chosen by layoutSheet()
    int shrink = 1;   // a tile's pixels are means of squares of as many
};

// "model", "truth" or "error"; UsageError names --panels.
SheetPanel parseSheetPanel(std::string_view word);
std::vector<Panel> picturesOf(const SheetOptions& sheet, Channel channel);
bool showsError(const SheetOptions& sheet, Channel channel);

// The layout for every frame of the plan, before anything is drawn; UsageError when it would be too large.
SheetLayout planSheet(const SheetOptions& sheet, const BatchPlan& plan);

// Clip, frame, time, held out, and the figures that were measured.
std::vector<std::string> captionOf(const FrameRecord& record, const AnimationView& animation);

// The panels of one frame as they go on the sheet, without its caption. A picture without pixels stays paper.
SheetCell sheetCell(const SheetOptions& sheet, const BatchPlan& plan, std::vector<Image> pictures);

// `cells` of all records, in their order. Frames that failed in `gate`, which may be null, have their captions in red.
Image finishSheet(const SheetOptions& sheet, const BatchPlan& plan, std::vector<SheetCell> cells,
                  std::span<const FrameRecord> records, const GateResult* gate);

}  // namespace penumbra
