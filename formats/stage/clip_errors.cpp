#include "formats/stage/clip_errors.h"

#include "formats/common/errors.h"

namespace penumbra {

void writeClipErrors(hid_t file, const std::vector<ClipError>& errors) {
    std::vector<std::string> clips;
    std::vector<std::int64_t> held_out;
    std::vector<double> relative, rms_v, ambient;
    for (const ClipError& error : errors) {
        clips.push_back(error.clip);
        held_out.push_back(error.held_out);
        relative.push_back(error.relative_error);
        rms_v.push_back(error.rms_v);
        ambient.push_back(error.ambient_error);
    }
    writeStrings(file, "/errors/clip", clips);
    writeIntegers(file, "/errors/held_out", held_out, {clips.size()}, H5T_STD_U8LE);
    writeDoubles(file, "/errors/relative_error", relative, {clips.size()});
    writeDoubles(file, "/errors/rms_v", rms_v, {clips.size()});
    writeDoubles(file, "/errors/ambient_error", ambient, {clips.size()});
}

std::vector<ClipError> readClipErrors(const Hdf5Reader& in) {
    const std::vector<std::string> clips = readStrings(in, "/errors/clip");
    std::vector<hsize_t> shape{clips.size()};
    const std::vector<std::int64_t> held_out = readIntegers(in, "/errors/held_out", shape, 0, 1);
    const std::vector<double> relative = readDoubles(in, "/errors/relative_error", shape);
    const std::vector<double> rms_v = readDoubles(in, "/errors/rms_v", shape);
    const std::vector<double> ambient = readDoubles(in, "/errors/ambient_error", shape);
    if (shape[0] != clips.size()) throw InvalidInput(in.name + ": /errors: entries where none belong");
    std::vector<ClipError> errors;
    for (std::size_t i = 0; i < clips.size(); ++i)
        errors.push_back({clips[i], held_out[i] != 0, relative[i], rms_v[i], ambient[i]});
    return errors;
}

}  // namespace penumbra
