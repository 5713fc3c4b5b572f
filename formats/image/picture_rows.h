#pragma once
// A picture that is read from the top in bands of rows, so that no one need hold all of it. Every reader of pictures of
// light goes through this: whole pictures are joined bands (image_file.h), and large ones are summed band by band
// (picture_light.h).
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "formats/common/random_bytes.h"
#include "formats/image/picture_options.h"

namespace penumbra {

struct PictureInfo {
    int width = 0, height = 0;
    bool has_alpha = false;
    std::string layout;              // layout that the file states: "", "latlong" or "cube" (six faces, one below the
                                     // other)
    std::optional<Mat3d> to_rec709;  // none: the colours are linear Rec.709. It is not applied to what next() gives
    bool from_the_top = true;        // false: the rows come from the bottom up
    PictureNotes notes;
};

struct PictureBand {
    int rows = 0;
    std::array<std::vector<float>, 3> color;  // [rows, width] each, in the file's own colours
    std::vector<float> alpha;                 // the same, or empty
};

class PictureRows {
public:
    virtual ~PictureRows() = default;
    const PictureInfo& info() const { return info_; }
    // Reads the next rows into `band`: some, as the file has them together. There must be rows left. Throws
    // InvalidInput where the bytes are damaged or cut short.
    virtual void next(PictureBand& band) = 0;

protected:
    PictureInfo info_;
};

// Opens a picture by its content. `name` starts every message. Throws InvalidInput for anything that is no picture of
// light or is damaged, or where a layer is missing or must be chosen; Unsupported for what is not read; BadOption for
// options that this kind of picture does not have.
std::unique_ptr<PictureRows> openPicture(const RandomBytes& bytes, const std::string& name,
                                         const PictureOptions& options);

// Returns the bytes of a span, which must outlive them.
RandomBytes bytesOf(std::span<const std::byte> bytes);

// Chooses the colours of a picture: the file's primaries where it states some (`stated`), else those of
// options.colorspace. Fills info.to_rec709 and notes. Throws InvalidInput where stated primaries are none.
struct Primaries;
void chooseColors(const std::optional<Primaries>& stated, const PictureOptions& options, const std::string& name,
                  PictureInfo& info);

// Reads a RandomBytes from front to back through a buffer, and may jump.
class BufferedBytes {
public:
    BufferedBytes(RandomBytes bytes, std::size_t buffer) : bytes_(std::move(bytes)), buffer_(buffer) {}
    std::uint64_t position() const { return position_; }
    std::uint64_t left() const { return bytes_.size - position_; }
    void seek(std::uint64_t position) { position_ = position; }  // at most the size
    // Returns the next bytes as far as they are in memory: at least one unless none are left, and `wanted` where they
    // are there and fit the buffer. The span is good until the next call.
    std::span<const std::byte> peek(std::size_t wanted);
    void skip(std::size_t count) { position_ += count; }
    // Copies the next bytes; there must be as many.
    void read(std::span<std::byte> out);

private:
    RandomBytes bytes_;
    std::vector<std::byte> buffer_;
    std::uint64_t position_ = 0, start_ = 0;  // positions of the next byte and of the buffer
    std::size_t held_ = 0;
};

}  // namespace penumbra
