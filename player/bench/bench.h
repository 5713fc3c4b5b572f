#pragma once
// Measures how long a frame of an asset takes here, stage by stage, on the CPU and with OpenGL.
#include <string>

#include "formats/asset/asset_file.h"
#include "player/bench/bench_cpu.h"
#include "player/bench/gpu_cost.h"
#include "player/frame/render_options.h"

namespace penumbra {

// Milliseconds a frame. GL times end with glFinish or with the picture read back, because llvmpipe's timer queries
// are wrong.
struct GlBench {
    std::string context;
    double draw_values = 0;  // upload and drawing of the values that the CPU computed
    double draw_model = 0;   // pose, its upload, evaluation in the compute shader, drawing
    GpuCost model;           // the steps of draw_model except the pose
    double first_frame = 0;  // upload of the asset, compilation of the shaders, and the first draw
    // Pose, skinning, evaluation, shading, upload, drawing and reading an 8-bit picture back, as a window shows it:
    // once with one sample a pixel, and once with as many as the options ask for.
    struct WholeFrame {
        int samples = 1;
        StageTime time;
    };
    std::vector<WholeFrame> whole_frames;
    double path_difference = 0;  // root mean square between the pictures of both paths, in 8-bit steps of sRGB
    Switching switching;
};

// Milliseconds a frame of all `count` characters of one asset, each in a pose of its own. Where there are as many as
// threads, each has a thread. Draw is the upload and the drawing of what the CPU computed, each at its own place in
// one picture.
struct CharactersCost {
    int count = 0;
    double pose_skin = 0, evaluate = 0, shade = 0, draw = 0;
    double cpu() const { return pose_skin + evaluate + shade; }
    double total() const { return cpu() + draw; }
    // Bytes that malloc has given out. A character is its evaluator and its result arrays (positions, normals,
    // tangents, numbers, radiance). bytes_decoded is what all characters share besides the mapped asset.
    std::size_t bytes_decoded = 0, bytes_each = 0;
    GpuCost glsl;  // on the GLSL path, with one dispatch and one draw
};

struct BenchResult {
    std::size_t vertices = 0, triangles = 0;
    int threads = 1;
    CpuBench cpu;
    GlBench gl;
    std::vector<CharactersCost> characters;
    std::size_t suns = 0;   // suns of the light; with them the rest of it is shaded as SH
    std::size_t terms = 1;  // terms of a vertex; more than 1: pictures on the mesh are drawn
};

// Shades with options.brdf and options.light, or draws E when the asset has none. All light is SH, since shadow maps
// are of scenes (bench_scene.h). Figures are medians of `runs`; threads as in parallelFor(). `characters` lists how
// many of them to measure (bench_characters.h).
BenchResult benchAsset(const RenderOptions& options, const AssetView& asset, int runs, int threads,
                       const std::vector<int>& characters = {});

}  // namespace penumbra
