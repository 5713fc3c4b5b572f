#pragma once
// Photographs from where they come, one after another, and composites to where they go: single files, numbered files
// and .y4m.
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "formats/common/write_file.h"
#include "formats/image/y4m_stream.h"
#include "player/composite/compose_picture.h"

namespace penumbra {

class PlateSource {
public:
    // `path` is a picture (.jpg, .png, .exr, .hdr); a name with one %d or %0Nd in the name of the file, which stands
    // for any number of so many digits; a .y4m; or "-", which is a .y4m on standard input, of which
    // `matrix` may say how its colours are mixed. Throws IoError where nothing is there.
    explicit PlateSource(const std::filesystem::path& path, std::optional<Y4mMatrix> matrix = {});
    std::optional<std::size_t> count() const;  // none: a stream
    const std::vector<std::filesystem::path>& files() const { return files_; }
    const Y4mHeader* header() const { return reader_ ? &video_ : nullptr; }
    // Number of picture `i` in the names of its files, or i.
    std::size_t numberOf(std::size_t i) const { return i < numbers_.size() ? numbers_[i] : i; }
    // Reads picture i, which follows picture i - 1 in a stream; false at the end. Throws what readers of pictures
    // throw.
    bool read(std::size_t i, Plate& plate);

private:
    std::vector<std::filesystem::path> files_;
    std::vector<std::size_t> numbers_;
    std::ifstream file_;
    std::optional<Y4mReader> reader_;
    Y4mHeader video_;
    std::vector<std::uint8_t> planes_;
};

// Reads a picture by its content: codes of a JPEG or PNG, or linear light of an EXR or HDR.
Plate readPlate(const std::filesystem::path& path);

class PictureSink {
public:
    // `path` is OUT.png or OUT.exr for one picture, a name with one %d or %0Nd, a .y4m, or "-". Throws BadOption for
    // another, and for many pictures in a file for one. `header` is that of the source, or null; `fps` pictures a
    // second where the source says none.
    PictureSink(const std::filesystem::path& path, const Y4mHeader* header, double fps,
                std::optional<Y4mMatrix> matrix = {});
    ~PictureSink();
    bool isStream() const { return out_ != nullptr; }
    bool isLinear() const;  // .exr
    // The file of a picture; empty for a stream.
    std::filesystem::path fileOf(std::size_t number) const;
    // Tells whether the file of a picture is there and whole, and of this size.
    bool has(std::size_t number, int width, int height) const;
    // Throws InvalidInput for a picture of another size than those before it in a stream.
    void write(std::size_t number, const TexturePicture& picture);
    void write(std::size_t number, const Image& picture);
    void finish();  // the stream becomes a file

private:
    std::filesystem::path path_;
    std::optional<Y4mHeader> header_;
    double fps_;
    std::optional<Y4mMatrix> matrix_;
    bool begun_ = false;
    std::unique_ptr<PartialFile> partial_;
    std::ofstream file_;
    std::ostream* out_ = nullptr;
    std::vector<std::uint8_t> planes_;
};

}  // namespace penumbra
