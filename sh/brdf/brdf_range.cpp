#include "sh/brdf/brdf_range.h"

#include <algorithm>
#include <stdexcept>

#include "sh/brdf/mirror_lobe.h"
#include "sh/brdf/principled.h"
#include "sh/key_values.h"

namespace penumbra {

namespace {

constexpr std::string_view kDots = "..";

// Returns the text with one end of the range that has its dots at `dots`. `last` is where the range ends.
std::string withEnd(std::string_view text, std::size_t dots, std::size_t last, bool most) {
    const std::size_t first = text.rfind('=', dots) + 1;
    const std::string_view end =
        most ? text.substr(dots + kDots.size(), last - dots - kDots.size()) : text.substr(first, dots - first);
    return std::string(text.substr(0, first)) + std::string(end) + std::string(text.substr(last));
}

// Returns where the item ends that `at` is in: at a comma, or at the end of its term.
std::size_t endOfItem(std::string_view text, std::size_t at) {
    std::size_t end = 0;
    for (const std::string_view term : splitTerms(text)) {
        end = std::size_t(term.data() - text.data()) + term.size();
        if (at < end) break;
    }
    return std::min(text.find(',', at), end);
}

// The term and the key that hold the range.
struct Owner {
    std::size_t term = 0;  // index among the terms of the text
    std::string model, key;
    std::string words() const { return model + " " + key; }
};

Owner ownerOf(std::string_view text, std::size_t dots) {
    const std::size_t last = text.rfind('=', dots), first = text.find_last_of(":,", last) + 1;
    Owner owner{0, "", std::string(text.substr(first, last - first))};
    const std::vector<std::string_view> terms = splitTerms(text);
    while (std::size_t(terms[owner.term].data() - text.data()) + terms[owner.term].size() <= dots) ++owner.term;
    owner.model = terms[owner.term].substr(0, terms[owner.term].find(':'));
    return owner;
}

// Returns the name of the sum with the range in place of the owner's value.
std::string nameWithRange(const BrdfRange& range, const Owner& owner) {
    std::string name;
    const std::vector<std::string_view> terms = splitTerms(range.sum.name);
    for (std::size_t t = 0; t < terms.size(); ++t) {
        std::string term(terms[t]);
        if (t == owner.term) {
            const std::size_t first = term.find(owner.key + "=") + owner.key.size() + 1,
                              last = std::min(term.find(',', first), term.size());
            term.replace(first, last - first, shortest(range.least) + std::string(kDots) + shortest(range.most));
        }
        name += (t > 0 ? "+" : "") + term;
    }
    return name;
}

// Finds which parameter differs, and in which terms.
void findChange(const BrdfSum& low, const BrdfSum& high, const Owner& owner, BrdfRange& range) {
    range.terms = 0;
    bool same_shape = low.terms.size() == high.terms.size() && low.emission == high.emission;
    for (std::size_t t = 0; same_shape && t < low.terms.size(); ++t) {
        const BrdfSpec &a = low.terms[t], &b = high.terms[t];
        same_shape = a.name == b.name && a.color == b.color;
        const std::span<const BrdfParameter> known = parametersOf(modelOf(a));
        for (std::size_t p = 0; same_shape && p < known.size(); ++p) {
            const double least = a.parameters.at(known[p].name), most = b.parameters.at(known[p].name);
            if (least == most) continue;
            same_shape = range.terms == 0 || (range.parameter == p && range.least == least && range.most == most);
            range.parameter = p, range.least = least, range.most = most;
            range.terms |= std::uint8_t(1u << t);
        }
    }
    if (!same_shape)
        throw std::invalid_argument(owner.words() + " has no range" +
                                    (owner.model == kPrincipledName ? ": only its roughness may have one" : ""));
    if (range.terms == 0 || range.least > range.most)
        throw std::invalid_argument(owner.words() + ": the first end of its range must be below the second");
}

}  // namespace

std::optional<BrdfRange> parseBrdfRange(std::string_view text) {
    const std::size_t dots = text.find(kDots);
    if (dots == std::string_view::npos || text.find('=') > dots) return std::nullopt;
    if (text.find(kDots, dots + kDots.size()) != std::string_view::npos)
        throw std::invalid_argument("only one parameter has a range, not two as in '" + std::string(text) + "'");
    const std::size_t last = endOfItem(text, dots);
    const BrdfSum low = parseBrdfSum(withEnd(text, dots, last, false)),
                  high = parseBrdfSum(withEnd(text, dots, last, true));
    for (const BrdfSpec& term : low.terms)
        if (isMirrorLobe(modelOf(term)))
            throw std::invalid_argument(term.name + " has no tables: its parameter needs no range");
    BrdfRange range{.sum = low};
    const Owner owner = ownerOf(text, dots);
    findChange(low, high, owner, range);
    range.sum = parseBrdfSum(std::string(text.substr(0, text.rfind('=', dots) + 1)) +
                             shortest((range.least + range.most) / 2) + std::string(text.substr(last)));
    range.name = nameWithRange(range, owner);
    return range;
}

BrdfSum sumAt(const BrdfRange& range, double value) {
    BrdfSum sum = range.sum;
    for (std::size_t t = 0; t < sum.terms.size(); ++t)
        if (range.terms >> t & 1)
            sum.terms[t].parameters[parametersOf(modelOf(sum.terms[t]))[range.parameter].name] = value;
    return sum;
}

}  // namespace penumbra
