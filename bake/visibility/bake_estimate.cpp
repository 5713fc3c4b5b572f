// Estimates the time, the bytes and the memory of a bake.
//
// Problem: tell before a bake of hours how long it will take and how big its file will be. Both depend on the scene:
// on how many rays miss, on how long the way through the tree is, and on how well the coefficients compress.
//
// Naive: trace the first frame and multiply. The first frame of a clip is often the pose at rest, and a single frame
// does not show how well consecutive frames compress together.
//
// Here: probe a few runs of consecutive frames that are spread over the whole list. In every frame the same few
// blocks of vertices are traced, and each run is stored as the writer would store it. Figures are processor time, so
// that other programs on the machine do not change them.
#include "bake/visibility/bake_estimate.h"

#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <ctime>

#include "bake/visibility/bake_transfer.h"
#include "formats/common/parallel_for.h"
#include "formats/common/write_file.h"
#include "formats/stage/stored_size.h"

namespace penumbra {
namespace {

using std::chrono::steady_clock;

// Seconds of processor time. Other programs change neither the number of frames nor the figures.
constexpr double kProbeSeconds = 8;
constexpr std::size_t kRuns = 4;        // places in the list of frames
constexpr std::size_t kRunFrames = 64;  // consecutive frames, as in the writer's blocks; fewer when the time is up
constexpr std::size_t kTasks = 8;       // blocks of vertices that a chunk of the file keeps together

// Returns the processor time of all threads of the process so far.
double processorSeconds() {
    timespec time{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

// Sums what was measured over all frames of the probe, in seconds of processor time.
struct ProbeSums {
    double frames = 0, pose_seconds = 0, trace_seconds = 0;  // tracing scaled up to all vertices
    double store_seconds = 0, stored_bytes = 0, stored_frames = 0;
    double row_bytes = 0, rows = 0;  // of the bounce matrices, which are kept for one frame at a time
};

// Chooses the vertices of the probe: kTasks blocks, spread evenly over all.
std::vector<std::size_t> probedTasks(std::size_t tasks) {
    std::vector<std::size_t> out;
    const std::size_t count = std::min(tasks, kTasks);
    for (std::size_t i = 0; i < count; ++i) out.push_back((2 * i + 1) * tasks / (2 * count));
    return out;
}

// Holds consecutive frames of the same vertices, one block of vertices after the other, as the writer's chunks have
// them.
struct RunOfFrames {
    std::vector<std::vector<float>> coefficients, local, indirect, positions, normals;  // of each probed block
    std::size_t frames = 0;
};

// Compresses a run as the writer would, and adds its time and its bytes, scaled up to all vertices.
void storeRun(const RunOfFrames& run, const BakePlan& plan, Precision precision, ProbeSums& sums) {
    const double start = processorSeconds();
    const std::size_t n2 = plan.header.coefficientCount();
    const std::size_t m2 = plan.header.local ? plan.header.local->coefficientCount() : 0;
    double bytes = 0, vertices = 0;
    for (std::size_t i = 0; i < run.coefficients.size(); ++i) {
        const std::size_t width = run.positions[i].size() / (3 * run.frames);
        bytes += storedSize(run.coefficients[i], {run.frames, width, n2}, precision) +
                 storedSize(run.positions[i], {run.frames, width, 3}, Precision::kFloat32) +
                 storedSize(run.normals[i], {run.frames, width, 3}, Precision::kFloat32);
        if (plan.header.hasBounces()) bytes += storedSize(run.indirect[i], {run.frames, width, 3, n2}, precision);
        if (m2 > 0) bytes += storedSize(run.local[i], {run.frames, width, m2}, precision);
        vertices += double(width);
    }
    const double all = double(plan.header.mesh.vertexCount()) / vertices;
    sums.store_seconds += all * (processorSeconds() - start);
    sums.stored_bytes += all * bytes;
    sums.stored_frames += double(run.frames);
}

void append(std::span<const float> values, std::vector<float>& out) {
    out.insert(out.end(), values.begin(), values.end());
}

// Bounces light between the probed vertices, and measures the rows of the bounce matrix. The vertices that were not
// traced have no rows, so that the time is that of the probed ones.
void probeBounces(const VisibilityHeader& header, const FrameBounces& bounces, int threads, VisibilityFrame& frame,
                  ProbeSums& sums) {
    addBounces(header, bounces, threads, frame);
    for (const BounceRow& row : bounces.rows) {
        sums.row_bytes += double(sizeof(BounceRow) + row.capacity() * sizeof(BounceEntry));
        sums.rows += row.empty() ? 0 : 1;
    }
}

// Poses one frame of the probe, traces its chosen vertices and appends them to the run.
void probeFrame(const BakePlan& plan, const BakeDirections& directions, std::size_t frame, int threads,
                RunOfFrames& run, ProbeSums& sums) {
    double start = processorSeconds();
    FrameScene posed = frameScene(plan, frame);
    sums.pose_seconds += processorSeconds() - start;
    const std::size_t vertices = posed.frame.positions.size();
    const std::vector<std::size_t> tasks = probedTasks((vertices + kVerticesPerTask - 1) / kVerticesPerTask);
    const MomentTracer tracer = tracerOf(plan, posed, directions);
    std::optional<FrameBounces> bounces;
    if (plan.header.quantity == kDiffuseTransfer) bounces.emplace(plan.header);
    const TracedFrame traced_frame{posed, tracer, bounces ? &*bounces : nullptr};
    const auto span = [&](std::size_t i) {
        const std::size_t begin = tasks[i] * kVerticesPerTask;
        return std::pair(begin, std::min(kVerticesPerTask, vertices - begin));
    };
    start = processorSeconds();
    parallelFor(tasks.size(), threads, [&](std::size_t i) {
        throwIfInterrupted();
        const auto [begin, size] = span(i);
        traceVertices(traced_frame, begin, size);
    });
    if (plan.header.hasBounces()) probeBounces(plan.header, *bounces, threads, posed.frame, sums);
    const double seconds = processorSeconds() - start;
    run.coefficients.resize(tasks.size());
    run.local.resize(tasks.size());
    run.indirect.resize(tasks.size());
    run.positions.resize(tasks.size());
    run.normals.resize(tasks.size());
    double traced = 0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
        const auto [begin, size] = span(i);
        traced += double(size);
        const auto add = [first = begin, count = size, vertices](std::span<const float> values,
                                                                 std::vector<float>& to) {
            const std::size_t each = values.size() / vertices;
            append(values.subspan(first * each, count * each), to);
        };
        add(posed.frame.coefficients, run.coefficients[i]);
        add(posed.frame.local_coefficients, run.local[i]);
        add(posed.frame.indirect, run.indirect[i]);
        append(std::span(&posed.frame.positions[begin].x, 3 * size), run.positions[i]);
        append(std::span(&posed.frame.normals[begin].x, 3 * size), run.normals[i]);
    }
    sums.trace_seconds += seconds * double(vertices) / traced;
    sums.frames += 1;
    ++run.frames;
}

// Runs the probe: kRuns runs of frames, each with its share of the time.
ProbeSums probe(const BakePlan& plan, const BakeOptions& options, int threads) {
    const double start = processorSeconds();
    const BakeDirections directions = makeBakeDirections(options, plan.rest_diagonal);
    const std::size_t frames = plan.header.frames.frameCount();
    const std::size_t length =
        std::min({kRunFrames, framesOfBlock(plan.header), std::max<std::size_t>(1, frames / kRuns)});
    const std::size_t runs = std::min(kRuns, frames / length);
    ProbeSums sums;
    for (std::size_t r = 0; r < runs; ++r) {
        RunOfFrames run;
        const std::size_t first = (2 * r + 1) * (frames - length) / (2 * runs);
        for (std::size_t f = first; f < first + length; ++f) {
            probeFrame(plan, directions, f, threads, run, sums);
            if (processorSeconds() - start > kProbeSeconds * double(r + 1) / double(runs)) break;
        }
        storeRun(run, plan, options.precision, sums);
        if (processorSeconds() - start > kProbeSeconds) break;
    }
    return sums;
}

}  // namespace

BakeEstimate estimateBake(const BakePlan& plan, const BakeOptions& options, int threads) {
    const auto start = steady_clock::now();
    const ProbeSums sums = probe(plan, options, threads);
    const VisibilityHeader& header = plan.header;
    const double frames = double(header.frames.frameCount()), vertices = double(header.mesh.vertexCount());
    const double moments = double(header.coefficientsOfVertex());
    const double frame_bytes = 4 * vertices * (6 + moments);
    const double matrix = sums.rows > 0 ? vertices * sums.row_bytes / sums.rows : 0;
    const double bounced = header.hasBounces() ? 2 * 4 * 3 * vertices * double(header.coefficientCount()) : 0;
    const int cores = std::min(threads > 0 ? threads : hardwareThreads(), hardwareThreads());
    // Writing and posing run beside the tracing, as two of its tasks.
    const double work =
        (sums.pose_seconds + sums.trace_seconds) / sums.frames + sums.store_seconds / sums.stored_frames;
    BakeEstimate out;
    out.seconds = frames * work / cores;
    const double small = plan.bytes(options.precision) -
                         frames * vertices * (24 + (options.precision == Precision::kFloat16 ? 2 : 4) * moments);
    out.bytes = frames * sums.stored_bytes / sums.stored_frames + small;
    rusage usage{};
    ::getrusage(RUSAGE_SELF, &usage);
    // The figure so far holds the rig and one frame with its tree. A bake adds two more frames, the block that it
    // writes, and with bounces the matrix of a frame and two copies of its transfer.
    const double tree = 150.0 * double(plan.blockers.triangles.size());
    const double halves = options.precision == Precision::kFloat16 ? 2 * vertices * moments : 0;
    out.memory = 1024.0 * double(usage.ru_maxrss) + 2 * (frame_bytes + tree) + matrix + bounced +
                 double(framesOfBlock(header)) * (frame_bytes + halves);
    out.journal = frames * vertices * moments * (options.precision == Precision::kFloat16 ? 2 : 4);
    out.probe_seconds = std::chrono::duration<double>(steady_clock::now() - start).count();
    return out;
}

}  // namespace penumbra
