#pragma once
// Reads height fields, still or moving: NumPy arrays, 16-bit grey PNG, one channel of an EXR, raw numbers with a
// header, and closed forms (sh/height/analytic_heights.h). formats/README.md has the details of each.
#include <filesystem>
#include <optional>
#include <vector>

#include "formats/cache/numpy_array.h"
#include "formats/height/height_source.h"
#include "sh/height/analytic_heights.h"

namespace penumbra {

// Returns every file that a source reads, which may be none.
std::vector<std::filesystem::path> filesOf(const HeightSource& source);

class HeightSequence {
public:
    // Opens the source and checks its first frame's size; a sequence is a pattern ("dune_%03d.png", a folder) or an
    // array of three axes. Throws IoError, Unsupported, and InvalidInput with the file and the field.
    explicit HeightSequence(HeightSource source);

    const HeightSource& source() const { return source_; }
    const HeightGrid& grid() const { return grid_; }
    std::size_t frameCount() const { return frames_; }  // 1 for one that is still, or a closed form
    bool moves() const { return frames_ > 1 || !analytic_.empty(); }
    // The nearest frame of a sequence, which starts anew at its end; the heights of a closed form themselves. Writes
    // metres, [rows, columns]. Throws as the constructor does, also where a height is no number or beyond
    // kMaxElevation.
    void read(double seconds, std::span<float> heights) const;

private:
    HeightSource source_;
    HeightGrid grid_;
    std::size_t frames_ = 1;
    std::vector<AnalyticHeights> analytic_;
    std::vector<std::filesystem::path> files_;
    std::optional<NumpyArray> array_;

    void openFiles();
    void readFrame(std::size_t frame, std::span<float> heights) const;
};

}  // namespace penumbra
