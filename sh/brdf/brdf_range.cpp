#include "sh/brdf/brdf_range.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "sh/brdf/mirror_lobe.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr std::string_view kDots = "..";

// Returns "NAME:key=END,...", where END is one end of the range that has its dots at `dots`.
std::string withEnd(std::string_view text, std::size_t dots, bool most) {
    const std::size_t first = text.rfind('=', dots) + 1, last = std::min(text.find(',', dots), text.size());
    const std::string_view end =
        most ? text.substr(dots + kDots.size(), last - dots - kDots.size()) : text.substr(first, dots - first);
    return std::string(text.substr(0, first)) + std::string(end) + std::string(text.substr(last));
}

}  // namespace

std::optional<BrdfRange> parseBrdfRange(std::string_view text) {
    const std::size_t dots = text.find(kDots);
    if (dots == std::string_view::npos || text.find('=') > dots) return std::nullopt;
    if (text.find(kDots, dots + kDots.size()) != std::string_view::npos)
        throw std::invalid_argument("only one parameter has a range, not two as in '" + std::string(text) + "'");
    const BrdfSpec low = parseBrdf(withEnd(text, dots, false)), high = parseBrdf(withEnd(text, dots, true));
    if (low.color != high.color) throw std::invalid_argument(low.name + " color has no range");
    const BrdfModel model = modelOf(low);
    if (isMirrorLobe(model)) throw std::invalid_argument(low.name + " has no tables: its parameter needs no range");
    BrdfRange range{low};
    for (std::size_t p = 0; p < parametersOf(model).size(); ++p) {
        const char* const name = parametersOf(model)[p].name;
        const double least = low.parameters.at(name), most = high.parameters.at(name);
        if (least == most) continue;
        range.parameter = p, range.least = least, range.most = most;
    }
    const std::string name = parametersOf(model)[range.parameter].name;
    if (low == high || range.least > range.most)
        throw std::invalid_argument(low.name + " " + name + ": the first end of its range must be below the second");
    range.spec = specAt(range, (range.least + range.most) / 2);
    return range;
}

BrdfSpec specAt(const BrdfRange& range, double value) {
    BrdfSpec spec = range.spec;
    spec.parameters[parametersOf(modelOf(spec))[range.parameter].name] = value;
    return spec;
}

std::string toString(const BrdfRange& range) {
    std::string text = toString(range.spec);
    const std::string key = std::string(parametersOf(modelOf(range.spec))[range.parameter].name) + "=";
    const std::size_t first = text.find(key) + key.size(), last = std::min(text.find(',', first), text.size());
    return text.substr(0, first) + shortest(range.least) + std::string(kDots) + shortest(range.most) +
           text.substr(last);
}

}  // namespace penumbra
