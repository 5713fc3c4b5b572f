#pragma once
// How long a frame of an asset takes here, stage by stage.
#include "formats/asset_file.h"
#include "player/render_options.h"

namespace penumbra {

// Medians over the runs, in milliseconds a frame. Every run takes the next sampled frame of the asset. GL times end
// with glFinish: llvmpipe's timer queries are wrong.
struct BenchResult {
    std::string gl;
    std::size_t vertices = 0, triangles = 0;
    std::size_t bytes_read = 0;  // of mean and basis, a frame
    double skin = 0;             // pose, regression, skinned positions and frames
    double evaluate = 0;         // visibility numbers of all vertices
    double shade = 0;            // radiance of all vertices; 0 without material or light
    double draw_values = 0;      // upload and drawing of what the CPU made
    double draw_model = 0;       // upload of the pose, evaluation in the vertex shader, drawing
    double first_frame = 0;      // upload of the asset, compilation of the shaders, first draw
    // Part, material, light and rotation changed before every frame, against the frame that follows without a change;
    // in turns, so that both see the same work. `frame`: shading alone on the CPU, the whole frame on GL.
    struct Switching {
        double switched = 0, switched_worst = 0, steady = 0, steady_worst = 0;
    };
    Switching switch_cpu, switch_gl;
    double out_of_range_mean = 0, out_of_range_max = 0;  // Evaluator::outOfRange() over the asset's frames
};

// Shades with options.brdf and options.light, or draws E when the asset has none.
BenchResult benchAsset(const RenderOptions& options, const AssetView& asset, int runs, int threads);

}  // namespace penumbra
