#pragma once
// A comparison as files: one self-contained HTML page, JSON with everything that the page shows, CSV with a row a fit.
#include <string>

#include "fit/compare/compare_figures.h"

namespace penumbra {

// What the page says about where its figures come from.
struct CompareSource {
    std::string file;  // name of the visibility file, without folders
    std::size_t vertices = 0, joints = 0;
    std::size_t train_frames = 0, held_out_frames = 0;
    std::vector<std::string> train_clips, held_out_clips;
    Provenance provenance;
};

std::string comparePage(const Comparison& comparison, const std::vector<Figure>& figures, const CompareSource& source);

}  // namespace penumbra
