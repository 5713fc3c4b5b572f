#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "fit/papers/compare/plot_svg.h"

namespace penumbra::test_plot_svg {
namespace {

std::size_t occurrences(const std::string& text, const std::string& word) {
    std::size_t count = 0;
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++count;
    return count;
}

std::vector<std::string> tickTexts(const std::string& svg, const std::string& axis) {
    std::vector<std::string> texts;
    const std::regex pattern("<text class=\"" + axis + "\"[^>]*>([^<]*)</text>");
    for (std::sregex_iterator at(svg.begin(), svg.end(), pattern), end; at != end; ++at) texts.push_back((*at)[1]);
    return texts;
}

Plot linePlot(std::vector<double> x, std::vector<double> y) {
    Plot plot;
    plot.id = "p";
    plot.title = "t";
    plot.series = {{"s", {}, std::move(x), std::move(y)}};
    return plot;
}

TEST(PlotSvg, PutsTheLeastAndTheLargestPointInsideTheAxes) {
    for (bool log : {false, true}) {
        Plot plot = linePlot({1, 10, 1000}, {0.5, 40, 2e4});
        plot.x.log = plot.y.log = log;
        const std::string svg = plotSvg(plot);
        const std::regex circle("<circle cx=\"([0-9.]+)\" cy=\"([0-9.]+)\"");
        std::size_t count = 0;
        for (std::sregex_iterator at(svg.begin(), svg.end(), circle), end; at != end; ++at, ++count) {
            EXPECT_GT(std::stod((*at)[1]), 76);
            EXPECT_LT(std::stod((*at)[1]), 546);
            EXPECT_GT(std::stod((*at)[2]), 14);
            EXPECT_LT(std::stod((*at)[2]), 290);
        }
        EXPECT_EQ(count, 3u);
    }
}

// On a logarithmic axis, equal factors are equal steps.
TEST(PlotSvg, LogarithmicAxisIsEvenInFactors) {
    Plot plot = linePlot({1, 10, 100}, {1, 1, 1});
    plot.x.log = true;
    const std::string svg = plotSvg(plot);
    const std::regex circle("<circle cx=\"([0-9.]+)\"");
    std::vector<double> x;
    for (std::sregex_iterator at(svg.begin(), svg.end(), circle), end; at != end; ++at)
        x.push_back(std::stod((*at)[1]));
    ASSERT_EQ(x.size(), 3u);
    EXPECT_NEAR(x[1] - x[0], x[2] - x[1], 0.02);  // two digits are written
    EXPECT_EQ(tickTexts(svg, "x"), (std::vector<std::string>{"1", "10", "100"}));
}

TEST(PlotSvg, ChoosesRoundTicks) {
    EXPECT_EQ(tickTexts(plotSvg(linePlot({0, 1}, {0, 1})), "y"),
              (std::vector<std::string>{"0", "0.2", "0.4", "0.6", "0.8", "1"}));
    EXPECT_EQ(tickTexts(plotSvg(linePlot({-180, 180}, {3, 3})), "x"),
              (std::vector<std::string>{"-200", "-100", "0", "100", "200"}));
    // A range of 480 to 620 is opened by 5%. A logarithmic axis would have one tick in it, so it gets linear ticks.
    Plot narrow = linePlot({480, 620}, {1, 2});
    narrow.x.log = true;
    EXPECT_EQ(tickTexts(plotSvg(narrow), "x"), (std::vector<std::string>{"500", "550", "600", "650"}));
    Plot plot = linePlot({8, 64}, {1, 2});
    plot.x.ticks = {8, 16, 64, 128};  // the last is out of range
    EXPECT_EQ(tickTexts(plotSvg(plot), "x"), (std::vector<std::string>{"8", "16", "64"}));
}

TEST(PlotSvg, LeavesOutWhatIsNotFiniteAndBreaksTheLineThere) {
    const std::string svg = plotSvg(linePlot({1, 2, 3, 4, 5}, {1, 2, NAN, 4, 5}));
    EXPECT_EQ(occurrences(svg, "<circle"), 4u);
    std::smatch line;
    ASSERT_TRUE(std::regex_search(svg, line, std::regex("class=\"line\" d=\"([^\"]*)\"")));
    EXPECT_EQ(occurrences(line[1], "M"), 2u);
    EXPECT_EQ(occurrences(line[1], "L"), 2u);
    for (const std::vector<double>& y : {std::vector<double>{NAN, INFINITY}, std::vector<double>{}}) {
        const std::string empty = plotSvg(linePlot(std::vector<double>(y.size(), 1), y));
        EXPECT_EQ(empty.find("nan"), std::string::npos);
        EXPECT_EQ(empty.find("inf"), std::string::npos);
        EXPECT_NE(empty.find("</svg>"), std::string::npos);
    }
}

TEST(PlotSvg, EscapesNames) {
    Plot plot = linePlot({1, 2}, {1, 2});
    plot.series[0].name = "a<b & \"c\"";
    plot.title = "<script>";
    for (const std::string& text : {plotSvg(plot), legendHtml({plot})}) {
        EXPECT_NE(text.find("a&lt;b &amp; &quot;c&quot;"), std::string::npos);
        EXPECT_EQ(text.find("<script>"), std::string::npos);
    }
}

// Bars of 1, 2 and 4 stand on zero, and their heights are as 1 to 2 to 4.
TEST(PlotSvg, BarsStandOnZeroSideBySide) {
    Plot plot;
    plot.bars = true;
    plot.x.names = {"a", "b"};
    plot.y.from_zero = true;
    plot.series = {{"s", {}, {0, 1}, {1, 2}}, {"t", {1}, {1}, {4}}};
    const std::string svg = plotSvg(plot);
    const std::regex rect("<rect x=\"([0-9.]+)\" y=\"[0-9.]+\" width=\"([0-9.]+)\" height=\"([0-9.]+)\"");
    std::vector<double> x, width, height;
    for (std::sregex_iterator at(svg.begin(), svg.end(), rect), end; at != end; ++at) {
        x.push_back(std::stod((*at)[1]));
        width.push_back(std::stod((*at)[2]));
        height.push_back(std::stod((*at)[3]));
    }
    ASSERT_EQ(height.size(), 3u);
    EXPECT_NEAR(height[1] / height[0], 2, 1e-3);
    EXPECT_NEAR(height[2] / height[0], 4, 1e-3);
    EXPECT_GE(x[2], x[1] + width[1]);
    EXPECT_GE(x[1], x[0] + width[0]);
}

// A whisker is as long as twice the spread, about the top of its bar, and inside of the axes.
TEST(PlotSvg, BarsHaveWhiskers) {
    Plot plot;
    plot.bars = true;
    plot.x.names = {"a"};
    plot.y.from_zero = true;
    plot.series = {{"s", {}, {0}, {2}, {0.5}}};
    const std::string svg = plotSvg(plot);
    std::smatch bar, whisker;
    ASSERT_TRUE(std::regex_search(svg, bar, std::regex("y=\"([0-9.]+)\" width=\"[0-9.]+\" height=\"([0-9.]+)\"")));
    ASSERT_TRUE(std::regex_search(svg, whisker, std::regex("class=\"spread\" d=\"M[0-9.]+ ([0-9.]+)V([0-9.]+)\"")));
    const double top = std::stod(bar[1]), unit = std::stod(bar[2]) / 2, high = std::stod(whisker[1]),
                 low = std::stod(whisker[2]);
    EXPECT_NEAR(top - high, 0.5 * unit, 0.02);
    EXPECT_NEAR(low - top, 0.5 * unit, 0.02);
    EXPECT_GT(high, 14);
    EXPECT_NE(svg.find("2 +- 0.5"), std::string::npos);
}

}  // namespace
}  // namespace penumbra::test_plot_svg
