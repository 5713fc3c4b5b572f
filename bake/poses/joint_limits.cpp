#include "bake/poses/joint_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <utility>

#include "bake/poses/limbs.h"
#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "sh/angles.h"

namespace penumbra {

namespace {

constexpr double kTail = 0.01;  // share of the frames that lies beyond each end of a range
constexpr std::uintmax_t kMaxFileBytes = 16 << 20;

// Returns the quantile between the two nearest of the sorted values (as numpy does by default).
double quantile(const std::vector<float>& sorted, double share) {
    const double at = share * double(sorted.size() - 1);
    const auto below = std::size_t(at);
    const std::size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (at - double(below)) * (double(sorted[above]) - sorted[below]);
}

}  // namespace

JointLimits limitsOfFrames(const Rig& rig, std::span<const RigFrame> frames, int threads) {
    const std::size_t width = 3 * rig.skin.jointCount();
    std::vector<std::vector<float>> poses(frames.size());
    parallelFor(frames.size(), threads, [&](std::size_t f) {
        throwIfInterrupted();
        poses[f] = evaluatePose(rig, frames[f].clip, frames[f].time).pose;
    });
    JointLimits limits{std::vector<double>(width), std::vector<double>(width)};
    std::vector<float> column(frames.size());
    for (std::size_t c = 0; c < width; ++c) {
        if (rig.skin.parents[c / 3] < 0 || !turnsItself(rig, c / 3)) continue;
        for (std::size_t f = 0; f < frames.size(); ++f) column[f] = poses[f][c];
        std::sort(column.begin(), column.end());
        limits.low[c] = quantile(column, kTail);
        limits.high[c] = quantile(column, 1 - kTail);
    }
    return limits;
}

JointLimits limitsWithoutClips(const Rig& rig) {
    const std::size_t width = 3 * rig.skin.jointCount();
    JointLimits limits{std::vector<double>(width), std::vector<double>(width)};
    const std::vector<char> carries = carryingJoints(rig);
    for (std::size_t j = 0; j < rig.skin.jointCount(); ++j) {
        if (!carries[j] || !turnsItself(rig, j)) continue;
        int depth = 0;
        for (int up = rig.skin.parents[j]; up >= 0; up = rig.skin.parents[std::size_t(up)]) ++depth;
        if (depth == 0) continue;
        const double limit = std::max(kFreeTurn / std::sqrt(double(depth)), kMinFreeTurn) * kDegree;
        for (std::size_t c = 3 * j; c < 3 * j + 3; ++c) {
            limits.low[c] = -limit;
            limits.high[c] = limit;
        }
    }
    return limits;
}

namespace {
// One line of the file.
struct Row {
    std::size_t component = 0;  // 3 joint + axis
    double low = 0, high = 0;   // radians
};

double parseDegrees(const std::string& text) {
    char* end = nullptr;
    const double value = std::strtod(text.c_str(), &end);
    if (text.empty() || *end != '\0' || !(value >= -180 && value <= 180))
        throw InvalidInput("'" + text + "' is not an angle of -180..180 degrees");
    return value;
}

// Splits "joint,axis,min,max" from its end, because the joint's name may have commas itself.
std::array<std::string, 4> fieldsOf(std::string line) {
    std::array<std::string, 4> fields;
    for (std::size_t i = 3; i > 0; --i) {
        const std::size_t comma = line.rfind(',');
        if (comma == std::string::npos) throw InvalidInput("not 'joint,axis,min,max'");
        fields[i] = line.substr(comma + 1);
        line.resize(comma);
    }
    fields[0] = line;
    return fields;
}

Row parseRow(const std::string& line, const Rig& rig) {
    const std::array<std::string, 4> fields = fieldsOf(line);
    const std::vector<std::string>& names = rig.skin.joint_names;
    const auto joint = std::size_t(std::find(names.begin(), names.end(), fields[0]) - names.begin());
    if (joint == names.size()) throw InvalidInput("the rig has no joint '" + fields[0] + "'");
    if (!turnsItself(rig, joint))
        throw InvalidInput("joint '" + fields[0] + "' cannot turn by itself (a matrix, or the node of another joint)");
    const std::size_t axis = std::string("xyz").find(fields[1]);
    if (fields[1].size() != 1 || axis == std::string::npos)
        throw InvalidInput("axis '" + fields[1] + "' is not x, y or z");
    const Row row{3 * joint + axis, parseDegrees(fields[2]) * kDegree, parseDegrees(fields[3]) * kDegree};
    if (row.low > row.high) throw InvalidInput("min " + fields[2] + " is above max " + fields[3]);
    return row;
}

}  // namespace

void applyLimitsFile(const std::filesystem::path& path, const Rig& rig, JointLimits& limits) {
    checkReadable(path);
    std::ifstream in(path);
    std::error_code error;
    if (std::filesystem::file_size(path, error) > kMaxFileBytes)
        throw InvalidInput(path.string() + ": larger than any table of joint limits");
    std::vector<char> given(limits.low.size(), 0);
    bool header = false;
    std::string line;
    for (std::size_t number = 1; std::getline(in, line); ++number) {
        if (!line.empty() && line.back() == '\r') line.pop_back();
        if (line.empty() || line[0] == '#') continue;
        try {
            if (!std::exchange(header, true)) {
                if (line != "joint,axis,min,max") throw InvalidInput("the first line is not 'joint,axis,min,max'");
                continue;
            }
            const Row row = parseRow(line, rig);
            if (std::exchange(given[row.component], 1)) throw InvalidInput("this axis of the joint occurs twice");
            limits.low[row.component] = row.low;
            limits.high[row.component] = row.high;
        } catch (const InvalidInput& problem) {
            throw InvalidInput(path.string() + ": line " + std::to_string(number) + ": " + problem.what());
        }
    }
    if (!header) throw InvalidInput(path.string() + ": has no line 'joint,axis,min,max'");
}

}  // namespace penumbra
