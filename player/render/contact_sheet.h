#pragma once
// Puts many small pictures on one, each with a caption.
#include <string>
#include <vector>

#include "formats/image/exposure.h"

namespace penumbra {

// Averages squares of `factor` pixels, and drops what is left over at the right and at the bottom. `factor` is at
// most the smaller side.
Image shrunk(const Image& image, int factor);

struct SheetLayout {
    int columns = 1, rows = 1, panels = 1;
    int tile_width = 0, tile_height = 0;     // size of one panel
    int title_lines = 0, caption_lines = 0;  // the legend counts as a line of the title
    int width = 0, height = 0;               // size of the sheet

    int cellWidth() const { return panels * tile_width + (panels - 1) * kPanelGap; }
    // The upper left pixel of a panel of a cell; cells go in rows.
    int panelX(std::size_t cell, int panel) const;
    int panelY(std::size_t cell) const;

    static constexpr int kMargin = 8, kPanelGap = 2, kTextGap = 3;
};

// Lays out the sheet. `columns` 0 takes as many as bring the sheet's width nearest to 3/2 of its height. Throws
// BadOption when the sheet would be larger than kMaxSheetSide or kMaxSheetPixels.
constexpr int kMaxSheetSide = 16384;
constexpr double kMaxSheetPixels = 1 << 25;
SheetLayout layoutSheet(std::size_t cells, const SheetLayout& tiles, int columns);

struct SheetCell {
    std::vector<Image> panels;         // overBackground()
    std::vector<std::string> caption;  // a list of items
    bool marked = false;               // caption in red
};

struct ContactSheet {
    std::vector<std::string> title;  // a list of items
    std::string legend;              // the last title line
    double error_max = 0;            // > 0: behind the legend a scale of the error's colours
    std::vector<SheetCell> cells;
};

Image drawSheet(const ContactSheet& sheet, const SheetLayout& layout);

// Returns the error's linear colour for t in [0, 1]. shaders/channel.frag computes the same.
Vec3 errorColor(float t);

}  // namespace penumbra
