#pragma once
// Writes a comparison as one self-contained HTML page, and its figures as numbers: as JSON (schemas "penumbra.compare"
// and "penumbra.compare_transfer") and as CSV with one row for each fit.
#include <string>

#include "fit/papers/compare/compare_figures.h"
#include "fit/papers/compare/compare_transfer.h"

namespace penumbra {

// The source of the figures, as the page tells it.
struct CompareSource {
    std::string file;  // name of the visibility file, without its folders
    std::size_t vertices = 0, joints = 0;
    std::size_t train_frames = 0, held_out_frames = 0;
    std::vector<std::string> train_clips, held_out_clips;
    Provenance provenance;
};

// The page of a comparison of transfer. `picture` is the name of the picture beside it, and `bounces` that of figure 7,
// if there is one.
std::string transferPage(const TransferComparison& comparison, const std::vector<Figure>& figures,
                         const CompareSource& source, const std::string& picture, const std::string& bounces);
std::string comparePage(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source);

constexpr int kCompareVersion = 1;

std::string compareJson(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source);
std::string compareCsv(const Comparison& comparison);
std::string transferJson(const TransferComparison& comparison, const std::vector<Figure>& figures,
                         const CompareSource& source);
std::string transferCsv(const TransferComparison& comparison);

}  // namespace penumbra
