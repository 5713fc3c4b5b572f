#include "player/render/contact_sheet.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>

#include "formats/common/errors.h"
#include "player/render/caption_text.h"

namespace penumbra {

// Linear colours: a dark grey paper, and letters.
constexpr Vec3 kPage{0.012f, 0.012f, 0.014f}, kWhite{0.8f, 0.8f, 0.8f}, kRed{1, 0.12f, 0.08f};
constexpr int kScaleWidth = 96;  // pixels of the scale of colours

Image shrunk(const Image& image, int factor) {
    if (factor == 1) return image;
    Image out{image.width / factor, image.height / factor, {}, {}};
    const float weight = 1.0f / float(factor * factor);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) {
            Vec3 color;
            float alpha = 0;
            for (int dy = 0; dy < factor; ++dy)
                for (int dx = 0; dx < factor; ++dx) {
                    const std::size_t i =
                        std::size_t(y * factor + dy) * std::size_t(image.width) + std::size_t(x * factor + dx);
                    color += image.pixels[i];
                    if (!image.alpha.empty()) alpha += image.alpha[i];
                }
            out.pixels.push_back(color * weight);
            if (!image.alpha.empty()) out.alpha.push_back(alpha * weight);
        }
    return out;
}

// --- Layout ---------------------------------------------------------------------------------------------------------

namespace {

int captionHeight(int lines) { return lines == 0 ? 0 : lines * kTextHeight + SheetLayout::kTextGap; }

}  // namespace

int SheetLayout::panelX(std::size_t cell, int panel) const {
    return kMargin + int(cell % std::size_t(columns)) * (cellWidth() + kMargin) + panel * (tile_width + kPanelGap);
}

int SheetLayout::panelY(std::size_t cell) const {
    return kMargin + captionHeight(title_lines) +
           int(cell / std::size_t(columns)) * (tile_height + captionHeight(caption_lines) + kMargin);
}

namespace {

// Returns the sizes that follow from the number of columns. They are doubles, since nothing is bounded yet.
std::pair<double, double> sheetSize(const SheetLayout& layout, std::size_t cells, int columns) {
    const double rows = std::ceil(double(cells) / columns);
    const double cell = double(layout.panels) * (layout.tile_width + SheetLayout::kPanelGap) - SheetLayout::kPanelGap;
    const double row = layout.tile_height + captionHeight(layout.caption_lines) + SheetLayout::kMargin;
    return {SheetLayout::kMargin + columns * (cell + SheetLayout::kMargin),
            SheetLayout::kMargin + captionHeight(layout.title_lines) + rows * row};
}

int bestColumns(const SheetLayout& layout, std::size_t cells) {
    int best = 1;
    double least = 1e30;
    for (int columns = 1; columns <= int(std::min<std::size_t>(cells, kMaxSheetSide)); ++columns) {
        const auto [width, height] = sheetSize(layout, cells, columns);
        const double off = std::abs(std::log(width / height / 1.5));
        if (off < least) best = columns;
        least = std::min(least, off);
    }
    return best;
}

}  // namespace

SheetLayout layoutSheet(std::size_t cells, const SheetLayout& tiles, int columns) {
    assert(cells > 0 && tiles.tile_width > 0 && tiles.tile_height > 0 && tiles.panels > 0);
    SheetLayout layout = tiles;
    layout.columns = columns > 0 ? int(std::min(cells, std::size_t(columns))) : bestColumns(layout, cells);
    layout.rows = int((cells + std::size_t(layout.columns) - 1) / std::size_t(layout.columns));
    const auto [width, height] = sheetSize(layout, cells, layout.columns);
    if (width > kMaxSheetSide || height > kMaxSheetSide || width * height > kMaxSheetPixels) {
        char size[64];
        std::snprintf(size, sizeof size, "%.0f x %.0f", width, height);
        throw BadOption("sheet", std::to_string(cells) + " cells would make " + size + " pixels, above " +
                                     std::to_string(kMaxSheetSide) + " a side or " +
                                     std::to_string(int(kMaxSheetPixels)) +
                                     " in all: take fewer frames, other columns, a smaller size or shrink more");
    }
    layout.width = int(width);
    layout.height = int(height);
    return layout;
}

// --- Drawing --------------------------------------------------------------------------------------------------------

// Computes viridis by M. Zucker's polynomial of degree 6 (public domain), whose colours are sRGB.
Vec3 errorColor(float t) {
    constexpr double kC[7][3] = {
        {0.2777273272, 0.0054073445, 0.3340998053},   {0.1050930431, 1.4046135299, 1.3845901626},
        {-0.3308618287, 0.2148475595, 0.0950951630},  {-4.6342304990, -5.7991009734, -19.3324409563},
        {6.2282699363, 14.1799333668, 56.6905526007}, {4.7763849977, -13.7451453777, -65.3530326334},
        {-5.4354558559, 4.6458526122, 26.3124352496}};
    Vec3 color;
    for (int c = 0; c < 3; ++c) {
        double srgb = 0;
        for (int power = 6; power >= 0; --power) srgb = srgb * double(t) + kC[power][c];
        color[c] = linearFromSrgb(float(std::clamp(srgb, 0.0, 1.0)));
    }
    return color;
}

namespace {

void paste(Image& sheet, const Image& tile, int left, int top) {
    for (int y = 0; y < tile.height; ++y)
        std::copy_n(tile.pixels.begin() + std::ptrdiff_t(y) * tile.width, tile.width,
                    sheet.pixels.begin() + std::ptrdiff_t(top + y) * sheet.width + left);
}

void drawLines(Image& sheet, const std::vector<std::string>& lines, int most, int x, int y, Vec3 color) {
    for (int line = 0; line < std::min(most, int(lines.size())); ++line)
        drawText(sheet, x, y + line * kTextHeight, lines[std::size_t(line)], color);
}

// Draws "0 ==== 0.25".
void drawScale(Image& sheet, double error_max, int x, int top) {
    char most[32];
    std::snprintf(most, sizeof most, " %g", error_max);
    const int left = x + textWidth("0 ");
    drawText(sheet, x, top, "0 ", kWhite);
    drawText(sheet, left + kScaleWidth, top, most, kWhite);
    for (int column = 0; column < kScaleWidth; ++column) {
        const Vec3 color = errorColor((float(column) + 0.5f) / kScaleWidth);
        for (int y = top + 2; y < top + kTextHeight - 2 && left + column < sheet.width; ++y)
            sheet.pixels[std::size_t(y) * std::size_t(sheet.width) + std::size_t(left + column)] = color;
    }
}

void drawTitle(Image& image, const ContactSheet& sheet, const SheetLayout& layout) {
    constexpr int kLeft = SheetLayout::kMargin;
    if (layout.title_lines == 0) return;
    drawLines(image, wrapItems(sheet.title, layout.width - 2 * kLeft), layout.title_lines - 1, kLeft, kLeft, kWhite);
    const int y = kLeft + (layout.title_lines - 1) * kTextHeight;
    drawText(image, kLeft, y, sheet.legend, kWhite);
    if (sheet.error_max > 0) drawScale(image, sheet.error_max, kLeft + textWidth(sheet.legend + "  "), y);
}

}  // namespace

Image drawSheet(const ContactSheet& sheet, const SheetLayout& layout) {
    Image image{layout.width,
                layout.height,
                std::vector<Vec3>(std::size_t(layout.width) * std::size_t(layout.height), kPage),
                {}};
    drawTitle(image, sheet, layout);
    for (std::size_t c = 0; c < sheet.cells.size(); ++c) {
        const SheetCell& cell = sheet.cells[c];
        const int y = layout.panelY(c);
        for (int panel = 0; panel < int(cell.panels.size()); ++panel)
            paste(image, cell.panels[std::size_t(panel)], layout.panelX(c, panel), y);
        drawLines(image, wrapItems(cell.caption, layout.cellWidth()), layout.caption_lines, layout.panelX(c, 0),
                  y + layout.tile_height + SheetLayout::kTextGap, cell.marked ? kRed : kWhite);
    }
    return image;
}

}  // namespace penumbra
