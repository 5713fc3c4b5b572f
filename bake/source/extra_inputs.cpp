#include "bake/source/extra_inputs.h"

#include <algorithm>
#include <iomanip>
#include <sstream>

#include "formats/common/errors.h"
#include "formats/stage/pose_file.h"

namespace penumbra {

namespace {

// Finds the clip that a row of the table names. `where` starts the messages.
std::size_t clipOfRow(const InputTable& table, std::size_t row, const std::vector<std::string>& clips,
                      const std::string& where) {
    if (table.clips.empty()) {
        if (clips.size() > 1) throw InvalidInput(where + "a column 'clip' is needed: there are several clips");
        return 0;
    }
    const auto found = std::find(clips.begin(), clips.end(), table.clips[row]);
    if (found == clips.end()) throw InvalidInput(where + "there is no clip '" + table.clips[row] + "'");
    return std::size_t(found - clips.begin());
}

// Returns the time of a row in seconds.
double timeOfRow(const InputTable& table, std::size_t row, const BakeSource& source, std::size_t clip,
                 const std::string& where) {
    if (!table.by_frame) return table.keys[row];
    if (source.rig) throw InvalidInput(where + "a rig has no numbered frames; give a column 'time'");
    const std::vector<double>& times = source.cache->clips.at(clip).times;
    if (table.keys[row] >= double(times.size()))
        throw InvalidInput(where + "frame " + std::to_string(std::int64_t(table.keys[row])) + " of clip '" +
                           source.cache->clips[clip].name + "', which has " + std::to_string(times.size()) +
                           " frames, numbered from 0");
    return times[std::size_t(table.keys[row])];
}

std::string numberText(double number) {
    std::ostringstream text;
    text << std::setprecision(10) << number;
    return text.str();
}

// Makes "frame 7" or "0.5 s".
std::string keyText(const ExtraInputs& inputs, double key) {
    return inputs.by_frame ? "frame " + numberText(key) : numberText(key) + " s";
}

std::string rowText(const ExtraInputs& inputs, const ExtraInputs::Rows& rows, std::size_t row) {
    return keyText(inputs, rows.keys[row]) + " (line " + std::to_string(rows.lines[row]) + ")";
}

// Returns the row of a table by frames at this time. 6.25 lies a quarter of the way from row 6 to row 7.
double frameAt(const std::vector<double>& frame_times, double time) {
    const auto next = std::lower_bound(frame_times.begin(), frame_times.end(), time - kSameTime);
    const double number = double(next - frame_times.begin());
    if (next == frame_times.end() || next == frame_times.begin() || *next <= time + kSameTime) return number;
    return number - (*next - time) / (*next - *(next - 1));
}

}  // namespace

[[noreturn]] static void failWithoutRow(const ExtraInputs& inputs, const ExtraInputs::Rows& rows, double time) {
    std::string what = numberText(time) + " s";
    if (inputs.by_frame) what = "frame " + numberText(frameAt(rows.frame_times, time)) + " (at " + what + ")";
    if (!rows.clip.empty()) what += " of clip '" + rows.clip + "'";
    std::string has = "it has none of this clip";
    if (!rows.times.empty())
        has = time < rows.times.front() ? "its lines begin with " + rowText(inputs, rows, 0)
                                        : "its lines end with " + rowText(inputs, rows, rows.times.size() - 1);
    throw InvalidInput(inputs.file + ": no line for " + what + "; " + has);
}

namespace {

// Makes the inputs without any row yet.
ExtraInputs emptyInputs(const InputTable& table, const std::string& file, const BakeSource& source) {
    const std::vector<std::string> clips = source.clipNames();
    ExtraInputs out{file, table.names, table.by_frame, {}};
    out.of_clip.resize(std::max<std::size_t>(1, clips.size()));
    for (std::size_t clip = 0; clip < clips.size(); ++clip) {
        out.of_clip[clip].clip = clips[clip];
        if (source.cache) out.of_clip[clip].frame_times = source.cache->clips[clip].times;
    }
    return out;
}

}  // namespace

ExtraInputs placeInputs(const InputTable& table, const std::string& file, const BakeSource& source) {
    const std::vector<std::string> clips = source.clipNames();
    ExtraInputs out = emptyInputs(table, file, source);
    const std::size_t size = table.names.size();
    for (std::size_t row = 0; row < table.keys.size(); ++row) {
        const std::string where = file + ": line " + std::to_string(table.lines[row]) + ": ";
        const std::size_t clip = clipOfRow(table, row, clips, where);
        ExtraInputs::Rows& rows = out.of_clip[clip];
        const double time = timeOfRow(table, row, source, clip, where);
        if (!rows.times.empty() && !(time > rows.times.back()))
            throw InvalidInput(where + keyText(out, table.keys[row]) + " is not after " +
                               rowText(out, rows, rows.times.size() - 1));
        rows.times.push_back(time);
        rows.keys.push_back(table.keys[row]);
        rows.lines.push_back(table.lines[row]);
        const auto first = table.values.begin() + std::ptrdiff_t(row * size);
        rows.values.insert(rows.values.end(), first, first + std::ptrdiff_t(size));
    }
    return out;
}

std::vector<float> inputsAt(const ExtraInputs& inputs, int clip, double time) {
    const std::size_t size = inputs.names.size();
    const ExtraInputs::Rows& rows = inputs.of_clip[std::size_t(std::max(clip, 0))];
    const auto value = [&](std::size_t row, std::size_t i) { return rows.values[row * size + i]; };
    std::vector<float> out(size);
    const std::size_t next =
        std::size_t(std::lower_bound(rows.times.begin(), rows.times.end(), time - kSameTime) - rows.times.begin());
    // A row at this very time is used as it is; otherwise the rows before and after are mixed.
    if (next < rows.times.size() && rows.times[next] <= time + kSameTime) {
        for (std::size_t i = 0; i < size; ++i) out[i] = float(value(next, i));
        return out;
    }
    if (next == 0 || next == rows.times.size()) failWithoutRow(inputs, rows, time);
    const double share = (time - rows.times[next - 1]) / (rows.times[next] - rows.times[next - 1]);
    for (std::size_t i = 0; i < size; ++i) out[i] = float(value(next - 1, i) * (1 - share) + value(next, i) * share);
    return out;
}

}  // namespace penumbra
