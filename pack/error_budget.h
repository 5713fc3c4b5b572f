#pragma once
// Tells where the error of an asset comes from, stage by stage, over one set of frames.
#include <string>
#include <vector>

#include "pack/check_asset.h"

namespace penumbra {

struct BudgetRow {
    std::string name;
    double relative = 0, rms_v = 0;  // NaN: not measured
    std::string option;              // the option that would measure it
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
// local model           the difference of that to the model's local visibility times the far parts: regression, output
//                       PCA and quantisation of the local part, as they show in the final numbers
// without residual      the model's local visibility times the far parts; what the total has less is the residual's
// Without the unpacked model, output PCA is that of the stored components, and regression is the rest of the total.
std::vector<BudgetRow> errorBudget(const ErrorFigures& figures);

}  // namespace penumbra
