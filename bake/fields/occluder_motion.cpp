#include "bake/fields/occluder_motion.h"

#include <algorithm>
#include <cmath>

#include "bake/source/extra_inputs.h"
#include "formats/common/errors.h"
#include "sh/bounding_box.h"

namespace penumbra {

namespace {

constexpr float kPlaceTolerance = 1e-3f;  // in mesh diagonals

// One frame of a mesh that may move: how far, and whether that is all it does.
struct Shift {
    int clip = 0;
    double time = 0;
    Vec3 way;
    bool rigid = true;
};

std::vector<Shift> shiftsOf(const BakeSource& source, float tolerance) {
    const std::vector<Vec3>& rest = source.mesh().rest_positions;
    const FrameList frames = sampleFrames(source, {}, 0);
    const std::vector<int> clips = clipIndices(source, frames.clip_names);
    std::vector<Shift> shifts;
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        Shift shift{clips[frames.clip[f]], frames.time[f], {}, true};
        const std::vector<Vec3> positions = sourcePositions(source, shift.clip, shift.time);
        Vec3d sum;
        for (std::size_t v = 0; v < rest.size(); ++v) sum += toDouble(positions[v]) - toDouble(rest[v]);
        shift.way = toFloat(sum / double(rest.size()));
        for (std::size_t v = 0; v < rest.size(); ++v)
            shift.rigid = shift.rigid && length(positions[v] - rest[v] - shift.way) <= tolerance;
        shifts.push_back(shift);
    }
    return shifts;
}

// Names of the points among the inputs, and their first columns.
std::vector<std::pair<std::string, std::size_t>> pointsOf(const std::vector<std::string>& names) {
    std::vector<std::pair<std::string, std::size_t>> points;
    for (std::size_t c = 0; c + 2 < names.size(); ++c) {
        if (!names[c].ends_with(".x")) continue;
        const std::string stem = names[c].substr(0, names[c].size() - 2);
        if (names[c + 1] == stem + ".y" && names[c + 2] == stem + ".z") points.emplace_back(stem, c);
    }
    return points;
}

std::string frameText(const BakeSource& source, const Shift& shift) {
    return "clip '" + source.clipNames()[std::size_t(shift.clip)] + "', " + std::to_string(shift.time) + " s";
}

}  // namespace

OccluderMotion motionOf(const BakeSource& source, const std::optional<std::filesystem::path>& inputs) {
    OccluderMotion motion;
    if (source.rig) return motion;
    const float tolerance = kPlaceTolerance * float(characterDiagonal(source.mesh()));
    const std::vector<Shift> shifts = shiftsOf(source, tolerance);
    motion.moves = std::any_of(shifts.begin(), shifts.end(),
                               [&](const Shift& s) { return !s.rigid || length(s.way) > tolerance; });
    if (!inputs || !motion.moves) return motion;
    const std::string name = source.filesRead().front().string();
    for (const Shift& shift : shifts)
        if (!shift.rigid)
            throw InvalidInput(name + ": " + frameText(source, shift) +
                               ": it turns or bends; a field moves with a point of the inputs and does not turn");
    const ExtraInputs table = placeInputs(readInputTable(*inputs), inputs->string(), source);
    for (const auto& [point, column] : pointsOf(table.names)) {
        bool follows = true;
        for (std::size_t i = 0; follows && i < shifts.size(); ++i) {
            const std::vector<float> x = inputsAt(table, shifts[i].clip, shifts[i].time);
            const Vec3 origin = Vec3{x[column], x[column + 1], x[column + 2]} - shifts[i].way;
            if (i == 0) motion.origin = origin;
            follows = length(origin - motion.origin) <= tolerance;
        }
        if (!follows) continue;
        motion.follows = point;
        motion.moves = false;
        return motion;
    }
    throw InvalidInput(name + ": it moves with no point of " + inputs->string());
}

}  // namespace penumbra
