#include "sh/brdf/brdf_sum.h"

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "sh/brdf/membrane.h"
#include "sh/brdf/mirror_lobe.h"
#include "sh/brdf/principled.h"

namespace penumbra {

std::vector<std::string_view> splitTerms(std::string_view text) {
    std::vector<std::string_view> terms;
    std::size_t first = 0;
    for (std::size_t at = 0; at < text.size(); ++at) {
        const bool starts_name = at + 1 < text.size() && std::isalpha(static_cast<unsigned char>(text[at + 1]));
        if (text[at] != '+' || !starts_name) continue;
        terms.push_back(text.substr(first, at - first));
        first = at + 1;
    }
    terms.push_back(text.substr(first));
    return terms;
}

namespace {

std::string_view modelNameOf(std::string_view term) { return term.substr(0, term.find(':')); }

// Adds a term with what it is made of.
void addTerm(std::string_view term, BrdfSum& sum) {
    if (modelNameOf(term) != kPrincipledName) {
        sum.terms.push_back(parseBrdf(term));
        sum.name += (sum.name.empty() ? "" : "+") + toString(sum.terms.back());
        return;
    }
    const std::size_t colon = term.find(':');
    if (colon + 1 == term.size()) throw std::invalid_argument("expected key=value after '" + std::string(term) + "'");
    const Principled material = parsePrincipled(colon == std::string_view::npos ? "" : term.substr(colon + 1));
    for (BrdfSpec& part : principledTerms(material)) sum.terms.push_back(std::move(part));
    sum.emission += material.emission;
    sum.name += (sum.name.empty() ? "" : "+") + toString(material);
}

}  // namespace

BrdfSum parseBrdfSum(std::string_view text) {
    BrdfSum sum;
    const std::vector<std::string_view> terms = splitTerms(text);
    for (const std::string_view term : terms) {
        if (terms.size() > 1 && modelNameOf(term) == kMembraneName)
            throw std::invalid_argument("a membrane cannot be part of a sum");
        addTerm(term, sum);
    }
    if (sum.terms.size() > std::size_t(kMaxBrdfLobes))
        throw std::invalid_argument("a sum has " + std::to_string(kMaxBrdfLobes) + " lobes at most, not " +
                                    std::to_string(sum.terms.size()) + " as '" + std::string(text) +
                                    "'; principled has three");
    for (const BrdfSpec& term : sum.terms) {
        if (sum.terms.size() == 1) break;
        if (isMirrorLobe(modelOf(term)))
            throw std::invalid_argument(term.name + " has no table, so it cannot be part of a sum");
        // Where suns are on, a mirror takes the light's picture in place of all other light.
        if (modelOf(term) == BrdfModel::kMirror)
            throw std::invalid_argument("a mirror cannot be part of a sum: use ggx:alpha=0.01 instead");
    }
    return sum;
}

std::vector<BrdfLobe> lobesOf(const BrdfSum& sum) {
    std::vector<BrdfLobe> lobes;
    for (const BrdfSpec& term : sum.terms) lobes.push_back(lobeOf(term));
    return lobes;
}

RgbBrdf sumBrdf(const BrdfSum& sum) {
    if (sum.terms.size() == 1) {
        RgbBrdf one = rgbBrdf(sum.terms.front());
        one.name = sum.name;
        return one;
    }
    RgbBrdf all{sum.name, BrdfSymmetry::kIsotropic, nullptr};
    struct Term {
        BrdfFunction function;
        Vec3d color;
    };
    std::vector<Term> terms;
    for (const BrdfSpec& spec : sum.terms) {
        terms.push_back({brdfFunction(spec), spec.color});
        all.symmetry = std::max(all.symmetry, rgbBrdf(spec).symmetry);
    }
    all.eval = [terms](Vec3d wi, Vec3d wo) {
        Vec3d f;
        for (const Term& term : terms) f += term.color * term.function(wi, wo);
        return f;
    };
    return all;
}

}  // namespace penumbra
