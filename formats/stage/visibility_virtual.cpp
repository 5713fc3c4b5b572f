// Writes a virtual x.vis.h5: an index of frames that stay in their files.
#include <cassert>
#include <map>

#include "formats/common/write_file.h"
#include "formats/stage/visibility_header.h"

namespace penumbra {

namespace {

// Groups frames of one file that stand at equal distances in the whole. Each run becomes one HDF5 selection.
std::vector<Hdf5Run> runsOf(const VirtualSources& sources) {
    std::vector<Hdf5Run> runs;
    std::map<std::uint32_t, std::size_t> last;  // the run that each file's frames are added to
    for (std::size_t f = 0; f < sources.source.size(); ++f) {
        const FrameSource source = sources.source[f];
        if (const auto found = last.find(source.file); found != last.end()) {
            Hdf5Run& run = runs[found->second];
            const hsize_t step = f - (run.to + (run.count - 1) * run.stride);
            if (source.frame == run.from + run.count && (run.count == 1 || step == run.stride)) {
                run.stride = step;
                ++run.count;
                continue;
            }
        }
        last[source.file] = runs.size();
        runs.push_back({sources.files[source.file], sources.frames_of_file[source.file], source.frame, f, 1, 1});
    }
    return runs;
}

}  // namespace

void writeVirtualVisibility(const std::filesystem::path& path, const VisibilityHeader& header, Precision precision,
                            const VirtualSources& sources) {
    const hsize_t frames = header.frames.frameCount(), vertices = header.mesh.vertexCount();
    assert(sources.source.size() == frames && sources.files.size() == sources.sha256.size());
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeVisibilityHeader(file, header);
    writeStrings(file, "/virtual/files", sources.files);
    writeStrings(file, "/virtual/sha256", sources.sha256);
    std::vector<std::uint32_t> of_file, in_file;
    for (const FrameSource& source : sources.source) {
        of_file.push_back(source.file);
        in_file.push_back(source.frame);
    }
    writeIndices(file, "/virtual/file_of_frame", of_file);
    writeIndices(file, "/virtual/frame_in_file", in_file);
    const std::vector<Hdf5Run> runs = runsOf(sources);
    createVirtualDataset(file, "/frames/positions", H5T_IEEE_F32LE, {frames, vertices, 3}, runs);
    createVirtualDataset(file, "/frames/normals", H5T_IEEE_F32LE, {frames, vertices, 3}, runs);
    if (header.skin)
        createVirtualDataset(file, "/frames/bones", H5T_IEEE_F32LE, {frames, header.skin->jointCount(), 3, 4}, runs);
    if (header.pose_size > 0) {
        createVirtualDataset(file, "/frames/pose", H5T_IEEE_F32LE, {frames, hsize_t(header.pose_size)}, runs);
        writeTextAttribute(file, "/frames/pose", "parameterisation", header.pose_parameterisation);
    }
    const Hdf5Handle half = halfType();
    const hid_t type = precision == Precision::kFloat16 ? hid_t(half) : H5T_IEEE_F32LE;
    createVirtualDataset(file, kCoefficients, type, {frames, vertices, header.coefficientCount()}, runs);
    if (header.hasBounces()) {
        createVirtualDataset(file, kIndirect, type, {frames, vertices, 3, header.coefficientCount()}, runs);
        createVirtualDataset(file, kHitShares, H5T_IEEE_F32LE, {frames, 2}, runs);
    }
    if (header.local) {
        createVirtualDataset(file, kLocal, type, {frames, vertices, header.local->coefficientCount()}, runs);
        writeLocalAttributes(file, *header.local);
    }
    closeHdf5(file);
    partial.commit();
}

}  // namespace penumbra
