#include "fit/papers/compare/plot_svg.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <set>

#include "fit/page/page_html.h"

namespace penumbra {

namespace {

// Sizes in units of the view box.
constexpr double kWidth = 560, kHeight = 340, kLeft = 76, kRight = 14, kTop = 14, kBottom = 50;
constexpr double kMark = 4;

#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
std::string
format(const char* pattern, ...) {
    char buffer[512];
    va_list arguments;
    va_start(arguments, pattern);
    std::vsnprintf(buffer, sizeof buffer, pattern, arguments);
    va_end(arguments);
    return buffer;
}

struct Scale {
    double low = 0, high = 1;  // values
    double from = 0, to = 1;   // positions
    bool log = false;

    double operator()(double value) const {
        const double t = log ? std::log(value / low) / std::log(high / low) : (value - low) / (high - low);
        return from + t * (to - from);
    }
    bool holds(double value) const { return std::isfinite(value) && value >= low && value <= high; }
};

struct Range {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    void add(double value, bool log) {
        if (!std::isfinite(value) || (log && value <= 0)) return;
        low = std::min(low, value);
        high = std::max(high, value);
    }
    bool empty() const { return low > high; }
};

// Returns 1, 2 or 5 times a power of ten that divides `span` into about `count` steps.
double roundStep(double span, int count) {
    const double rough = span / count, power = std::pow(10.0, std::floor(std::log10(rough)));
    for (double factor : {1.0, 2.0, 5.0})
        if (factor * power >= rough * 0.999) return factor * power;
    return 10 * power;
}

std::vector<double> linearTicks(double low, double high) {
    std::vector<double> ticks;
    const double step = roundStep(high - low, 6);
    for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i)
        ticks.push_back(i == 0 ? 0 : i * step);
    return ticks;
}

// Returns powers of ten, with 2 and 5 between them when the range is less than two decades. Where that leaves one tick,
// it returns those of a linear axis.
std::vector<double> logTicks(double low, double high) {
    const double decades = std::log10(high / low);
    const double stride = std::max(1.0, std::ceil(decades / 7));
    std::vector<double> ticks;
    for (double e = std::floor(std::log10(low)); e <= std::ceil(std::log10(high)); e += stride)
        for (double factor : {1.0, 2.0, 5.0}) {
            const double tick = factor * std::pow(10.0, e);
            if ((factor == 1 || decades < 2) && tick >= low * 0.999 && tick <= high * 1.001) ticks.push_back(tick);
        }
    return ticks.size() > 1 ? ticks : linearTicks(low, high);
}

// Returns the range of the data, opened a little and never empty.
Range opened(Range range, const Axis& axis) {
    if (range.empty()) return {axis.log ? 1.0 : 0.0, axis.log ? 10.0 : 1.0};
    if (axis.log) {
        const double margin = std::max(std::pow(range.high / range.low, 0.05), 1.05);
        return {range.low / margin, range.high * margin};
    }
    if (axis.from_zero) range.low = std::min(range.low, 0.0);
    double margin = 0.06 * (range.high - range.low);
    if (margin <= 0) margin = range.high != 0 ? 0.1 * std::abs(range.high) : 1;
    return {axis.from_zero && range.low == 0 ? 0 : range.low - margin, range.high + margin};
}

struct PlotFrame {
    Scale x, y;
    std::vector<double> x_ticks, y_ticks;
};

PlotFrame frameOf(const Plot& plot) {
    Range x, y;
    for (const Series& series : plot.series)
        for (std::size_t i = 0; i < series.x.size(); ++i) {
            if (!std::isfinite(series.y[i])) continue;
            x.add(series.x[i], plot.x.log);
            y.add(series.y[i] + (series.spread.empty() ? 0 : series.spread[i]), plot.y.log);
        }
    if (plot.bars)
        x = {-0.5, double(plot.x.names.size()) - 0.5};
    else
        x = opened(x, plot.x);
    y = opened(y, plot.y);
    PlotFrame frame{{x.low, x.high, kLeft, kWidth - kRight, plot.x.log},
                    {y.low, y.high, kHeight - kBottom, kTop, plot.y.log},
                    plot.x.ticks,
                    plot.y.ticks};
    if (plot.bars)
        for (std::size_t i = 0; i < plot.x.names.size(); ++i) frame.x_ticks.push_back(double(i));
    if (frame.x_ticks.empty()) frame.x_ticks = plot.x.log ? logTicks(x.low, x.high) : linearTicks(x.low, x.high);
    if (frame.y_ticks.empty()) frame.y_ticks = plot.y.log ? logTicks(y.low, y.high) : linearTicks(y.low, y.high);
    return frame;
}

std::string tickText(const Axis& axis, double tick) {
    return escapeXml(axis.names.empty() ? shortNumber(tick) : axis.names[std::size_t(tick)]);
}

std::string axesSvg(const Plot& plot, const PlotFrame& frame) {
    const double bottom = kHeight - kBottom, right = kWidth - kRight;
    std::string svg = "<g class=\"axes\">";
    for (double tick : frame.y_ticks) {
        if (!frame.y.holds(tick)) continue;
        const double y = frame.y(tick);
        svg += format("<line class=\"grid\" x1=\"%g\" x2=\"%g\" y1=\"%.2f\" y2=\"%.2f\"/>", kLeft, right, y, y);
        svg += format("<text class=\"y\" x=\"%g\" y=\"%.2f\">", kLeft - 8, y + 4) + tickText(plot.y, tick) + "</text>";
    }
    for (double tick : frame.x_ticks) {
        if (!frame.x.holds(tick)) continue;
        const double x = frame.x(tick);
        if (!plot.bars)
            svg +=
                format("<line class=\"tick\" x1=\"%.2f\" x2=\"%.2f\" y1=\"%g\" y2=\"%g\"/>", x, x, bottom, bottom + 5);
        svg += format("<text class=\"x\" x=\"%.2f\" y=\"%g\">", x, bottom + 19) + tickText(plot.x, tick) + "</text>";
    }
    svg += format("<path class=\"axis\" d=\"M%g %gV%gH%g\"/>", kLeft, kTop, bottom, right);
    svg += format("<text class=\"x label\" x=\"%g\" y=\"%g\">", (kLeft + right) / 2, kHeight - 8);
    svg += escapeXml(plot.x.label) + "</text>";
    svg += format("<text class=\"x label\" transform=\"translate(14 %g) rotate(-90)\">", (kTop + bottom) / 2);
    svg += escapeXml(plot.y.label) + "</text>";
    if (frame.y.holds(plot.rule)) {
        const double y = frame.y(plot.rule);
        svg += format("<line class=\"rule\" x1=\"%g\" x2=\"%g\" y1=\"%.2f\" y2=\"%.2f\"/>", kLeft, right, y, y);
        svg += format("<text class=\"rule\" x=\"%g\" y=\"%.2f\">", right - 4, y - 5) + escapeXml(plot.rule_label);
        svg += "</text>";
    }
    return svg + "</g>";
}

// Draws the shape that belongs to the colour, so that colour is never the only difference.
std::string markSvg(const SeriesStyle& style, double x, double y, const std::string& title) {
    const double r = kMark;
    if (style.colour % 4 == 0)
        return format("<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%g\">", x, y, r) + title + "</circle>";
    std::string path;
    if (style.colour % 4 == 1) path = format("M%.2f %.2fh%gv%gh%gz", x - r, y - r, 2 * r, 2 * r, -2 * r);
    if (style.colour % 4 == 2) path = format("M%.2f %.2fl%g %gh%gz", x, y - 1.25 * r, 1.2 * r, 2.2 * r, -2.4 * r);
    if (style.colour % 4 == 3) {
        const double d = 1.35 * r;
        path = format("M%.2f %.2fl%g %gl%g %gl%g %gz", x, y - d, d, d, -d, d, -d, -d);
    }
    return "<path d=\"" + path + "\">" + title + "</path>";
}

std::string classesOf(const Plot& plot, const SeriesStyle& style) {
    const char* kind = plot.bars ? " bars" : style.line ? "" : " points";
    return format("series c%d%s%s", style.colour, style.dashed ? " dashed" : "", kind);
}

std::string pointTitle(const Plot& plot, const Series& series, std::size_t i) {
    const std::string at = plot.bars ? plot.x.names[std::size_t(series.x[i])] : shortNumber(series.x[i]);
    return "<title>" +
           escapeXml(series.name + "\n" + (plot.x.label.empty() ? "" : plot.x.label + ": ") + at + "\n" + plot.y.label +
                     ": " + shortNumber(series.y[i]) +
                     (series.spread.empty() ? "" : " +- " + shortNumber(series.spread[i]))) +
           "</title>";
}

std::string linesSvg(const Plot& plot, const Series& series, const PlotFrame& frame) {
    std::string path, marks;
    bool pen_down = false;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        const bool shown = frame.x.holds(series.x[i]) && frame.y.holds(series.y[i]);
        if (shown) {
            const double x = frame.x(series.x[i]), y = frame.y(series.y[i]);
            path += format("%c%.2f %.2f", pen_down ? 'L' : 'M', x, y);
            if (series.style.marks) marks += markSvg(series.style, x, y, pointTitle(plot, series, i));
        }
        pen_down = shown;
    }
    if (!series.style.line || path.find('L') == std::string::npos) return marks;
    return "<path class=\"line\" d=\"" + path + "\"/>" + marks;
}

std::string barsSvg(const Plot& plot, std::size_t index, const PlotFrame& frame) {
    const Series& series = plot.series[index];
    const double slot = frame.x(1) - frame.x(0), width = 0.8 * slot / double(plot.series.size());
    std::string svg;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (!std::isfinite(series.y[i])) continue;
        const double x = frame.x(series.x[i]) - 0.4 * slot + width * double(index);
        const double y = frame.y(series.y[i]), zero = frame.y(std::max(0.0, frame.y.low));
        svg += format("<rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\">", x + 1, std::min(y, zero),
                      std::max(width - 2, 1.0), std::abs(zero - y));
        svg += pointTitle(plot, series, i) + "</rect>";
        double top = std::min(y, zero);
        if (!series.spread.empty()) {
            top = frame.y(series.y[i] + series.spread[i]);
            svg += format("<path class=\"spread\" d=\"M%.2f %.2fV%.2f\"/>", x + width / 2, top,
                          frame.y(series.y[i] - series.spread[i]));
        }
        if (width >= 24)
            svg +=
                format("<text class=\"value\" x=\"%.2f\" y=\"%.2f\">%.3g</text>", x + width / 2, top - 4, series.y[i]);
    }
    return svg;
}

}  // namespace

std::string shortNumber(double value) { return std::isfinite(value) ? format("%.4g", value) : "-"; }

std::string plotSvg(const Plot& plot) {
    const PlotFrame frame = frameOf(plot);
    const std::string id = escapeXml(plot.id), title = escapeXml(plot.title);
    std::string svg = "<svg class=\"plot\" id=\"" + id + "\" role=\"group\" aria-label=\"" + title + "\"";
    svg += format(" viewBox=\"0 0 %g %g\">", kWidth, kHeight) + axesSvg(plot, frame);
    for (std::size_t i = 0; i < plot.series.size(); ++i) {
        const Series& series = plot.series[i];
        assert(series.x.size() == series.y.size());
        svg += "<g class=\"" + classesOf(plot, series.style) + "\" tabindex=\"0\" role=\"img\" aria-label=\"" +
               escapeXml(series.name) + "\">" + (plot.bars ? barsSvg(plot, i, frame) : linesSvg(plot, series, frame)) +
               "</g>";
    }
    return svg + "</svg>";
}

std::string legendHtml(const std::vector<Plot>& plots) {
    std::string html = "<ul class=\"legend\">";
    std::set<std::string> listed;
    for (const Plot& plot : plots)
        for (const Series& s : plot.series) {
            if (!listed.insert(s.name).second) continue;
            html +=
                "<li><svg viewBox=\"0 0 30 12\" aria-hidden=\"true\"><g class=\"" + classesOf(plot, s.style) + "\">";
            if (plot.bars) html += "<rect x=\"8\" y=\"0\" width=\"14\" height=\"12\"/>";
            if (!plot.bars && s.style.line) html += "<path class=\"line\" d=\"M0 6H30\"/>";
            if (!plot.bars && s.style.marks) html += markSvg(s.style, 15, 6, "");
            html += "</g></svg>" + escapeXml(s.name) + "</li>";
        }
    return html + "</ul>";
}

}  // namespace penumbra
