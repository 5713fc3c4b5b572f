#include "formats/visibility_file.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "formats/errors.h"
#include "formats/fp16.h"
#include "formats/stage_parts.h"
#include "formats/write_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

constexpr FileKind kKind{"penumbra.visibility", kVisibilityVersion};
constexpr const char* kCoefficients = "/visibility/coefficients";

// Frames are written in blocks, and a chunk is a block of frames of a few vertices: all frames of a vertex lie
// together, which compresses twice as well as frame by frame and is what a fit reads.
constexpr hsize_t kBlockFrames = 64;
constexpr std::size_t kBlockBytes = std::size_t(96) << 20;  // at most, unless a single frame is larger
constexpr hsize_t kChunkVertices = 64;

// --- Writing --------------------------------------------------------------------------------------------------------

// One dataset [F, ...] that grows by blocks of frames.
struct FrameStream {
    Hdf5Handle dataset;
    std::vector<hsize_t> shape;  // [F, ...]
    bool half = false;
    std::vector<float> block;
};

struct VisibilityWriter::Impl {
    PartialFile partial;
    VisibilityHeader header;
    Precision precision;
    Hdf5Handle file;
    FrameStream positions, normals, bones, pose, coefficients;
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
};

FrameStream VisibilityWriter::Impl::openStream(const std::string& dataset, std::vector<hsize_t> shape,
                                               hsize_t chunk_vertices, bool half) {
    std::vector<hsize_t> chunk = shape;
    chunk[0] = block_frames;
    chunk[1] = std::min(chunk[1], chunk_vertices);
    const Hdf5Handle half_type = halfType();
    return {createDataset(file, dataset, half ? hid_t(half_type) : H5T_IEEE_F32LE, shape, chunk), shape, half, {}};
}

// Writes the frames in the block, which end with frame `frames_written`.
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

static void writeShard(hid_t file, const ShardPlace& shard) {
    const auto write = [&](const char* dataset, const std::vector<std::uint32_t>& values) {
        writeIntegers(file, dataset, std::vector<std::int64_t>(values.begin(), values.end()), {values.size()},
                      H5T_STD_U32LE);
    };
    writeStrings(file, "/shard/clip_names", shard.clip_names);
    write("/shard/clip_frames", shard.clip_frames);
    write("/shard/frame_in_clip", shard.frame_in_clip);
}

static void writeHeader(hid_t file, const VisibilityHeader& header) {
    writeRoot(file, kKind, header.order, header.provenance);
    writeTextAttribute(file, "/", "quantity", header.quantity);
    writeTextAttribute(file, "/", "frame", "model");
    writeIntegerAttribute(file, "/", "rays", header.rays);
    if (header.seed > std::uint64_t(INT64_MAX)) throw UsageError("seed: larger than 2^63 - 1");
    writeIntegerAttribute(file, "/", "seed", std::int64_t(header.seed));
    writeIntegerAttribute(file, "/", "bounces", header.bounces);
    if (header.ground_y) writeNumberAttribute(file, "/", "ground_y", *header.ground_y);
    writeMesh(file, header.mesh, header.rest_normals);
    if (header.skin) writeSkin(file, *header.skin);
    writeFrameList(file, header.frames);
    if (header.shard) writeShard(file, *header.shard);
}

VisibilityWriter::VisibilityWriter(const std::filesystem::path& path, const VisibilityHeader& header,
                                   Precision precision)
    : impl_(std::make_unique<Impl>(path, header, precision)) {
    const hsize_t frames = header.frames.frameCount(), vertices = header.mesh.vertexCount();
    const hsize_t joints = header.skin ? header.skin->jointCount() : 0, pose_size = hsize_t(header.pose_size);
    assert(frames > 0 && vertices > 0 && header.order >= 1 && header.order <= kMaxOrder);
    assert(header.rest_normals.size() == vertices && header.frames.clip.size() == frames);
    writeHeader(impl_->file, header);
    const std::size_t frame_bytes =
        sizeof(float) * (vertices * (6 + header.coefficientCount()) + 12 * joints + pose_size);
    impl_->block_frames = std::clamp<hsize_t>(kBlockBytes / frame_bytes, 1, std::min(kBlockFrames, frames));
    impl_->positions = impl_->openStream("/frames/positions", {frames, vertices, 3}, 4 * kChunkVertices, false);
    impl_->normals = impl_->openStream("/frames/normals", {frames, vertices, 3}, 4 * kChunkVertices, false);
    if (joints > 0) impl_->bones = impl_->openStream("/frames/bones", {frames, joints, 3, 4}, joints, false);
    if (pose_size > 0) {
        impl_->pose = impl_->openStream("/frames/pose", {frames, pose_size}, pose_size, false);
        writeTextAttribute(impl_->file, "/frames/pose", "parameterisation", header.pose_parameterisation);
    }
    impl_->coefficients = impl_->openStream(kCoefficients, {frames, vertices, header.coefficientCount()},
                                            kChunkVertices, precision == Precision::kFloat16);
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
    const auto append = [&](FrameStream& stream, std::span<const float> values) {
        // Readers refuse such numbers.
        if (!std::all_of(values.begin(), values.end(), [](float value) { return std::isfinite(value); }))
            throw std::runtime_error("frame " + std::to_string(out.frames_written) +
                                     ": the result is not a finite number");
        stream.block.insert(stream.block.end(), values.begin(), values.end());
    };
    append(out.positions, floatsOf(frame.positions));
    append(out.normals, floatsOf(frame.normals));
    append(out.bones, floatsOf(frame.bones));
    append(out.pose, frame.pose);
    append(out.coefficients, frame.coefficients);
    ++out.frames_written;
    if (out.frames_written % out.block_frames != 0 && out.frames_written != frames) return;
    for (FrameStream* stream : {&out.positions, &out.normals, &out.bones, &out.pose, &out.coefficients})
        out.flush(*stream);
}

void VisibilityWriter::finish() {
    Impl& out = *impl_;
    assert(out.frames_written == out.header.frames.frameCount());
    for (FrameStream* stream : {&out.positions, &out.normals, &out.bones, &out.pose, &out.coefficients})
        stream->dataset.close(out.what);
    closeHdf5(out.file);
    out.partial.commit();
}

// --- Reading --------------------------------------------------------------------------------------------------------

struct VisibilityReader::Impl {
    Hdf5Reader in;
    VisibilityHeader header;
    Hdf5Dataset positions, normals, bones, pose, coefficients;
    bool has_bones = false, has_pose = false;
    std::once_flag by_frame;  // set when coefficients are read by frame; by vertex range they need no cache
};

// Every frame is one of the sampled frames of a clip, in ascending order.
static ShardPlace readShard(const Hdf5Reader& in, const FrameList& frames) {
    ShardPlace shard;
    shard.clip_names = readStrings(in, "/shard/clip_names");
    checkUnique(in, "/shard/clip_names", shard.clip_names);
    std::vector<hsize_t> shape{shard.clip_names.size()};
    std::vector<std::int64_t> values = readIntegers(in, "/shard/clip_frames", shape, 0, INT32_MAX);
    shard.clip_frames.assign(values.begin(), values.end());
    shape = {frames.frameCount()};
    values = readIntegers(in, "/shard/frame_in_clip", shape, 0, INT32_MAX);
    shard.frame_in_clip.assign(values.begin(), values.end());
    std::vector<int> clips;
    for (const std::string& name : frames.clip_names) {
        clips.push_back(shard.clipNamed(name));
        if (clips.back() < 0) throw InvalidInput(in.name + ": /shard/clip_names: no clip '" + name + "'");
    }
    for (std::size_t f = 0; f < frames.frameCount(); ++f) {
        const bool follows = f > 0 && frames.clip[f] == frames.clip[f - 1];
        if (shard.frame_in_clip[f] >= shard.clip_frames[std::size_t(clips[frames.clip[f]])] ||
            (follows && shard.frame_in_clip[f] <= shard.frame_in_clip[f - 1]))
            throw InvalidInput(in.name + ": /shard/frame_in_clip: entry " + std::to_string(f) +
                               " is beyond the clip or not ascending");
    }
    return shard;
}

static VisibilityHeader readHeader(const Hdf5Reader& in) {
    VisibilityHeader header;
    header.order = readRoot(in, kKind, header.provenance);
    header.quantity = readTextAttribute(in, "/", "quantity");
    if (header.quantity != "hemisphere_visibility" && header.quantity != "mirrored_visibility")
        throw Unsupported(in.name + ": attribute quantity: \"" + header.quantity + "\" is unknown");
    if (const std::string frame = readTextAttribute(in, "/", "frame"); frame != "model")
        throw Unsupported(in.name + ": attribute frame: \"" + frame + "\", not \"model\"");
    header.rays = int(readIntegerAttribute(in, "/", "rays", 0, INT32_MAX));
    header.seed = std::uint64_t(readIntegerAttribute(in, "/", "seed", 0, INT64_MAX));
    header.bounces = int(readIntegerAttribute(in, "/", "bounces", 0, INT32_MAX));
    if (hasAttribute(in, "/", "ground_y")) header.ground_y = float(readNumberAttribute(in, "/", "ground_y"));
    header.mesh = readMesh(in);
    const std::size_t vertices = header.mesh.vertexCount();
    // Files of others may lack them: they are not in the published layout.
    header.rest_normals = exists(in, "/mesh/rest_normals")
                              ? readVectors(in, "/mesh/rest_normals", vertices)
                              : vertexNormals(header.mesh.triangles, header.mesh.rest_positions);
    if (exists(in, "/skin")) header.skin = readSkin(in, vertices);
    header.frames = readFrameList(in);
    if (exists(in, "/shard")) header.shard = readShard(in, header.frames);
    return header;
}

VisibilityReader::VisibilityReader(const std::filesystem::path& path) : impl_(std::make_unique<Impl>()) {
    Impl& file = *impl_;
    file.in = openHdf5(path);
    file.header = readHeader(file.in);
    const hsize_t frames = file.header.frames.frameCount(), vertices = file.header.mesh.vertexCount();
    std::vector<hsize_t> shape{frames, vertices, 3};
    file.positions = openFloats(file.in, "/frames/positions", shape);
    file.normals = openFloats(file.in, "/frames/normals", shape);
    file.has_bones = file.header.skin.has_value();
    if (file.has_bones) {
        shape = {frames, file.header.skin->jointCount(), 3, 4};
        file.bones = openFloats(file.in, "/frames/bones", shape);
    }
    file.has_pose = exists(file.in, "/frames/pose");
    if (file.has_pose) {
        shape = {frames, 0};
        file.pose = openFloats(file.in, "/frames/pose", shape);
        if (shape[1] > INT32_MAX) throw InvalidInput(file.pose.label + ": too many numbers a frame");
        file.header.pose_size = int(shape[1]);
        file.header.pose_parameterisation = readTextAttribute(file.in, "/frames/pose", "parameterisation");
    }
    cacheOneFrame(file.in, "/frames/positions", file.positions);
    cacheOneFrame(file.in, "/frames/normals", file.normals);
    if (file.has_bones) cacheOneFrame(file.in, "/frames/bones", file.bones);
    if (file.has_pose) cacheOneFrame(file.in, "/frames/pose", file.pose);
    shape = {frames, vertices, file.header.coefficientCount()};
    file.coefficients = openFloats(file.in, kCoefficients, shape);
}

VisibilityReader::~VisibilityReader() = default;

Precision VisibilityReader::precision() const {
    return impl_->coefficients.half ? Precision::kFloat16 : Precision::kFloat32;
}

const VisibilityHeader& VisibilityReader::header() const { return impl_->header; }

static void readFrameOf(const Hdf5Dataset& dataset, std::size_t frame, std::span<float> out) {
    std::vector<hsize_t> begin(dataset.shape.size(), 0), count = dataset.shape;
    begin[0] = frame;
    count[0] = 1;
    readPart(dataset, begin, count, out);
}

VisibilityFrame VisibilityReader::readPose(std::size_t frame) const {
    const Impl& file = *impl_;
    assert(frame < file.header.frames.frameCount());
    VisibilityFrame out;
    out.positions.resize(file.header.mesh.vertexCount());
    out.normals.resize(file.header.mesh.vertexCount());
    readFrameOf(file.positions, frame, floatsOf(out.positions));
    readFrameOf(file.normals, frame, floatsOf(out.normals));
    if (file.has_bones) {
        out.bones.resize(file.header.skin->jointCount());
        readFrameOf(file.bones, frame, floatsOf(out.bones));
    }
    out.pose.resize(std::size_t(file.header.pose_size));
    if (file.has_pose) readFrameOf(file.pose, frame, out.pose);
    return out;
}

VisibilityFrame VisibilityReader::readFrame(std::size_t frame) const {
    std::call_once(impl_->by_frame, [&] { cacheOneFrame(impl_->in, kCoefficients, impl_->coefficients); });
    VisibilityFrame out = readPose(frame);
    out.coefficients.resize(impl_->header.mesh.vertexCount() * impl_->header.coefficientCount());
    readFrameOf(impl_->coefficients, frame, out.coefficients);
    return out;
}

void VisibilityReader::readVertices(std::size_t begin, std::size_t end, std::span<float> out) const {
    const std::vector<hsize_t>& shape = impl_->coefficients.shape;
    assert(begin <= end && end <= shape[1] && out.size() == shape[0] * (end - begin) * shape[2]);
    readPart(impl_->coefficients, {0, begin, 0}, {shape[0], end - begin, shape[2]}, out);
}

}  // namespace penumbra
