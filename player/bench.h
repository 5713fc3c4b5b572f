#pragma once
// How long a frame of an asset takes here, stage by stage, on the CPU and with OpenGL.
#include <string>

#include "formats/asset_file.h"
#include "player/bench_cpu.h"
#include "player/render_options.h"

namespace penumbra {

// Milliseconds a frame. GL times end with glFinish or with the picture read back: llvmpipe's timer queries are wrong.
struct GlBench {
    std::string context;
    double draw_values = 0;  // upload and drawing of what the CPU made
    double draw_model = 0;   // upload of the pose, evaluation in the compute shader, drawing
    double first_frame = 0;  // upload of the asset, compilation of the shaders, first draw
    // Pose, skinning, evaluation, shading, upload, drawing and an 8-bit picture read back, as a window shows it; with
    // one sample a pixel and with as many as asked for.
    struct WholeFrame {
        int samples = 1;
        StageTime time;
    };
    std::vector<WholeFrame> whole_frames;
    double path_difference = 0;  // root mean square between the pictures of both paths, in 8-bit steps of sRGB
    Switching switching;
};

struct BenchResult {
    std::size_t vertices = 0, triangles = 0;
    int threads = 1;
    CpuBench cpu;
    GlBench gl;
};

// Shades with options.brdf and options.light, or draws E when the asset has none. Medians of `runs`; threads as in
// parallelFor().
BenchResult benchAsset(const RenderOptions& options, const AssetView& asset, int runs, int threads);

}  // namespace penumbra
