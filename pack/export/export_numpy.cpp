// Writes ambient visibility as an array of NumPy (format version 1.0), frame by frame.
#include <fstream>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "pack/export/export_files.h"

namespace penumbra {

namespace {

// The header is a line of Python, padded so that the numbers begin at a multiple of 64 bytes.
std::string numpyHeader(std::size_t frames, std::size_t rows) {
    std::string text = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(frames) + ", " +
                       std::to_string(rows) + "), }";
    text.append(63 - (10 + text.size()) % 64, ' ');
    text += '\n';
    return std::string("\x93NUMPY\x01\x00", 8) + char(text.size() & 0xff) + char(text.size() >> 8) + text;
}

}  // namespace

void exportNumpy(const FrameReader& frames, const ExportRows& rows, const std::filesystem::path& output) {
    const std::size_t count = frames.source.frames().frameCount();
    PartialFile file(output);
    std::ofstream out(file.path(), std::ios::binary);
    const std::string header = numpyHeader(count, rows.count());
    out.write(header.data(), std::streamsize(header.size()));
    for (std::size_t f = 0; f < count; ++f) {
        const std::vector<float> values = valuesOfRows(rows, frames.read(f, FrameParts::kAmbient).ambient);
        out.write(reinterpret_cast<const char*>(values.data()), std::streamsize(values.size() * sizeof(float)));
    }
    out.close();
    if (!out) throw IoError("cannot write " + output.string());
    file.commit();
}

}  // namespace penumbra
