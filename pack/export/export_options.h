#pragma once
// The options of an export.
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace penumbra {

// docs/exports.md has the layouts.
enum class ExportKind : std::uint8_t {
    kStatic,  // a .glb with the mean over all frames in vertex attributes
    kPlay,    // a .glb whose vertex colours follow its clips, by morph targets
    kTable,   // a picture with a row for each frame, and texture coordinates that find a vertex in it
    kNumpy,   // an array of NumPy, [frames, source vertices]
};
// The quantity that a table holds.
enum class TableValue : std::uint8_t { kOcclusion, kBounced, kBent };

// Whether COLOR_0 is written, which is what most programs show, or _OCCLUSION alone.
enum class ColorAttribute : std::uint8_t { kWritten, kNone };
// Which mesh the .glb has: the one of the bake, or a level of detail, which takes values from the nearest surface.
enum class ExportMesh : std::uint8_t { kSame, kLevel };

struct ExportOptions {
    ExportKind kind = ExportKind::kStatic;
    std::vector<std::string> clips;  // names; empty: all
    double rate = 0;                 // frames a second; 0: those of the bake, or kModelRate of a model
    std::size_t components = 16;     // for kPlay; 0: as many as max_error needs, or all if that is 0 too
    double max_error = 0;            // for kPlay: rms of ambient visibility, above 0 if `components` is 0
    ColorAttribute color = ColorAttribute::kWritten;
    TableValue value = TableValue::kOcclusion;  // for kTable; kBounced also for COLOR_0 of kStatic
    ExportMesh mesh = ExportMesh::kSame;
};

// Frames a second that a model is asked for. Of motion capture 12 leave a mean error of .003 between frames.
constexpr double kModelRate = 12;

}  // namespace penumbra
