#pragma once
// Numbers of --inputs FILE.csv that join the pose of every frame (formats/stage/input_table.h).
#include "bake/source/bake_source.h"
#include "formats/stage/input_table.h"

namespace penumbra {

struct ExtraInputs {
    std::string file;                // for messages
    std::vector<std::string> names;  // [X]; empty: no inputs
    bool by_frame = false;           // the table counts frames of a cache instead of seconds
    struct Rows {
        std::string clip;                 // name of the clip; the other members are [R], by ascending time
        std::vector<double> times;        // seconds
        std::vector<double> keys;         // keys as written in the table
        std::vector<std::size_t> lines;   // line numbers in the table, from 1
        std::vector<double> values;       // [R, X]
        std::vector<double> frame_times;  // times of the clip's frames in a cache, seconds
    };
    std::vector<Rows> of_clip;  // one entry for each clip of the source; a single one for a source without clips
};

// Places the table's rows at their times in the clips of `source`. Throws InvalidInput, which names the line, for
// clips and frames that the source does not have, for rows out of order, and for rows without a clip where the source
// has several.
ExtraInputs placeInputs(const InputTable& table, const std::string& file, const BakeSource& source);

// Returns the X numbers at a time of a clip of the source (-1: at rest). They are those of the row at this time
// (within 1e-6 s), or linear between the rows before and after. Throws InvalidInput when there is no such row, and
// says which frame needs it and which line is the nearest.
std::vector<float> inputsAt(const ExtraInputs& inputs, int clip, double time);

}  // namespace penumbra
