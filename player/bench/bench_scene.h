#pragma once
// Measures what a scene costs: its characters past one another, its ground, and whole frames of it.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "player/bench/scene_gpu_cost.h"
#include "player/bench/stage_time.h"
#include "player/frame/render_options.h"
#include "player/scene/posed_scene.h"

namespace penumbra {

// Medians in milliseconds. A pair is a receiver and a caster, which may be out of reach.
struct CastCost {
    std::size_t receivers = 0, pairs = 0;
    double one_thread = 0, all_threads = 0;
    double nanosecondsOfPair() const { return 1e6 * one_thread / double(pairs); }  // on one thread
};

// Error of E past the casters if anchors are used (CastShadow::evaluateRun()), against each vertex for itself.
struct AnchorError {
    double rms = 0, largest = 0;
    double hidden = 0;  // mean of 1 - E
};

// Medians in milliseconds, with suns and with all of the light as SH.
struct WithSuns {
    double with = 0, without = 0;
    double ratio() const { return with / without; }
};

// Cost of the light's suns.
struct SunCost {
    std::size_t count = 0;
    double map = 0;        // drawing all maps
    WithSuns shade, draw;  // shading of the vertices; upload and drawing, without the maps
    WithSuns frame;        // all of it
};

// Cost of a ground with heights, in milliseconds: horizons and numbers of all points, and the same with the heights of
// another time, on all threads.
struct FieldCost {
    std::size_t receivers = 0;  // receivers with horizons
    double one_thread = 0, all_threads = 0, frame = 0;
};

// Milliseconds a frame; all but `pose` on all threads.
struct SceneCost {
    std::size_t members = 0, casters = 0;
    double pose = 0;                  // taking over the pose of one caster
    CastCost members_cast;            // all vertices, each past everyone but its own character
    AnchorError anchors;              // over at most the first 4 members
    double reached = 0;               // casters that a member has in reach, mean
    std::size_t ground_vertices = 0;  // 0: no ground
    std::optional<FieldCost> field;   // set for a ground with heights
    CastCost ground_cast;             // its receivers are the vertices that are evaluated
    double pose_all = 0, shade = 0;   // members and ground
    double evaluate_members = 0;      // skinning, visibility, and past all others
    std::optional<double> draw;       // upload, drawing and an 8-bit picture read back; unset without GL
    StageTime frame;                  // all of it, as far as it can be done here
    StageTime processor;              // time of all threads together in the same frame
    std::optional<SunCost> suns;      // unset where none shine, and without GL
    std::optional<SceneGpuCost> gpu;  // where the GPU evaluates; unset in software
};

struct SceneBench {
    int threads = 1;
    std::string context;  // name of the GL, or the reason why there is none
    SceneCost scene;
    std::vector<SceneCost> copies;
};

// Measures the scene, then `counts` copies of its first character in ascending order. Copies stand on a square, 2 m
// from one another, each turned another way. Their ground is 2 m larger for each further row, with the vertices as
// dense. Of the options it reads size, camera, shading, samples and backend; a scene without a light shows E.
SceneBench benchScene(const RenderOptions& options, const SceneDescription& scene, int runs, int threads,
                      std::vector<int> counts);

void printScene(const SceneBench& bench);
nlohmann::ordered_json figuresOf(const SceneBench& bench);  // all figures that the report prints

}  // namespace penumbra
