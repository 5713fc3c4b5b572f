#include "fit/report/capture_report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "formats/capture/merge_exposures.h"
#include "formats/common/warning.h"
#include "sh/light/dominant_light.h"

namespace penumbra {

namespace {

constexpr double kFewDark = 0.005, kManyHoles = 0.05;  // share of the sphere
constexpr double kMuchUncertain = 0.02;                // share of the irradiance
constexpr int kReadableCode = 16;

nlohmann::ordered_json listOf(Vec3d v) { return {v.x, v.y, v.z}; }

// Returns the reflectance that the paper would have if the light were right: R = pi L / E. 0 if no paper was measured.
Vec3d impliedReflectance(const CaptureSummary& s) {
    if (!s.paper.found()) return {};
    Vec3d out;
    for (int c = 0; c < 3; ++c)
        out[c] = s.irradiance[c] > 0 ? paperIrradiance(s.paper.radiance[c], s.irradiance[c]) : 0;
    return out;
}

// The irradiance that the paper has if it reflects what white paper does.
Vec3d irradianceOfPaper(const CaptureSummary& s) {
    constexpr double kWhite = 0.8;
    Vec3d out;
    for (int c = 0; c < 3; ++c) out[c] = paperIrradiance(s.paper.radiance[c], kWhite);
    return out;
}

void warnOfPaper(const CaptureSummary& s, double reflectance) {
    constexpr double kMinPaper = 0.6, kMaxPaper = 0.95;
    if (!s.paper.found() || (reflectance >= kMinPaper && reflectance <= kMaxPaper)) return;
    char text[320];
    std::snprintf(text, sizeof text,
                  "%s: under this light the marker's paper reflects %.2f, and white paper reflects .7 to .9: %s",
                  s.name.c_str(), reflectance,
                  reflectance > 1 ? "light is missing, or the ball's reflectance or the response is wrong"
                                  : "the paper is in a shadow, or the ball's reflectance or the response is wrong");
    reportWarning("penumbra-fit", text);
}

void describePaper(const CaptureSummary& s, Report& report) {
    if (s.paper.places == 0) return;
    const Vec3d reflectance = impliedReflectance(s);
    report.figures["paper"] = {{"radiance", listOf(s.paper.radiance)},
                               {"implied_reflectance", listOf(reflectance)},
                               {"places", s.paper.places},
                               {"clipped", s.paper.clipped},
                               {"pictures", s.paper.pictures}};
    if (!s.raised) return warnOfPaper(s, luminance(reflectance));
    report.figures["raised"] = {{"irradiance_of_paper", listOf(s.raised->wanted)},
                                {"irradiance_before", listOf(s.raised->found)},
                                {"factor", listOf(s.raised->factor)}};
    if (s.raised->nothing_to_raise)
        reportWarning("penumbra-fit", s.name +
                                          ": the paper has more light than the pictures show, and nothing is "
                                          "clipped that could have it: check the paper and the response");
}

void warn(const CaptureSummary& s, double uncertain) {
    char text[320];
    if (s.clipped > 0 && uncertain > kMuchUncertain && !s.raised) {
        std::snprintf(
            text, sizeof text,
            "%s: %.2g%% of the sphere is clipped in the shortest exposure: %.0f%% of the irradiance is only a "
            "lower bound. Take at least %.0f stops less, or give the paper",
            s.name.c_str(), 100 * s.clipped, 100 * uncertain, missingShorter(s));
        reportWarning("penumbra-fit", text);
    }
    if (const double missing = missingShare(s); missing > kMuchUncertain && missing > uncertain) {
        std::snprintf(text, sizeof text,
                      "%s: by the marker's paper, if it reflects .8, %.0f%% of its irradiance is missing in what is "
                      "clipped: take %.0f stops less, or give the paper",
                      s.name.c_str(), 100 * missing, missingShorter(s));
        reportWarning("penumbra-fit", text);
    }
    if (s.dark > kFewDark) {
        std::snprintf(text, sizeof text,
                      "%s: %.2g%% of the sphere is black in the longest exposure. Take at least %.0f stops more",
                      s.name.c_str(), 100 * s.dark, missingLonger(s));
        reportWarning("penumbra-fit", text);
    }
    if (s.holes.share > kManyHoles) {
        std::snprintf(text, sizeof text, "%s: %.1f%% of the sphere is not seen and was filled", s.name.c_str(),
                      100 * s.holes.share);
        reportWarning("penumbra-fit", text);
    }
}

}  // namespace

void measurePanorama(const Panorama& p, CaptureSummary& summary) {
    constexpr double kSphere = 4 * 3.14159265358979323846;
    for (std::size_t i = 0; i < p.radiance.size(); ++i) {
        const double share = steradiansOfRow(p, int(i / std::size_t(p.width))) / kSphere;
        if (luminance(p.uncertain[i]) > 0) summary.clipped += share;
        summary.dark += share * double(p.dark[i]);
    }
    summary.irradiance = irradianceOn(p, {0, 1, 0});
    summary.uncertain = uncertainIrradianceOn(p, {0, 1, 0});
}

double darkStops(const CameraResponse& response) {
    double dark = 0, readable = 0;
    for (const std::array<float, 256>& channel : response.exposure) {
        dark += double(channel[kDarkCode]);
        readable += double(channel[kReadableCode]);
    }
    return dark > 0 ? std::log2(readable / dark) : 2;
}

double missingShare(const CaptureSummary& s) {
    if (!s.paper.found() || !(s.clipped > 0) || s.raised) return 0;
    return std::max(0.0, 1 - luminance(s.irradiance) / luminance(irradianceOfPaper(s)));
}

double missingShorter(const CaptureSummary& s) {
    if (!(s.clipped > 0)) return 0;
    double stops = std::max(1.0, s.step);
    // The clipped light must supply the irradiance of the paper that exceeds the certain light.
    if (const double known = luminance(s.uncertain); missingShare(s) > kMuchUncertain && known > 0)
        stops = std::max(stops, std::log2((luminance(irradianceOfPaper(s)) - luminance(s.irradiance) + known) / known));
    if (s.raised)
        stops = std::max(
            {1.0, std::log2(s.raised->factor.x), std::log2(s.raised->factor.y), std::log2(s.raised->factor.z)});
    return std::ceil(stops - 1e-9);
}

double missingLonger(const CaptureSummary& s) { return s.dark > kFewDark ? std::ceil(s.dark_stops) : 0; }

double uncertainShare(const CaptureSummary& s) {
    const double all = luminance(s.irradiance);
    return all > 0 ? luminance(s.uncertain) / all : 0;
}

void printCapture(const CaptureSummary& s) {
    std::printf("%s: %zu pictures over %.1f stops cover %.2f%% of the sphere; %d hole%s filled\n", s.name.c_str(),
                s.pictures, std::log2(s.longest / s.shortest), 100 * (1 - s.holes.share), s.holes.holes,
                s.holes.holes == 1 ? "" : "s");
    std::printf("%s: irradiance on the ground %.4g %.4g %.4g, %.2g%% of it only a lower bound\n", s.name.c_str(),
                s.irradiance.x, s.irradiance.y, s.irradiance.z, 100 * uncertainShare(s));
    if (s.longest < 1 || s.shortest > 1)
        std::printf(
            "%s: its light is in units of exposures %.4g to %.4g: tell composite and view the exposure of "
            "the photographs in the same unit, or they take 1\n",
            s.name.c_str(), s.shortest, s.longest);
    if (s.clipped > 0)
        std::printf(
            "%s: %.2g%% of the sphere is clipped in the shortest exposure, which is at least %.0f stops too "
            "long\n",
            s.name.c_str(), 100 * s.clipped, missingShorter(s));
    if (s.paper.places == 0) return;
    const Vec3d reflectance = impliedReflectance(s);
    if (s.paper.found())
        std::printf("%s: under this light the paper reflects %.2f %.2f %.2f\n", s.name.c_str(), reflectance.x,
                    reflectance.y, reflectance.z);
    if (s.raised)
        std::printf(
            "%s: the paper has the irradiance %.4g %.4g %.4g, the light gave %.4g %.4g %.4g; clipped pixels "
            "raised by %.3g %.3g %.3g\n",
            s.name.c_str(), s.raised->wanted.x, s.raised->wanted.y, s.raised->wanted.z, s.raised->found.x,
            s.raised->found.y, s.raised->found.z, s.raised->factor.x, s.raised->factor.y, s.raised->factor.z);
}

void describeCapture(const CaptureSummary& s, Report& report) {
    const double uncertain = uncertainShare(s);
    report.figures["pictures"] = s.pictures;
    report.figures["exposures"] = {{"shortest", s.shortest}, {"longest", s.longest}};
    report.figures["covered_share"] = 1 - s.holes.share;
    report.figures["holes"] = s.holes.holes;
    report.figures["largest_hole"] = s.holes.largest;
    report.figures["clipped_share"] = s.clipped;
    report.figures["dark_share"] = s.dark;
    report.figures["uncertain_irradiance"] = uncertain;
    report.figures["missing_by_paper"] = missingShare(s);
    report.figures["irradiance"] = listOf(s.irradiance);
    report.figures["missing_stops"] = {{"shorter", missingShorter(s)}, {"longer", missingLonger(s)}};
    describePaper(s, report);
    warn(s, uncertain);
}

}  // namespace penumbra
