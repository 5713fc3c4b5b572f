#pragma once
// Numbers that a pose depends on beside the mesh (the centre of a ball, the wind), frame by frame: CSV.
//
// The first line names the columns: first `frame` (number of the frame in a point cache, from 0) or `time` (seconds in
// the clip), then any inputs; one of the columns may be `clip`, the clip that a line is of. Columns NAME.x, NAME.y and
// NAME.z, side by side and all three, are a point of the model frame. Fields may be "quoted".
#include <filesystem>
#include <string>
#include <vector>

namespace penumbra {

struct InputTable {
    std::vector<std::string> names;  // [X], unique
    bool by_frame = false;           // keys are frame numbers, else seconds
    std::vector<std::string> clips;  // [R]; empty without such a column
    std::vector<double> keys;        // [R] >= 0; whole numbers of frames
    std::vector<double> values;      // [R, X]
    std::vector<std::size_t> lines;  // [R] where each row stands, from 1
};

// IoError; InvalidInput that names file, line and column.
InputTable readInputTable(const std::filesystem::path& path);

}  // namespace penumbra
