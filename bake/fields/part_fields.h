#pragma once
// The stage "fields": it reads a rig or a mesh and makes x.fields.h5, what each rigid part blocks around itself.
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "bake/fields/compare_fields.h"
#include "bake/fields/part_surface.h"
#include "formats/cache/point_cache.h"
#include "formats/common/frame_range.h"
#include "formats/common/progress.h"
#include "formats/rig/rig_options.h"
#include "formats/stage/field_file.h"

namespace penumbra {

struct FieldOptions {
    int rays = 512;           // directions a point, 16..2^16
    std::uint64_t seed = 1;   // 1 is the plain set of directions; any other seed turns it
    int cells = 12;           // a box has this many points to the power of 3 on average, if they fit, 4..64
    double megabytes = 2.95;  // all points take at most so many million bytes, 0.01..1000
    double fade = 0.0042;     // depth over which a point inside goes dark, in diagonals of the rest positions, 1e-6..1
    std::optional<FrameRange> parts = {};  // these parts only; unset = all parts
    // numbers of --inputs of the bake, for a mesh without skin that moves with one of their points
    std::optional<std::filesystem::path> inputs = {};
    PointCacheOptions cache = {};
    RigOptions rig = {};
};

// The plan tells what will be traced, before any ray is.
struct FieldPlan {
    FieldFile file;                // without bytes and scales
    std::vector<PartMesh> meshes;  // one for each of file.fields.parts
    std::vector<std::filesystem::path> files_read;
    std::vector<std::string> notes;  // BakeSource::notes()
    FieldReceivers receivers = {};

    std::size_t pointCount() const;
};
// Reads the rig and divides it into parts. A mesh without skin is one part. Throws UsageError, IoError and
// InvalidInput.
FieldPlan planFields(const std::vector<std::filesystem::path>& paths, const FieldOptions& options);

// Traces all points. The result holds the same bytes for any number of threads. Throws Interrupted within a second of
// a signal.
FieldFile bakeFields(const FieldPlan& plan, const FieldOptions& options, int threads, ProgressStyle progress);

// Rounds what was traced at the points of a part to bytes, and sets the part's scales. values: [points,
// kFieldCoefficients] V - 1; distances: [points of the fine box]. Distances are clamped at 4 cells of the fine box, or
// at the fade where that is more.
struct FieldSamples {
    std::vector<float> values, distances;
};
void quantizeField(const FieldSamples& samples, float fade, PartField& part, std::vector<std::int8_t>& values,
                   std::vector<std::int8_t>& distances);

}  // namespace penumbra
