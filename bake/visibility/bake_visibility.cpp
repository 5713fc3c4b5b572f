// Traces all frames of a bake and writes them.
//
// Problem: F frames of V vertices need 2 N rays each. All cores shall be busy, memory shall hold few frames, a bake
// that is killed shall not lose its work, and the file shall hold the same bytes whatever the number of threads is.
//
// Naive: give every thread a frame of its own. Then as many frames as threads are in memory, each with its own ray
// tracing tree, and they end in any order. Or trace one frame after the other with all threads: then all but one of
// them wait while one writes a frame and prepares the next.
//
// Here: the frames form a pipeline. While all threads share the vertices of frame f, one task writes frame f - 1 and
// one poses frame f + 1. A vertex' result depends on that vertex alone (moments.h), so that the threads' order
// changes no byte. Finished frames go to a journal as well (bake_journal.h), from which a second start continues. The
// rays measure the moments of section 2 of docs/formulas.md.
#include "bake/visibility/bake_visibility.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <functional>
#include <mutex>
#include <numbers>
#include <optional>
#include <utility>

#include "bake/visibility/bake_journal.h"
#include "bake/visibility/bake_transfer.h"
#include "bake/visibility/frame_scene.h"
#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_check.h"

namespace penumbra {

namespace {

// Counts rays from many threads. A thread that finds the printer free prints; the others go on.
class RayCount {
public:
    RayCount(ProgressStyle style, double expected)
        : expected_(expected * 1e-6), progress_(style, "tracing", "Mray", expected_) {}
    // Adds `traced` rays that were shot. They stand for `expected` of the planned rays, some of which lie below
    // horizons.
    void add(std::size_t traced, std::size_t expected) {
        traced_ += traced;
        const std::size_t done = expected_done_ += expected;
        if (const std::unique_lock lock(printing_, std::try_to_lock); lock) progress_.update(double(done) * 1e-6);
    }
    double traced() const { return double(traced_); }
    void finish() { progress_.update(expected_); }

private:
    std::atomic<std::size_t> traced_ = 0, expected_done_ = 0;
    std::mutex printing_;
    double expected_;  // Mray
    Progress progress_;
};

void traceTask(const TracedFrame& traced, std::size_t task, RayCount& count) {
    const MomentTracer& tracer = traced.tracer;
    const std::size_t vertices = traced.posed.frame.positions.size();
    const std::size_t end = std::min(vertices, (task + 1) * kVerticesPerTask);
    // A step traces at most 2^17 directions, about 10 ms, before it looks at the signal flag again.
    const std::size_t step = std::max<std::size_t>(1, (std::size_t(1) << 17) / std::size_t(tracer.directions.count));
    for (std::size_t begin = task * kVerticesPerTask; begin < end; begin += step) {
        throwIfInterrupted();
        const std::size_t size = std::min(step, end - begin);
        count.add(traceVertices(traced, begin, size), size * std::size_t(tracer.directions.count) / 2);
    }
}

// Traces the frames [begin, F). While frame f is traced, one task writes frame f - 1 and one prepares frame f + 1, so
// that three frames are in memory.
void traceFrames(const BakePlan& plan, const BakeOptions& options, std::size_t begin, int threads, RayCount& count,
                 const std::function<void(const VisibilityFrame&)>& write) {
    const std::size_t frame_count = plan.header.frames.frameCount();
    if (begin == frame_count) return;
    const BakeDirections directions = makeBakeDirections(options, plan.rest_diagonal);
    const std::size_t tasks = (plan.header.mesh.vertexCount() + kVerticesPerTask - 1) / kVerticesPerTask;
    std::optional<VisibilityFrame> done;
    std::optional<FrameScene> current = frameScene(plan, begin), next;
    for (std::size_t f = begin; f < frame_count; ++f) {
        const MomentTracer tracer = tracerOf(plan, *current, directions);
        std::optional<FrameBounces> bounces;
        if (options.transfer) bounces.emplace(plan.header);
        const TracedFrame traced{*current, tracer, bounces ? &*bounces : nullptr};
        // Tasks 0 and 1 come first, because they take longest and cannot be divided.
        parallelFor(tasks + 2, threads, [&](std::size_t i) {
            if (i == 0 && done) write(*done);
            if (i == 1 && f + 1 < frame_count) next.emplace(frameScene(plan, f + 1));
            if (i >= 2) traceTask(traced, i - 2, count);
        });
        if (plan.header.hasBounces()) addBounces(plan.header, *bounces, threads, current->frame);
        done = std::move(current->frame);
        current = std::exchange(next, std::nullopt);
    }
    write(*done);
}

double openShare(const VisibilityHeader& header, const VisibilityFrame& frame) {
    const std::size_t stride = header.coefficientCount(), vertices = frame.coefficients.size() / stride;
    double sum = 0;
    for (std::size_t v = 0; v < vertices; ++v) sum += double(frame.coefficients[v * stride]);
    return sum / (double(vertices) * unblockedOf(header.quantity));
}

}  // namespace

double unblockedOf(const std::string& quantity) {
    const double visibility = std::sqrt(std::numbers::pi);
    if (quantity == kMirroredVisibility) return 2 * visibility;
    return quantity == kDiffuseTransfer ? visibility / 2 : visibility;
}

BakeResult bakeVisibility(const BakePlan& plan, const BakeOptions& options, const BakeTarget& target, int threads,
                          ProgressStyle progress) {
    const auto start = std::chrono::steady_clock::now();
    // 1. The journal of a bake that was stopped gives its frames back; they only have to be written.
    BakeJournal journal(target.output, plan.header, options.precision, target.journal);
    VisibilityWriter writer(target.output, plan.header, options.precision);
    RayCount count(progress, plan.rays());
    BakeResult result;
    const auto store = [&](const VisibilityFrame& frame) {
        writer.writeFrame(frame);
        result.open_share += openShare(plan.header, frame) / double(plan.header.frames.frameCount());
        if (!plan.header.hasBounces()) return;
        result.hit_share += double(frame.hit_shares[0]) / double(plan.header.frames.frameCount());
        result.back_share += double(frame.hit_shares[1]) / double(plan.header.frames.frameCount());
    };
    for (std::size_t f = 0; f < journal.framesKept(); ++f) {
        VisibilityFrame frame = poseVertices(plan, f);
        journal.read(f, frame);
        store(frame);
        count.add(0, frame.positions.size() * std::size_t(options.rays));
    }
    // 2. The other frames are traced. A frame goes to the journal before it goes to the output.
    traceFrames(plan, options, journal.framesKept(), threads, count, [&](const VisibilityFrame& frame) {
        journal.append(frame);
        store(frame);
    });
    // 3. The output takes its name when it is whole, and then the journal can go.
    count.finish();
    writer.finish();
    journal.finish();
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    result.rays_traced = count.traced();
    result.seconds = elapsed.count();
    result.written_bytes = double(std::filesystem::file_size(target.output));
    result.frames_kept = journal.framesKept();
    result.note = journal.note();
    return result;
}

bool isWhole(const std::filesystem::path& output, const BakePlan& plan, std::string& damage) {
    std::error_code error;
    if (!std::filesystem::exists(output, error)) return false;
    try {
        const VisibilityReader reader(output);
        if (toJson(reader.header().provenance) != toJson(plan.header.provenance)) return false;
        checkFrames(reader);
        return true;
    } catch (const Interrupted&) {
        throw;
    } catch (const std::exception& problem) {
        damage = problem.what();  // whatever is wrong, the bake replaces the file
        return false;
    }
}

}  // namespace penumbra
