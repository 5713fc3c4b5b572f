// Reads x.vis.h5: its own frames, or those of the files that a virtual one names (formats/README.md).
#include <algorithm>
#include <cassert>
#include <mutex>

#include "formats/common/errors.h"
#include "formats/common/parallel_for.h"
#include "formats/common/sha256.h"
#include "formats/common/write_file.h"
#include "formats/stage/visibility_check.h"
#include "formats/stage/visibility_header.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// The frames that one file holds.
struct FrameStore {
    Hdf5Reader in;
    Hdf5Dataset positions, normals, bones, pose, coefficients, local, indirect, hit_shares;
    bool has_bones = false, has_pose = false;
    std::once_flag by_frame;  // set when coefficients are read by frame; reading by vertex range needs no cache
    std::size_t frames() const { return coefficients.shape[0]; }
};
struct VertexRange {
    std::size_t begin, end;
};

}  // namespace

struct VisibilityReader::Impl {
    VisibilityHeader header;
    std::vector<std::unique_ptr<FrameStore>> stores;
    std::vector<FrameSource> source;  // [F] only for a virtual file; empty: frame f is frame f of the only store

    void openSources(const Hdf5Reader& in, const fs::path& path);
    FrameStore& storeOf(std::size_t& frame) const;  // turns `frame` of the whole into that of the store
    void readRange(Hdf5Dataset FrameStore::*dataset, VertexRange range, std::size_t per_vertex,
                   std::span<float> out) const;
};

namespace {

// Opens the frames of a file. `frames` 0 accepts any number of them.
std::unique_ptr<FrameStore> openFrames(Hdf5Reader in, const VisibilityHeader& header, hsize_t frames) {
    auto store = std::make_unique<FrameStore>();
    store->in = std::move(in);
    const hsize_t vertices = header.mesh.vertexCount();
    std::vector<hsize_t> shape{frames, vertices, 3};
    store->positions = openFloats(store->in, "/frames/positions", shape);
    frames = shape[0];
    store->normals = openFloats(store->in, "/frames/normals", shape);
    store->has_bones = header.skin.has_value();
    if (store->has_bones) {
        shape = {frames, header.skin->jointCount(), 3, 4};
        store->bones = openFloats(store->in, "/frames/bones", shape);
    }
    store->has_pose = exists(store->in, "/frames/pose");
    if (store->has_pose) {
        shape = {frames, 0};
        store->pose = openFloats(store->in, "/frames/pose", shape);
        if (shape[1] > INT32_MAX) throw InvalidInput(store->pose.label + ": too many numbers a frame");
    }
    cacheOneFrame(store->in, "/frames/positions", store->positions);
    cacheOneFrame(store->in, "/frames/normals", store->normals);
    if (store->has_bones) cacheOneFrame(store->in, "/frames/bones", store->bones);
    if (store->has_pose) cacheOneFrame(store->in, "/frames/pose", store->pose);
    shape = {frames, vertices, header.coefficientCount()};
    store->coefficients = openFloats(store->in, kCoefficients, shape);
    if (header.local) {
        shape = {frames, vertices, header.local->coefficientCount()};
        store->local = openFloats(store->in, kLocal, shape);
    }
    if (header.hasBounces()) {
        shape = {frames, vertices, 3, header.coefficientCount()};
        store->indirect = openFloats(store->in, kIndirect, shape);
        shape = {frames, 2};
        store->hit_shares = openFloats(store->in, kHitShares, shape);
    }
    return store;
}

// --- Virtual files --------------------------------------------------------------------------------------------------
// HDF5 shows other programs the frames of the other files, and silently shows fill values where one is missing. We
// follow our own list instead, and refuse a file that is not what it was.

// Checks the files. It names the first file in order that is wrong, whichever thread sees it first.
void checkSources(const std::vector<fs::path>& files, const std::vector<std::string>& sha256, const std::string& who) {
    std::error_code error;
    for (const fs::path& file : files)
        if (!fs::is_regular_file(file, error))
            throw IoError(who + ": " + file.string() + " with some of its frames is missing");
    std::vector<std::string> found(files.size());
    parallelFor(files.size(), 0, [&](std::size_t i) { found[i] = sha256OfFile(files[i]); });
    for (std::size_t i = 0; i < files.size(); ++i)
        if (found[i] != sha256[i])
            throw InvalidInput(who + ": " + files[i].string() + " with some of its frames has changed; merge again");
}

}  // namespace

void VisibilityReader::Impl::openSources(const Hdf5Reader& in, const fs::path& path) {
    const std::vector<std::string> names = readStrings(in, "/virtual/files"), sums = readStrings(in, "/virtual/sha256");
    if (names.empty() || sums.size() != names.size()) throw InvalidInput(in.name + ": /virtual/sha256: not one a file");
    std::vector<fs::path> files;
    const fs::path folder = fs::canonical(path).parent_path();  // the folder that a link to the index leads to
    for (const std::string& name : names) files.push_back(folder / name);
    checkSources(files, sums, in.name);
    for (const fs::path& source_file : files) {
        Hdf5Reader shard = openHdf5(source_file);
        if (exists(shard, "/virtual")) throw InvalidInput(shard.name + ": is virtual itself");
        stores.push_back(openFrames(std::move(shard), header, 0));
    }
    const std::size_t frames = header.frames.frameCount();
    const std::vector<std::uint32_t> of_file = readIndices(in, "/virtual/file_of_frame", frames, names.size());
    const std::vector<std::uint32_t> in_file = readIndices(in, "/virtual/frame_in_file", frames, UINT32_MAX);
    for (std::size_t f = 0; f < frames; ++f) {
        if (in_file[f] >= stores[of_file[f]]->frames())
            throw InvalidInput(in.name + ": /virtual/frame_in_file: entry " + std::to_string(f) +
                               " is beyond the file");
        source.push_back({of_file[f], in_file[f]});
    }
}

// --- The reader -----------------------------------------------------------------------------------------------------

VisibilityReader::VisibilityReader(const fs::path& path) : impl_(std::make_unique<Impl>()) {
    Impl& file = *impl_;
    Hdf5Reader in = openHdf5(path);
    file.header = readVisibilityHeader(in);
    const bool has_pose = exists(in, "/frames/pose");
    if (has_pose) file.header.pose_parameterisation = readTextAttribute(in, "/frames/pose", "parameterisation");
    if (exists(in, "/virtual"))
        file.openSources(in, path);
    else
        file.stores.push_back(openFrames(std::move(in), file.header, file.header.frames.frameCount()));
    for (const auto& store : file.stores) {
        const std::size_t size = store->has_pose ? store->pose.shape[1] : 0;
        if (store != file.stores.front() && size != std::size_t(file.header.pose_size))
            throw InvalidInput(store->in.name + ": /frames/pose: has another size than in other files");
        file.header.pose_size = int(size);
    }
    checkPose(path.string(), file.header);
}

VisibilityReader::~VisibilityReader() = default;

Precision VisibilityReader::precision() const {
    return impl_->stores[0]->coefficients.half ? Precision::kFloat16 : Precision::kFloat32;
}

bool VisibilityReader::isVirtual() const { return !impl_->source.empty(); }

const VisibilityHeader& VisibilityReader::header() const { return impl_->header; }

namespace {

void readFrameOf(const Hdf5Dataset& dataset, std::size_t frame, std::span<float> out) {
    std::vector<hsize_t> begin(dataset.shape.size(), 0), count = dataset.shape;
    begin[0] = frame;
    count[0] = 1;
    readPart(dataset, begin, count, out);
}

}  // namespace

FrameStore& VisibilityReader::Impl::storeOf(std::size_t& frame) const {
    assert(frame < header.frames.frameCount());
    if (source.empty()) return *stores[0];
    const FrameSource found = source[frame];
    frame = found.frame;
    return *stores[found.file];
}

VisibilityFrame VisibilityReader::readPose(std::size_t frame) const {
    const VisibilityHeader& header = impl_->header;
    const FrameStore& store = impl_->storeOf(frame);
    VisibilityFrame out;
    out.positions.resize(header.mesh.vertexCount());
    out.normals.resize(header.mesh.vertexCount());
    readFrameOf(store.positions, frame, floatsOf(out.positions));
    readFrameOf(store.normals, frame, floatsOf(out.normals));
    if (store.has_bones) {
        out.bones.resize(header.skin->jointCount());
        readFrameOf(store.bones, frame, floatsOf(out.bones));
    }
    out.pose.resize(std::size_t(header.pose_size));
    if (store.has_pose) readFrameOf(store.pose, frame, out.pose);
    return out;
}

VisibilityFrame VisibilityReader::readFrame(std::size_t frame) const {
    VisibilityFrame out = readPose(frame);
    FrameStore& store = impl_->storeOf(frame);
    const VisibilityHeader& header = impl_->header;
    std::call_once(store.by_frame, [&] {
        cacheOneFrame(store.in, kCoefficients, store.coefficients);
        if (header.local) cacheOneFrame(store.in, kLocal, store.local);
        if (header.hasBounces()) cacheOneFrame(store.in, kIndirect, store.indirect);
    });
    out.coefficients.resize(header.mesh.vertexCount() * header.coefficientCount());
    readFrameOf(store.coefficients, frame, out.coefficients);
    if (header.hasBounces()) {
        out.indirect.resize(header.mesh.vertexCount() * header.indirectCount());
        out.hit_shares.resize(2);
        readFrameOf(store.indirect, frame, out.indirect);
        readFrameOf(store.hit_shares, frame, out.hit_shares);
    }
    if (header.local) {
        out.local_coefficients.resize(header.mesh.vertexCount() * header.local->coefficientCount());
        readFrameOf(store.local, frame, out.local_coefficients);
    }
    return out;
}

// Reads vertices [begin, end) of one dataset in all frames. `per_vertex` is what it has of each vertex.
void VisibilityReader::Impl::readRange(Hdf5Dataset FrameStore::*dataset, VertexRange range, std::size_t per_vertex,
                                       std::span<float> out) const {
    const std::size_t width = range.end - range.begin, row = width * per_vertex;
    assert(range.begin <= range.end && range.end <= header.mesh.vertexCount());
    assert(out.size() == header.frames.frameCount() * row);
    const auto read = [&](const FrameStore& store, std::span<float> values) {
        std::vector<hsize_t> begin((store.*dataset).shape.size(), 0), count = (store.*dataset).shape;
        begin[1] = range.begin;
        count[1] = width;
        readPart(store.*dataset, begin, count, values);
    };
    if (source.empty()) return read(*stores[0], out);
    std::vector<float> part;
    for (std::uint32_t s = 0; s < stores.size(); ++s) {
        part.resize(stores[s]->frames() * row);
        read(*stores[s], part);
        for (std::size_t f = 0; f < source.size(); ++f)
            if (source[f].file == s) std::copy_n(&part[source[f].frame * row], row, &out[f * row]);
    }
}

void VisibilityReader::readVertices(std::size_t begin, std::size_t end, std::span<float> out) const {
    impl_->readRange(&FrameStore::coefficients, {begin, end}, impl_->header.coefficientCount(), out);
}

void VisibilityReader::readLocalVertices(std::size_t begin, std::size_t end, std::span<float> out) const {
    assert(impl_->header.local);
    impl_->readRange(&FrameStore::local, {begin, end}, impl_->header.local->coefficientCount(), out);
}

void VisibilityReader::readIndirectVertices(std::size_t begin, std::size_t end, std::span<float> out) const {
    assert(impl_->header.hasBounces());
    impl_->readRange(&FrameStore::indirect, {begin, end}, impl_->header.indirectCount(), out);
}

std::array<float, 2> VisibilityReader::readHitShares(std::size_t frame) const {
    assert(impl_->header.hasBounces());
    const FrameStore& store = impl_->storeOf(frame);
    std::array<float, 2> shares{};
    readFrameOf(store.hit_shares, frame, shares);
    return shares;
}

void checkFrames(const VisibilityReader& reader) {
    for (std::size_t f = 0; f < reader.header().frames.frameCount(); ++f) {
        throwIfInterrupted();
        (void)reader.readFrame(f);
    }
}

}  // namespace penumbra
