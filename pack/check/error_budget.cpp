// Splits the error of an asset by its sources. Stages work on one another's results, so their errors cannot be measured
// alone. Each row compares numbers in one common unit. Rows that are orthogonal add up in squares, which gives the rows
// that cannot be measured: the regression is the rest of the unpacked model's error beside the output PCA.
// docs/formulas.md, section 5, explains each row.
#include "pack/check/error_budget.h"

#include <algorithm>
#include <cmath>

namespace penumbra {

namespace {

std::vector<BudgetRow> composedBudget(const ErrorFigures& figures) {
    const char* const local_spanned =
        std::isnan(figures.split) ? "a truth with local moments" : "a model without near parts";
    return {{"bake noise", figures.bake_noise, 0, "a second bake"},
            {"SH truncation", figures.sh_truncation, 0, ""},
            {"true local x far", figures.split, 0, "a truth with local moments"},
            {"true local x far by fields", figures.far_by_fields, 0, ""},
            {"true local x far by rays", figures.far_by_rays, 0, ""},
            {"local PCA", figures.local_truncation, 0, local_spanned},
            {"local regression", figures.local_regression, 0, local_spanned},
            {"local model", figures.local, 0, "a truth with local moments"},
            {"without residual", figures.without_residual, 0, ""},
            {"unpacked model", figures.unpacked_error, 0, "the model file"},
            {"rank and quantisation", figures.packing, 0, "the model file"},
            {"total", figures.relative_error, 0, ""},
            {"against all bands", std::hypot(figures.relative_error, figures.sh_truncation), 0, ""}};
}

}  // namespace

std::vector<BudgetRow> errorBudget(const ErrorFigures& figures) {
    if (figures.composed) {
        std::vector<BudgetRow> rows = composedBudget(figures);
        for (BudgetRow& row : rows) row.rms_v = row.relative * figures.signal_rms_v;
        return rows;
    }
    const bool unpacked = !std::isnan(figures.packing);
    const double model = figures.unpacked_error, pca = figures.unpacked_truncation;
    std::vector<BudgetRow> rows = {
        {"bake noise", figures.bake_noise, 0, "a second bake"},
        {"SH truncation", figures.sh_truncation, 0, ""},
        {"output PCA", unpacked ? pca : figures.truncation, 0, ""},
        {"regression", unpacked ? std::sqrt(std::max(model * model - pca * pca, 0.0)) : figures.regression, 0, ""},
        {"unpacked model", model, 0, "the model file"},
        {"rank and quantisation", figures.packing, 0, "the model file"},
        {"total", figures.relative_error, 0, ""},
        {"against all bands", std::hypot(figures.relative_error, figures.sh_truncation), 0, ""}};
    for (BudgetRow& row : rows) row.rms_v = row.relative * figures.signal_rms_v;
    return rows;
}

}  // namespace penumbra
