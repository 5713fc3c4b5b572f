// Fitted materials in their compact forms. Each takes the form that its BRDF promises and stays as accurate as before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "fit/reflectance/fit_brdf.h"
#include "fit/reflectance/shading_error.h"
#include "sh/brdf/brdf.h"
#include "sh/brdf/slice_form.h"
#include "tests/accuracy/extent.h"
#include "tests/difference.h"

namespace penumbra::test_slice_form_table {
namespace {

// Turns [J^2, E, 3] into [3, J^2, E] in single precision, and back.
std::vector<float> byChannel(const std::vector<double>& slices) {
    std::vector<float> out(slices.size());
    for (std::size_t i = 0; i < slices.size(); ++i) out[i % 3 * (slices.size() / 3) + i / 3] = float(slices[i]);
    return out;
}
std::vector<double> byEntry(const std::vector<float>& channels) {
    std::vector<double> out(channels.size());
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = channels[i % 3 * (out.size() / 3) + i / 3];
    return out;
}

// A lobe turned about the normal, which has no mirror planes at x = 0 and y = 0.
RgbBrdf turnedWard() {
    const RgbBrdf straight = rgbBrdf(parseBrdf("ward-gmd:ax=0.2,ay=0.5"));
    const auto turned = [](Vec3d w) {
        return Vec3d{std::sqrt(0.75) * w.x + 0.5 * w.y, std::sqrt(0.75) * w.y - 0.5 * w.x, w.z};
    };
    return {"turned", BrdfSymmetry::kGeneral,
            [=](Vec3d wi, Vec3d wo) { return straight.eval(turned(wi), turned(wo)); }};
}

struct Case {
    RgbBrdf brdf;
    SliceForm form;
    bool always;  // the unit test has one case for each form
};

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const char* text : {"ggx:alpha=0.3,color=1/0.5/0.2", "lambert", "phong:exponent=50", "ggx"})
        all.push_back({rgbBrdf(parseBrdf(text)), SliceForm::kIsotropic, all.empty()});
    all.push_back({rgbBrdf(parseBrdf("ward-gmd")), SliceForm::kOrthotropic, true});
    all.push_back({rgbBrdf(parseBrdf("ashikhmin-shirley")), SliceForm::kOrthotropic, false});
    all.push_back({turnedWard(), SliceForm::kGeneral, true});
    // Only its values say that this BRDF is isotropic.
    RgbBrdf unsaid = rgbBrdf(parseBrdf("ggx"));
    unsaid.symmetry = BrdfSymmetry::kGeneral;
    all.push_back({unsaid, SliceForm::kIsotropic, false});
    return all;
}

TEST(SliceForm, FittedMaterialsKeepTheirShadingError) {
    const ShadingTest test = makeShadingTest(referenceScenes(), 2);
    const Convention d5 = parseConvention("D5");
    for (const Case& each : cases()) {
        if (!every_row && !each.always) continue;
        const BrdfFile brdf = fitBrdf(each.brdf, {}, 2);
        const int j = brdf.slice_order, view = brdf.view_order;
        const std::vector<float> slices = byChannel(brdf.slices);
        const SliceForm form = mostCompactForm(j, view, slices);
        EXPECT_STREQ(nameOf(form), nameOf(each.form)) << each.brdf.name;
        const std::vector<float> kept = expandSlices(form, j, view, compactSlices(form, j, view, slices));
        const double change = largestDifference(kept, slices) / largestMagnitude(slices);
        EXPECT_LE(change, kFormTolerance) << each.brdf.name;
        const std::vector<double> truth = bruteForceRadiance(test, each.brdf, 2);
        const auto errorOf = [&](const std::vector<double>& c) {
            return shadingError({test, truth}, d5, slicesOfViews(test.scenes.views, c, brdf.even_index), j);
        };
        const double before = errorOf(brdf.slices), after = errorOf(byEntry(kept));
        std::printf("%-32s %-11s entries change by %.1e of the largest, shading error %.4f by %.1e\n",
                    each.brdf.name.c_str(), nameOf(form), change, before, after - before);
        EXPECT_NEAR(after, before, 1e-4) << each.brdf.name;
    }
}

}  // namespace
}  // namespace penumbra::test_slice_form_table
