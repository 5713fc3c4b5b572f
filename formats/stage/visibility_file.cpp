// Writes x.vis.h5.
#include "formats/stage/visibility_file.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <stdexcept>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_header.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

// Frames are written in blocks, and a chunk is a block of frames of a few vertices. All frames of a vertex then lie
// together, which compresses twice as well as frame by frame, and is what a fit reads.
constexpr hsize_t kBlockFrames = 64;
constexpr std::size_t kBlockBytes = std::size_t(96) << 20;  // at most this, unless a single frame is larger
constexpr hsize_t kChunkVertices = 64;

// One dataset [F, ...] that grows by blocks of frames.
struct FrameStream {
    Hdf5Handle dataset;
    std::vector<hsize_t> shape;  // [F, ...]
    bool half = false;
    std::vector<float> block;
};

}  // namespace

struct VisibilityWriter::Impl {
    PartialFile partial;
    VisibilityHeader header;
    Precision precision;
    Hdf5Handle file;
    FrameStream positions, normals, bones, pose, coefficients, local, indirect, hit_shares;
    std::size_t block_frames = 1, frames_written = 0;
    std::string what;  // starts messages

    Impl(const std::filesystem::path& path, const VisibilityHeader& visibility_header, Precision coefficient_precision)
        : partial(path),
          header(visibility_header),
          precision(coefficient_precision),
          file(createHdf5(partial.path())),
          what(path.string() + ": cannot write") {}
    FrameStream openStream(const std::string& dataset, std::vector<hsize_t> shape, hsize_t chunk_vertices, bool half);
    void flush(FrameStream& stream);
    std::array<FrameStream*, 8> streams() {
        return {&positions, &normals, &bones, &pose, &coefficients, &local, &indirect, &hit_shares};
    }
};

FrameStream VisibilityWriter::Impl::openStream(const std::string& dataset, std::vector<hsize_t> shape,
                                               hsize_t chunk_vertices, bool half) {
    std::vector<hsize_t> chunk = shape;
    chunk[0] = block_frames;
    chunk[1] = std::min(chunk[1], chunk_vertices);
    const Hdf5Handle half_type = halfType();
    return {createDataset(file, dataset, half ? hid_t(half_type) : H5T_IEEE_F32LE, shape, chunk), shape, half, {}};
}

// Writes the frames of the block, the last of which is the frame before `frames_written`.
void VisibilityWriter::Impl::flush(FrameStream& stream) {
    if (stream.block.empty()) return;
    std::size_t frame_size = 1;
    for (std::size_t axis = 1; axis < stream.shape.size(); ++axis) frame_size *= stream.shape[axis];
    std::vector<hsize_t> begin(stream.shape.size(), 0), count = stream.shape;
    count[0] = stream.block.size() / frame_size;
    begin[0] = frames_written - count[0];
    const Hdf5Handle memory(H5Screate_simple(int(count.size()), count.data(), nullptr), H5Sclose, what);
    const Hdf5Handle space(H5Dget_space(stream.dataset), H5Sclose, what);
    checkHdf5(H5Sselect_hyperslab(space, H5S_SELECT_SET, begin.data(), nullptr, count.data(), nullptr), what);
    if (stream.half) {
        std::vector<std::uint16_t> halves(stream.block.size());
        floatToHalf(stream.block, halves);
        checkHdf5(H5Dwrite(stream.dataset, halfType(), memory, space, H5P_DEFAULT, halves.data()), what);
    } else {
        checkHdf5(H5Dwrite(stream.dataset, H5T_NATIVE_FLOAT, memory, space, H5P_DEFAULT, stream.block.data()), what);
    }
    stream.block.clear();
}

std::size_t framesOfBlock(const VisibilityHeader& header) {
    const std::size_t joints = header.skin ? header.skin->jointCount() : 0;
    const std::size_t frame_bytes = sizeof(float) * (header.mesh.vertexCount() * (6 + header.coefficientsOfVertex()) +
                                                     12 * joints + std::size_t(header.pose_size));
    return std::clamp<hsize_t>(kBlockBytes / frame_bytes, 1,
                               std::min<hsize_t>(kBlockFrames, header.frames.frameCount()));
}

VisibilityWriter::VisibilityWriter(const std::filesystem::path& path, const VisibilityHeader& header,
                                   Precision precision)
    : impl_(std::make_unique<Impl>(path, header, precision)) {
    const hsize_t frames = header.frames.frameCount(), vertices = header.mesh.vertexCount();
    const hsize_t joints = header.skin ? header.skin->jointCount() : 0, pose_size = hsize_t(header.pose_size);
    assert(frames > 0 && vertices > 0 && header.order >= 1 && header.order <= kMaxOrder);
    assert(header.rest_normals.size() == vertices && header.frames.clip.size() == frames);
    writeVisibilityHeader(impl_->file, header);
    impl_->block_frames = framesOfBlock(header);
    impl_->positions = impl_->openStream("/frames/positions", {frames, vertices, 3}, 4 * kChunkVertices, false);
    impl_->normals = impl_->openStream("/frames/normals", {frames, vertices, 3}, 4 * kChunkVertices, false);
    if (joints > 0) impl_->bones = impl_->openStream("/frames/bones", {frames, joints, 3, 4}, joints, false);
    if (pose_size > 0) {
        impl_->pose = impl_->openStream("/frames/pose", {frames, pose_size}, pose_size, false);
        writeTextAttribute(impl_->file, "/frames/pose", "parameterisation", header.pose_parameterisation);
    }
    impl_->coefficients = impl_->openStream(kCoefficients, {frames, vertices, header.coefficientCount()},
                                            kChunkVertices, precision == Precision::kFloat16);
    if (header.hasBounces()) {
        impl_->indirect = impl_->openStream(kIndirect, {frames, vertices, 3, header.coefficientCount()}, kChunkVertices,
                                            precision == Precision::kFloat16);
        impl_->hit_shares = impl_->openStream(kHitShares, {frames, 2}, 2, false);
    }
    if (!header.local) return;
    impl_->local = impl_->openStream(kLocal, {frames, vertices, header.local->coefficientCount()}, kChunkVertices,
                                     precision == Precision::kFloat16);
    writeLocalAttributes(impl_->file, *header.local);
}

VisibilityWriter::~VisibilityWriter() = default;

void VisibilityWriter::writeFrame(const VisibilityFrame& frame) {
    throwIfInterrupted();
    Impl& out = *impl_;
    [[maybe_unused]] const std::size_t vertices = out.header.mesh.vertexCount();
    const std::size_t frames = out.header.frames.frameCount();
    assert(out.frames_written < frames && frame.positions.size() == vertices && frame.normals.size() == vertices);
    assert(frame.bones.size() == (out.header.skin ? out.header.skin->jointCount() : 0));
    assert(frame.pose.size() == std::size_t(out.header.pose_size));
    assert(frame.coefficients.size() == vertices * out.header.coefficientCount());
    assert(frame.local_coefficients.size() == (out.header.local ? vertices * out.header.local->coefficientCount() : 0));
    assert(frame.indirect.size() == vertices * out.header.indirectCount());
    assert(frame.hit_shares.size() == (out.header.hasBounces() ? 2 : 0));
    const auto append = [&](FrameStream& stream, std::span<const float> values) {
        // Readers refuse such numbers.
        if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); }))
            throw std::runtime_error("frame " + std::to_string(out.frames_written) +
                                     ": the result is not a finite number");
        if (stream.block.empty()) stream.block.reserve(values.size() * out.block_frames);
        stream.block.insert(stream.block.end(), values.begin(), values.end());
    };
    append(out.positions, floatsOf(frame.positions));
    append(out.normals, floatsOf(frame.normals));
    append(out.bones, floatsOf(frame.bones));
    append(out.pose, frame.pose);
    append(out.coefficients, frame.coefficients);
    append(out.local, frame.local_coefficients);
    append(out.indirect, frame.indirect);
    append(out.hit_shares, frame.hit_shares);
    ++out.frames_written;
    if (out.frames_written % out.block_frames != 0 && out.frames_written != frames) return;
    for (FrameStream* stream : out.streams()) out.flush(*stream);
}

void VisibilityWriter::finish() {
    Impl& out = *impl_;
    assert(out.frames_written == out.header.frames.frameCount());
    for (FrameStream* stream : out.streams()) stream->dataset.close(out.what);
    closeHdf5(out.file);
    out.partial.commit();
}

}  // namespace penumbra
