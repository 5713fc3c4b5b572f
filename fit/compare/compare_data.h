#pragma once
// Writes a comparison as JSON (schema "penumbra.compare") and as CSV with one row for each fit. They hold the figures
// of the page as numbers.
#include <string>

#include "fit/compare/compare_page.h"

namespace penumbra {

constexpr int kCompareVersion = 1;

std::string compareJson(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source);
std::string compareCsv(const Comparison& comparison);
// Both of these do the same for a comparison of transfer (schema "penumbra.compare_transfer").
std::string transferJson(const TransferComparison& comparison, const std::vector<Figure>& figures,
                         const CompareSource& source);
std::string transferCsv(const TransferComparison& comparison);

}  // namespace penumbra
