#include "fit/compare/compare_figures.h"

namespace penumbra {

const CompareFit* findFit(const Comparison& comparison, const FitOptions& options) {
    for (const CompareFit& fit : comparison.fits)
        if (sameFit(fit.options, options)) return &fit;
    return nullptr;
}

std::vector<Figure> compareFigures(const Comparison& comparison) {
    std::vector<Figure> figures{modelsFigure(comparison), clustersFigure(comparison), varianceFigure(comparison)};
    if (!comparison.vectors.empty()) figures.push_back(vectorsFigure(comparison));
    if (comparison.sweep) figures.push_back(jointFigure(comparison));
    if (paperConvention(comparison.options, comparison.file_order).order < comparison.file_order)
        figures.push_back(cosineFigure(comparison));
    if (comparison.lobes) figures.push_back(lobesFigure(comparison));
    figures.push_back(framesFigure(comparison));
    if (!comparison.normals.empty()) figures.push_back(normalTableFigure(comparison));
    figures.push_back(conventionsFigure(comparison));
    figures.push_back(eigenvaluesFigure(comparison));
    if (!comparison.lights.empty()) figures.push_back(lightsFigure(comparison));
    figures.push_back(costFigure(comparison));
    return figures;
}

}  // namespace penumbra
