#pragma once
// --inputs FILE.csv: numbers that join the pose of every frame (formats/stage/input_table.h).
#include "bake/bake_source.h"
#include "formats/stage/input_table.h"

namespace penumbra {

struct ExtraInputs {
    std::string file;                // for messages
    std::vector<std::string> names;  // [X]; none: no inputs
    bool by_frame = false;           // the table counts frames of a cache, not seconds
    struct Rows {
        std::string clip;                 // the others are [R], by ascending time
        std::vector<double> times;        // seconds
        std::vector<double> keys;         // as in the table
        std::vector<std::size_t> lines;   // of the table, from 1
        std::vector<double> values;       // [R, X]
        std::vector<double> frame_times;  // of the clip's frames in a cache, seconds
    };
    std::vector<Rows> of_clip;  // of each clip of the source; one of a source without clips
};

// The table's rows at their times in the clips of `source`. InvalidInput, which names the line, for clips and frames
// that the source has not, rows out of order, and rows without a clip where the source has several.
ExtraInputs placeInputs(const InputTable& table, const std::string& file, const BakeSource& source);

// The X numbers at a time of a clip of the source (-1: at rest): of the row there (within 1e-6 s), else linear between
// the rows before and after. InvalidInput when there is no such row: it says which frame and which line is the nearest.
std::vector<float> inputsAt(const ExtraInputs& inputs, int clip, double time);

}  // namespace penumbra
