#pragma once
// Draws plots as SVG elements for a page whose style sheet knows their classes (page_html.cpp). Colours are CSS
// variables, so one plot suits light, dark and paper. Every mark carries its values as a <title>.
#include <limits>
#include <string>
#include <vector>

namespace penumbra {

struct Axis {
    std::string label{};  // with its unit
    bool log = false;
    bool from_zero = false;            // for linear axes
    std::vector<double> ticks{};       // empty when round numbers are to be found
    std::vector<std::string> names{};  // names of the ticks 0, 1, ..: the groups of bars
};

// One colour, line and mark stand for the same thing in all plots of a page.
struct SeriesStyle {
    int colour = 0;  // 0..kPlotColours - 1; it also chooses the mark's shape
    bool dashed = false, line = true, marks = true;
};
constexpr int kPlotColours = 8;

struct Series {
    std::string name;
    SeriesStyle style{};
    std::vector<double> x{}, y{};  // same length; a point that is not finite is left out and breaks the line
    std::vector<double> spread{};  // for bars: each has a whisker from y - spread to y + spread; empty: none
};

struct Plot {
    std::string id, title;  // id of the element; the title also tells a screen reader what it is
    bool bars = false;      // series stand side by side at x = 0, 1, ..
    Axis x{}, y{};
    std::vector<Series> series{};
    double rule = std::numeric_limits<double>::quiet_NaN();  // a dotted line at this y if it is in range
    std::string rule_label{};
};

std::string plotSvg(const Plot& plot);
// Returns a list of all series of these plots with their marks. Each name appears once.
std::string legendHtml(const std::vector<Plot>& plots);

std::string shortNumber(double value);  // 4 digits, no trailing zeros; "-" when not finite

}  // namespace penumbra
