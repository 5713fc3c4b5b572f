// Writes ambient visibility, or positions, as an array of NumPy (format version 1.0), frame by frame.
#include <fstream>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/export/export_files.h"

namespace penumbra {

namespace {

// The header is a line of Python, padded so that the numbers begin at a multiple of 64 bytes.
std::string numpyHeader(const std::string& shape) {
    std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + shape + "), }";
    text.append(63 - (10 + text.size()) % 64, ' ');
    text += '\n';
    return std::string("\x93NUMPY\x01\x00", 8) + char(text.size() & 0xff) + char(text.size() >> 8) + text;
}

std::string shapeOf(std::size_t frames, std::size_t rows) {
    return std::to_string(frames) + ", " + std::to_string(rows);
}

template <class Number>
void writeNumbers(std::ofstream& out, const std::vector<Number>& values) {
    out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * sizeof(Number)));
}

}  // namespace

void exportPositions(const VisibilityReader& bake, const ExportRows& rows, const std::filesystem::path& output) {
    const std::size_t count = bake.header().frames.frameCount();
    PartialFile file(output);
    std::ofstream out(file.path(), std::ios::binary);
    const std::string header = numpyHeader(shapeOf(count, rows.count()) + ", 3");
    out.write(header.data(), std::streamsize(header.size()));
    for (std::size_t f = 0; f < count; ++f) writeNumbers(out, valuesOfRows(rows, bake.readPose(f).positions));
    out.close();
    if (!out) throw IoError("cannot write " + output.string());
    file.commit();
}

void exportNumpy(const FrameReader& frames, const ExportRows& rows, const std::filesystem::path& output) {
    const std::size_t count = frames.source.frames().frameCount();
    PartialFile file(output);
    std::ofstream out(file.path(), std::ios::binary);
    const std::string header = numpyHeader(shapeOf(count, rows.count()));
    out.write(header.data(), std::streamsize(header.size()));
    for (std::size_t f = 0; f < count; ++f) {
        writeNumbers(out, valuesOfRows(rows, frames.read(f, FrameParts::kAmbient).ambient));
    }
    out.close();
    if (!out) throw IoError("cannot write " + output.string());
    file.commit();
}

}  // namespace penumbra
