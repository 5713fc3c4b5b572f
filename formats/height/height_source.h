#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "sh/height/height_field.h"

namespace penumbra {

// Where heights come from, and what their numbers mean: metres = offset + scale * number.
struct HeightSource {
    std::string at;                 // where a file says so, for messages; may be empty
    std::filesystem::path file;     // or, if empty:
    std::string analytic;           // AnalyticHeights
    int rows = 256, columns = 256;  // size of the analytic field
    std::string array;              // array in an .npz ("": the only one with two or three axes), or channel of an .exr
    double cell_rows = 1, cell_columns = 1;  // metres between neighbouring points
    double scale = 1, offset = 0;
    HeightBorder border = HeightBorder::kClamped;
    std::optional<double> no_data = {};  // a number of the file that stands for nothing, as NaN does
    std::optional<double> fill = {};     // metres that stand in its place; unset: InvalidInput
    double fps = 25;                     // frames a second of a sequence
};

}  // namespace penumbra
