#pragma once
// The four kinds of exports. docs/exports.md has their layouts.
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/rig/gltf_numbers.h"
#include "formats/rig/growing_glb.h"
#include "formats/rig/rig_file.h"
#include "pack/export/export_rows.h"
#include "pack/export/glb_targets.h"
#include "pack/export/occlusion_source.h"
#include "pack/export/principal_weights.h"

namespace penumbra {

// Told how many frames are read.
using FrameProgress = std::function<void(std::size_t)>;

// The frames of a source, and how they are read.
struct FrameReader {
    const OcclusionSource& source;
    int threads = 0;
    FrameProgress progress;

    OcclusionFrame read(std::size_t frame, FrameParts parts) const;  // throws Interrupted
};

// A .glb to write into, with the rows of its vertices.
struct ExportedGlb {
    const Rig& rig;
    const ExportRows& rows;
    const GltfNumbers& numbers;
    GrowingGlb glb;
    std::vector<GlbTarget> targets;
};

// Writes the mean over all frames into vertex attributes. Returns the root mean square of how far frames are from it.
double exportStatic(const FrameReader& frames, const ExportOptions& options, ExportedGlb& out);

// Writes vertex colours that follow the clips. Returns what is played, with its error. Throws InvalidInput where the
// .glb does not have the clips.
PrincipalWeights exportPlay(const FrameReader& frames, const ExportOptions& options, ExportedGlb& out);

// Where a vertex is in the picture of a table: texel (v mod width, frame * rows_a_frame + v div width), row 0 on top.
struct TableLayout {
    std::size_t width = 0, rows_a_frame = 0, vertices = 0, frames = 0;
    std::optional<std::size_t> texcoord;  // the set of a .glb that finds a vertex in frame 0
    std::size_t height() const { return rows_a_frame * frames; }
};
struct TableFiles {
    std::filesystem::path picture, description, glb;  // glb: "" without one
};
enum class TableGlb : std::uint8_t { kNone, kWritten };
// Returns the names of the files of a table, which differ only in their extensions.
TableFiles tableFiles(const std::filesystem::path& output, TableGlb glb);
// Writes picture and description, and adds the texture coordinates to `glb`, if there is one. All frames of a clip must
// be equally far apart.
TableLayout exportTable(const FrameReader& frames, const ExportRows& rows, TableValue value, const TableFiles& files,
                        ExportedGlb* glb);

// Brings directions from the space of rest positions to that of the primitive of a part, as the transpose does for what
// turns and scales alike in all directions. The results are unit.
void bringToPrimitive(const ColoredPart& part, std::span<Vec3> directions);

// Ambient visibility of all frames, [F, R] float32, as NumPy's save() writes it.
void exportNumpy(const FrameReader& frames, const ExportRows& rows, const std::filesystem::path& output);

// Where the bake has each row in every frame, [F, R, 3] float32. Who made the character compares them with what it
// shows.
void exportPositions(const VisibilityReader& bake, const ExportRows& rows, const std::filesystem::path& output);

// COLOR_0 of a target: its own colours, or white.
struct VertexColors {
    int components = 3;         // 4 where the own colours have alpha, or where 4 were asked for
    std::vector<float> values;  // [vertices, components]
};
VertexColors ownColors(ExportedGlb& out, const GlbTarget& target, int components);
// A morph target of the file adds this to COLOR_0.
struct ColorMorph {
    std::size_t morph = 0;      // index among the primitive's targets
    std::vector<float> values;  // [vertices, components]; an alpha that the file does not have is 0
};
std::vector<ColorMorph> ownColorMorphs(ExportedGlb& out, const GlbTarget& target, int components);
// Multiplies colours [vertices, components] by `factor` [vertices]. Alpha stays.
void multiplyColors(std::span<float> colors, int components, std::span<const Vec3> factor);
// Writes COLOR_0, and says in the primitive what its colours were before, so that our own readers take these.
void writeColors(ExportedGlb& out, const GlbTarget& target, const VertexColors& colors);

}  // namespace penumbra
