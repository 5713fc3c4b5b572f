#include "player/render/error_gate.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace penumbra {

namespace {

constexpr std::size_t kNamedFrames = 3;

std::string shortNumber(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

std::string frameName(const FrameRecord& record, const AnimationView& animation) {
    return std::string(animation.clips[record.at.clip].name) + " " + std::to_string(record.at.number);
}

// Returns "; worst: walk 3 (0.123), ...".
std::string worstFrames(const ErrorGate& gate, std::span<const FrameRecord> records,
                        const std::vector<std::size_t>& order, const AnimationView& animation) {
    std::string text;
    for (std::size_t i = 0; i < std::min(order.size(), kNamedFrames); ++i)
        text += (i == 0 ? "; worst: " : ", ") + frameName(records[order[i]], animation) + " (" +
                shortNumber(figureOf(records[order[i]], gate.figure)) + ")";
    return text;
}

}  // namespace

GateResult judge(const ErrorGate& gate, std::span<const FrameRecord> records, const AnimationView& animation) {
    GateResult result;
    RunFigures run;
    std::vector<std::size_t> order;  // worst first
    std::size_t first_without = 0;
    for (std::size_t i = 0; i < records.size(); ++i) {
        run.add(records[i]);
        if (std::isnan(figureOf(records[i], gate.figure))) {
            if (result.without++ == 0) first_without = i;
        } else {
            order.push_back(i);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return figureOf(records[a], gate.figure) > figureOf(records[b], gate.figure);
    });
    for (const std::size_t i : order)
        if (figureOf(records[i], gate.figure) > gate.above) result.failed.push_back(i);
    result.run = figureOf(run, gate.figure);

    const std::string name(nameOf(gate.figure)), above = " above " + shortNumber(gate.above);
    const std::string all = std::to_string(records.size()) + " frames";
    const double share = 100 * double(result.failed.size()) / double(records.size());
    if (order.empty() && result.without == 0)
        result.message = "nothing was compared";
    else if (result.without > 0)
        result.message = std::to_string(result.without) + " of " + all + " have no " + name +
                         " (the first: " + frameName(records[first_without], animation) + ")" +
                         worstFrames(gate, records, result.failed, animation);
    else if (gate.over_run && !(result.run <= gate.above))
        result.message = name + " is " + shortNumber(result.run) + "," + above + ", over " + all +
                         worstFrames(gate, records, order, animation);
    else if (!gate.over_run && share > gate.percent)
        result.message = name + " is" + above + " in " + std::to_string(result.failed.size()) + " of " + all +
                         (gate.percent > 0 ? " (" + shortNumber(gate.percent) + "% may be)" : "") +
                         worstFrames(gate, records, result.failed, animation);
    result.passed = result.message.empty();
    return result;
}

}  // namespace penumbra
