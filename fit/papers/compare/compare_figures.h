#pragma once
// The figures of a comparison. Each has plots, the table beside them and a text that says what they show.
#include <optional>
#include <string>
#include <vector>

#include "fit/papers/compare/compare_grid.h"
#include "fit/papers/compare/eigenvalue_decay.h"
#include "fit/papers/compare/feature_vectors.h"
#include "fit/papers/compare/light_pairs.h"
#include "fit/papers/compare/lobe_models.h"
#include "fit/papers/compare/normal_table.h"
#include "fit/papers/compare/plot_svg.h"

namespace penumbra {

struct Comparison {
    CompareOptions options;
    int file_order = 0;
    std::vector<CompareFit> fits;  // the fits of makeGrid()
    std::vector<EigenvalueDecay> inputs, outputs;
    std::optional<JointSweep> sweep;
    std::optional<LobeComparison> lobes;  // set where the options ask for it
    std::vector<VectorFit> vectors = {};
    std::vector<NormalTable> normals = {};
    std::vector<LightPair> lights = {};
};
const CompareFit* findFit(const Comparison& comparison, const FitOptions& options);  // null when it is not in the grid

struct Table {
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows{};
};

struct Figure {
    std::string id, title;  // id is its anchor on the page
    std::string source;     // the figure of the paper that it repeats
    std::string finding{};  // one sentence, made from the data
    std::string method{};   // the fixed parameters, and how it was measured
    std::vector<Plot> plots{};
    Table table{};
    std::string pictures{};  // HTML that stands before the plots
};

// Figures in compare_sweeps.cpp: fits that differ in a number.
Figure clustersFigure(const Comparison& comparison);
Figure varianceFigure(const Comparison& comparison);
Figure costFigure(const Comparison& comparison);
// Figures in compare_variants.cpp: fits that differ in kind.
Table summaryTable(const Comparison& comparison);  // errors, size and times of every model at the reference
std::string modelsFinding(const Comparison& comparison);
Figure modelsFigure(const Comparison& comparison);
Figure conventionsFigure(const Comparison& comparison);
Figure cosineFigure(const Comparison& comparison);
Figure framesFigure(const Comparison& comparison);
// Figures in compare_small.cpp: what Nowrouzezahrai 2009 tells beside its models, and lobes of visibility.
Figure vectorsFigure(const Comparison& comparison);
Figure normalTableFigure(const Comparison& comparison);
Figure lightsFigure(const Comparison& comparison);
Figure lobesFigure(const Comparison& comparison);
// Figures in compare_motion.cpp: the poses and the visibility themselves.
Figure jointFigure(const Comparison& comparison);
Figure eigenvaluesFigure(const Comparison& comparison);

// Returns all figures that the data allow, in the order of the page.
std::vector<Figure> compareFigures(const Comparison& comparison);

}  // namespace penumbra
