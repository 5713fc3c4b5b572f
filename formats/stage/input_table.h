#pragma once
// Reads CSV tables of numbers that a pose depends on besides the mesh (the center of a ball, the wind), frame by
// frame.
//
// The first line names the columns. The first column is `frame` (number of the frame in a point cache, from 0) or
// `time` (seconds in the clip); any inputs follow. One column may be `clip`, the clip that a line belongs to. Columns
// NAME.x, NAME.y and NAME.z, side by side and all three, are a point of the model frame. Fields may be "quoted".
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct InputTable {
    std::vector<std::string> names;  // [X], unique
    bool by_frame = false;           // true: keys are frame numbers; false: seconds
    std::vector<std::string> clips;  // [R]; empty when there is no such column
    std::vector<double> keys;        // [R] >= 0; frame numbers are whole
    std::vector<double> values;      // [R, X]
    std::vector<std::size_t> lines;  // [R] the line of each row, from 1
};

// Throws IoError, and InvalidInput, which names file, line and column.
InputTable readInputTable(const std::filesystem::path& path);

}  // namespace penumbra
