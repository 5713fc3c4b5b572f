#pragma once
// Tells where the error of an asset comes from, stage by stage, over one set of frames.
#include <string>
#include <vector>

#include "pack/check/check_asset.h"

namespace penumbra {

struct BudgetRow {
    std::string name;
    double relative = 0, rms_v = 0;  // NaN: not measured
    std::string option;              // option that would measure it, or ""
};

// Returns these rows:
// bake noise            noise of the truth that all is measured against (output PCA and regression contain it too)
// SH truncation         visibility outside the convention's bands; orthogonal to everything below
// output PCA            truth outside the span of the model's components
// regression            other scores than the best: unpacked model^2 = output PCA^2 + regression^2
// rank and quantisation packed against unpacked numbers
// total                 packed against truth: nearly unpacked model^2 + rank and quantisation^2
// against all bands     total^2 + SH truncation^2
// Of a composed model there are these in the place of output PCA and regression:
// true local x far      the truth's local visibility times the far parts: fields, products of SH and the split itself
// local PCA             the difference of that to the same product with the truth's local visibility projected on the
//                       span of the local components
// local regression      the difference of that to the model's local visibility times the far parts
// local model           both steps at once. The two are orthogonal in the local numbers, but not after the product:
// local
//                       model^2 is local PCA^2 + local regression^2 + twice their correlation
// Near parts hide what the truth's local visibility has and the model's has not: the former is multiplied by far parts
// alone, the latter by near parts too. Local PCA and local regression mean nothing then and are NaN.
// without residual      the error of the model's local visibility times the far parts, which the residual corrects
// The local rows and the one without residual are of the unpacked model, too. They do not add up to the total.
// Without the unpacked model, all rows are of the stored components. Regression is the rest of the total then.
std::vector<BudgetRow> errorBudget(const ErrorFigures& figures);

}  // namespace penumbra
