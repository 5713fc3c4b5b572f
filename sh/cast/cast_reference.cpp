#include "sh/cast/cast_reference.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "sh/far/far_visibility.h"
#include "sh/mirrored_product.h"

namespace penumbra {

namespace {

// The sphere as it counts from `position`: (r / 2d)^2 grows from 0 at fade.least to its own value at fade.full.
CasterSphereD fadedSphere(const CasterSphere& sphere, Vec3 position, const CastFade& fade) {
    CasterSphereD out{toDouble(sphere.center), sphere.radius};
    if (!(fade.full > 0)) return out;
    const double half = 0.5 * out.radius / std::max(length(out.center - toDouble(position)), 1e-6);
    const double weight =
        std::clamp((half * half - double(fade.least)) / (double(fade.full) - double(fade.least)), 0.0, 1.0);
    out.radius *= std::sqrt(weight);
    return out;
}

}  // namespace

CastExponential parseCastExponential(std::string_view word) {
    if (word == "hyb-ps2") return {};
    if (word == "hyb-ol") return {{ExpMethod::kHybOl}};
    if (word == "ol") return {{ExpMethod::kOl}};
    if (word == "chain") return {{}, true};
    CastExponential series{{ExpMethod::kPs}};
    if (word.starts_with("ps-")) {
        const char* const end = word.data() + word.size();
        const auto [next, problem] = std::from_chars(word.data() + 3, end, series.options.terms);
        if (problem == std::errc() && next == end && series.options.terms >= 1 &&
            series.options.terms <= kMaxSeriesTerms)
            return series;
    }
    throw std::invalid_argument("must be hyb-ps2, hyb-ol, ps-K with K from 1 to " + std::to_string(kMaxSeriesTerms) +
                                ", ol or chain, not " + std::string(word));
}

std::string nameOf(const CastExponential& exponential) {
    if (exponential.chain) return "chain";
    switch (exponential.options.method) {
        case ExpMethod::kHybOl:
            return "hyb-ol";
        case ExpMethod::kPs:
            return "ps-" + std::to_string(exponential.options.terms);
        case ExpMethod::kOl:
            return "ol";
        default:
            return "hyb-ps2";
    }
}

void castReference(const CastExponential& exponential, int order, std::span<const CasterSphere> spheres, Vec3 position,
                   const CastFade& fade, std::span<double> out) {
    std::vector<CasterSphereD> faded;
    for (const CasterSphere& sphere : spheres)
        if (const CasterSphereD one = fadedSphere(sphere, position, fade); one.radius > 0) faded.push_back(one);
    if (exponential.chain) {
        std::vector<Cap> caps;
        for (const CasterSphereD& sphere : faded)
            if (const Cap cap = capOf(sphere, toDouble(position)); cap.angle > 0) caps.push_back(cap);
        return productChain(order, caps, out);
    }
    netLog(capLogTableD(order), faded, toDouble(position), out);
    expOfLog(expTablesD(order), exponential.options, out, out);
}

void castMirroredReference(const CastExponential& exponential, std::span<const CasterSphere> spheres,
                           const CastPoints& points, const CastFade& fade, std::span<float> out) {
    assert(out.size() == points.positions.size() * kMirroredCast);
    std::vector<CasterSphere> local(spheres.begin(), spheres.end());
    std::array<double, coefficientCount(kCastOrder)> v;
    std::array<float, coefficientCount(kFieldOrder)> floats{};  // the bands above kCastOrder stay 0
    for (std::size_t r = 0; r < points.positions.size(); ++r) {
        const Vec3 n = points.normals[r], t = points.tangents[r], b = cross(n, t);
        for (std::size_t s = 0; s < spheres.size(); ++s) {
            const Vec3 way = spheres[s].center - points.positions[r];
            local[s].center = {dot(way, t), dot(way, b), dot(way, n)};
        }
        castReference(exponential, kCastOrder, local, {}, fade, v);
        std::copy(v.begin(), v.end(), floats.begin());
        mirrorAtHorizon(kFieldOrder, floats, out.subspan(r * kMirroredCast, kMirroredCast));
    }
}

}  // namespace penumbra
