#pragma once
// The figures of a comparison: what is plotted, the table beside it and what it shows, in words.
#include <string>
#include <vector>

#include "fit/compare_grid.h"
#include "fit/plot_svg.h"

namespace penumbra {

struct Table {
    std::vector<std::string> columns;
    std::vector<std::vector<std::string>> rows;
};

struct Figure {
    std::string id, title;  // id: its anchor on the page
    std::string source;     // which figure of which paper
    std::string finding;    // one sentence, from the data
    std::string method;     // what is held fixed and how it was measured
    std::vector<Plot> plots;
    Table table;
};

struct Comparison {
    CompareOptions options;
    std::vector<CompareFit> fits;  // of makeGrid()
    int file_order = 0;
};

const CompareFit* findFit(const Comparison& comparison, const FitOptions& options);  // null: not in the grid

Figure clustersFigure(const Comparison& comparison);
std::vector<Figure> compareFigures(const Comparison& comparison);

}  // namespace penumbra
