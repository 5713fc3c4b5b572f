// Tests captions, the layout of contact sheets, and what is where on them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "formats/common/errors.h"
#include "player/render/caption_glyphs.h"
#include "player/render/caption_text.h"
#include "player/render/contact_sheet.h"

namespace penumbra::test_contact_sheet {
namespace {

using testing::ElementsAre;

constexpr Vec3 kWhite{1, 1, 1};

Image black(int width, int height) {
    return {width, height, std::vector<Vec3>(std::size_t(width) * std::size_t(height)), {}};
}

// Returns each row of the letter as '#' and '.', so that a failure can be read.
std::vector<std::string> rowsOf(const Image& image) {
    std::vector<std::string> rows;
    for (int y = 0; y < image.height; ++y) {
        rows.emplace_back();
        for (int x = 0; x < image.width; ++x)
            rows.back() += image.pixels[std::size_t(y * image.width + x)].x > 0 ? '#' : '.';
    }
    return rows;
}

TEST(CaptionText, DrawsLetters) {
    Image image = black(12, kTextHeight);
    drawText(image, 0, 0, "E7", kWhite);
    EXPECT_THAT(rowsOf(image),
                ElementsAre("............", "............", "#####.#####.", "#.........#.", "#........#..",
                            "#........#..", "####....#...", "#.......#...", "#......#....", "#......#....",
                            "#####..#....", "............", "............"));
}

TEST(CaptionText, EveryPrintableCharacterButTheBlankHasInkAndNoTwoAreAlike) {
    for (std::size_t a = 0; a < kCaptionGlyphs.size(); ++a) {
        const bool ink = kCaptionGlyphs[a] != std::array<std::uint8_t, kGlyphHeight>{};
        EXPECT_EQ(ink, a != 0) << char(kFirstGlyph + char(a));
        for (std::size_t b = 0; b < a; ++b) EXPECT_NE(kCaptionGlyphs[a], kCaptionGlyphs[b]) << a << " " << b;
        for (const std::uint8_t row : kCaptionGlyphs[a]) EXPECT_EQ(row & 0x03, 0) << "6 pixels wide";
    }
}

TEST(CaptionText, OtherCharactersAreOneQuestionMarkEach) {
    Image image = black(24, kTextHeight), marks = image;
    drawText(image, 0, 0, "a\xc3\xa9\xe2\x82\xac\n", kWhite);  // a, e acute, euro sign, line feed
    drawText(marks, 0, 0, "a???", kWhite);
    EXPECT_EQ(rowsOf(image), rowsOf(marks));
    EXPECT_EQ(textWidth("a\xc3\xa9\xe2\x82\xac"), 18);
}

TEST(CaptionText, IsClippedAtEveryEdge) {
    for (const auto& [x, y] : {std::pair(-3, -4), {7, 8}, {-100, 0}, {0, 100}}) {
        Image image = black(9, 11);
        drawText(image, x, y, "W", kWhite);  // the sanitizers see a write beyond
        EXPECT_EQ(image.pixels.size(), 99u);
    }
}

TEST(CaptionText, ItemsWrapAndLongOnesAreCut) {
    EXPECT_THAT(wrapItems({"walk 3", "0.5 s", "E 0.1"}, 6 * 13), ElementsAre("walk 3  0.5 s", "E 0.1"));
    EXPECT_THAT(wrapItems({"walk 3", "0.5 s"}, 6 * 12), ElementsAre("walk 3", "0.5 s"));
    EXPECT_THAT(wrapItems({"a long name"}, 6 * 6), ElementsAre("a lo.."));
    EXPECT_THAT(wrapItems({"\xc3\xa9\xc3\xa9\xc3\xa9\xc3\xa9"}, 6 * 3), ElementsAre("\xc3\xa9.."));
    EXPECT_THAT(wrapItems({"ab"}, 3), ElementsAre("a"));
    EXPECT_THAT(wrapItems({}, 60), ElementsAre(""));
}

TEST(ContactSheet, ShrinkingAveragesSquares) {
    Image image{5, 4, {}, {}};
    for (int i = 0; i < 20; ++i) {
        image.pixels.push_back({float(i), 0, 1});
        image.alpha.push_back(float(i % 5));
    }
    const Image half = shrunk(image, 2);
    EXPECT_EQ(half.width, 2);
    EXPECT_EQ(half.height, 2);
    EXPECT_THAT(half.alpha, ElementsAre(0.5f, 2.5f, 0.5f, 2.5f));
    EXPECT_EQ(half.pixels[0], (Vec3{3, 0, 1}));  // (0 + 1 + 5 + 6) / 4
    EXPECT_EQ(half.pixels[3], (Vec3{15, 0, 1}));
}

TEST(ContactSheet, PicturesGoOverTheBackgroundAsAPngShowsThem) {
    const Image image{2, 1, {{0.25f, 0.1f, 4}, {0, 0, 0}}, {0.5f, 0}};
    const Image over = overBackground(image, 2, {0.2f, 0.4f, 0.6f});
    EXPECT_EQ(over.pixels[0], (Vec3{0.6f, 0.4f, 0.8f})) << "0.5, 0.2 and the clamped 0.5, plus half the background";
    EXPECT_EQ(over.pixels[1], (Vec3{0.2f, 0.4f, 0.6f}));
    EXPECT_TRUE(over.alpha.empty());
}

SheetLayout tiles(int panels, int width, int height, int lines) {
    SheetLayout layout;
    layout.panels = panels;
    layout.tile_width = width;
    layout.tile_height = height;
    layout.caption_lines = lines;
    return layout;
}

TEST(ContactSheet, CellsLieBesideOneAnotherAndWithin) {
    const SheetLayout layout = layoutSheet(5, tiles(3, 40, 30, 2), 2);
    EXPECT_EQ(layout.columns, 2);
    EXPECT_EQ(layout.rows, 3);
    EXPECT_EQ(layout.cellWidth(), 3 * 40 + 2 * SheetLayout::kPanelGap);
    for (std::size_t a = 0; a < 5; ++a)
        for (int p = 0; p < 3; ++p) {
            EXPECT_GE(layout.panelX(a, p), 0);
            EXPECT_LE(layout.panelX(a, p) + 40, layout.width);
            EXPECT_LE(layout.panelY(a) + 30 + 2 * kTextHeight, layout.height);
            for (std::size_t b = 0; b < a; ++b)
                for (int q = 0; q < 3; ++q) {
                    const bool apart = layout.panelX(b, q) + 40 <= layout.panelX(a, p) ||
                                       layout.panelX(a, p) + 40 <= layout.panelX(b, q) ||
                                       layout.panelY(b) + 30 + 2 * kTextHeight <= layout.panelY(a);
                    EXPECT_TRUE(apart) << a << "," << p << " " << b << "," << q;
                }
        }
}

TEST(ContactSheet, ColumnsAreAtMostTheCellsAndChosenForTheShape) {
    EXPECT_EQ(layoutSheet(3, tiles(1, 100, 100, 0), 8).columns, 3);
    const SheetLayout chosen = layoutSheet(24, tiles(1, 100, 100, 0), 0);
    EXPECT_EQ(chosen.columns, 6) << "6 x 4 squares are 3/2";
    EXPECT_EQ(layoutSheet(1, tiles(3, 100, 100, 0), 0).columns, 1);
    EXPECT_EQ(layoutSheet(40, tiles(3, 100, 100, 0), 0).columns, 5);
}

TEST(ContactSheet, TooLargeIsAUsageErrorWithTheSize) {
    try {
        layoutSheet(100000, tiles(3, 512, 512, 3), 0);
        FAIL();
    } catch (const UsageError& error) {
        EXPECT_THAT(error.what(), testing::HasSubstr("sheet: 100000 cells would make"));
    }
    EXPECT_THROW(layoutSheet(100, tiles(1, 512, 512, 0), 100), UsageError) << "too wide";
    EXPECT_THROW(layoutSheet(100, tiles(1, 512, 512, 0), 1), UsageError) << "too high";
    EXPECT_NO_THROW(layoutSheet(100, tiles(1, 512, 256, 0), 0));
}

TEST(ContactSheet, PanelsAndCaptionsAreWhereTheLayoutSays) {
    SheetLayout layout = tiles(2, 20, 10, 1);
    layout.title_lines = 2;
    layout = layoutSheet(3, layout, 2);
    ContactSheet sheet{{"title"}, "model | truth", 0.5, {}};
    for (int c = 0; c < 3; ++c) {
        SheetCell cell;
        for (int p = 0; p < 2; ++p)
            cell.panels.push_back({20, 10, std::vector<Vec3>(200, {float(10 + c), float(p), 1}), {}});
        cell.caption = {"c" + std::to_string(c)};
        cell.marked = c == 1;
        sheet.cells.push_back(cell);
    }
    sheet.cells[2].panels[1] = {};  // none: paper
    const Image image = drawSheet(sheet, layout);
    ASSERT_EQ(image.pixels.size(), std::size_t(layout.width) * std::size_t(layout.height));
    const auto at = [&](int x, int y) {
        return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)];
    };
    for (std::size_t c = 0; c < 3; ++c)
        for (int p = 0; p < 2; ++p) {
            const Vec3 expected = c == 2 && p == 1 ? at(0, 0) : Vec3{float(10 + c), float(p), 1};
            for (const auto& [dx, dy] : {std::pair(0, 0), {19, 0}, {0, 9}, {19, 9}})
                EXPECT_EQ(at(layout.panelX(c, p) + dx, layout.panelY(c) + dy), expected) << c << " " << p;
        }
    const auto ink = [&](std::size_t c, bool red) {
        int count = 0;
        for (int y = layout.panelY(c) + 10; y < layout.panelY(c) + 10 + SheetLayout::kTextGap + kTextHeight; ++y)
            for (int x = layout.panelX(c, 0); x < layout.panelX(c, 0) + 12; ++x)
                count += at(x, y).x > 0.5f && (at(x, y).y < 0.5f) == red;
        return count;
    };
    EXPECT_GT(ink(0, false), 8);
    EXPECT_EQ(ink(0, true), 0);
    EXPECT_GT(ink(1, true), 8) << "a marked cell";
    EXPECT_EQ(ink(1, false), 0);
}

// Compares with the table of viridis at its ends and middle, as sRGB bytes; the polynomial is within 0.02 of it.
TEST(ContactSheet, ErrorColorsAreViridis) {
    const std::pair<float, Vec3> known[] = {{0, {68 / 255.0f, 1 / 255.0f, 84 / 255.0f}},
                                            {0.5f, {33 / 255.0f, 145 / 255.0f, 140 / 255.0f}},
                                            {1, {253 / 255.0f, 231 / 255.0f, 37 / 255.0f}}};
    for (const auto& [t, srgb] : known)
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(errorColor(t)[c], linearFromSrgb(srgb[c]), 0.03) << t << " " << c;
}

}  // namespace
}  // namespace penumbra::test_contact_sheet
