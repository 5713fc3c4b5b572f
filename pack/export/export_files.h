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

// Writes the mean over all frames into vertex attributes.
void exportStatic(const FrameReader& frames, const ExportOptions& options, ExportedGlb& out);

// Ambient visibility of all frames, [F, R] float32, as NumPy's save() writes it.
void exportNumpy(const FrameReader& frames, const ExportRows& rows, const std::filesystem::path& output);

// Returns the values of COLOR_0 of a target: its own ones, or white, times `factor` [vertices]. There are 4 numbers a
// vertex where the own ones have alpha or `components` is 4, and else 3.
struct VertexColors {
    int components = 3;
    std::vector<float> values;
    bool own = false;
};
VertexColors ownColors(ExportedGlb& out, const GlbTarget& target, int components);

}  // namespace penumbra
