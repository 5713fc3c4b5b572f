#pragma once
// Plots as SVG elements for a page whose style sheet knows their classes (compare_page.cpp): colours are CSS variables,
// so that one plot suits light, dark and paper. Every mark carries its values as a <title>.
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct Axis {
    std::string label;  // with its unit
    bool log = false;
    bool from_zero = false;          // linear axes
    std::vector<double> ticks;       // empty: round numbers are found
    std::vector<std::string> names;  // of ticks 0, 1, ..: groups of bars
};

// One colour, line and mark stand for the same thing in all plots of a page.
struct SeriesStyle {
    int colour = 0;  // 0..kPlotColours - 1, the mark's shape too
    bool dashed = false, line = true, marks = true;
};
constexpr int kPlotColours = 8;

struct Series {
    std::string name;
    SeriesStyle style;
    std::vector<double> x, y;  // same length; points that are not finite are left out and break the line
};

struct Plot {
    std::string id, title;  // of the element; title also tells a screen reader what it is
    bool bars = false;      // series side by side at x = 0, 1, ..
    Axis x, y;
    std::vector<Series> series;
    double rule = std::numeric_limits<double>::quiet_NaN();  // a dotted line at this y when it is in range
    std::string rule_label{};
};

std::string plotSvg(const Plot& plot);
// A list of all series of these plots with their marks, each name once.
std::string legendHtml(const std::vector<Plot>& plots);

std::string escapeXml(std::string_view text);
std::string shortNumber(double value);  // 4 digits, no trailing zeros; "-" when not finite

}  // namespace penumbra
