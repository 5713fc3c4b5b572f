// libpng reports errors by a call that must not return. Every call of the library therefore runs inside attempt(),
// which a longjmp ends; between the two places there is nothing that has a destructor. The simpler interface
// (png_image_*), which writes our pictures, would apply the gamma of the file.
#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

// deflate makes at most 1032 bytes of one, and the smallest pixel is a bit.
constexpr std::uint64_t kMaxPixelsOfPngByte = 1032 * 8;

struct PngReader {
    png_structp png = nullptr;
    png_infop info = nullptr;
    const std::byte* bytes = nullptr;
    std::size_t size = 0, at = 0;
    std::jmp_buf out;
    char problem[200] = {};
    std::uint8_t* pixels = nullptr;  // where readPixels() writes
    std::size_t channels = 3;        // channels of `pixels`; 4 if the file has alpha
};

[[noreturn]] void stop(png_structp png, png_const_charp message) {
    auto* reader = static_cast<PngReader*>(png_get_error_ptr(png));
    std::strncpy(reader->problem, message, sizeof reader->problem - 1);
    std::longjmp(reader->out, 1);
}

void hearWarning(png_structp, png_const_charp) {}

void readBytes(png_structp png, png_bytep to, std::size_t count) {
    auto* reader = static_cast<PngReader*>(png_get_io_ptr(png));
    if (count > reader->size - reader->at) stop(png, "is cut short");
    std::memcpy(to, reader->bytes + reader->at, count);
    reader->at += count;
}

bool attempt(PngReader& reader, void (*work)(PngReader&)) {
    if (setjmp(reader.out) != 0) return false;
    work(reader);
    return true;
}

void readHeader(PngReader& reader) {
    png_set_read_fn(reader.png, &reader, readBytes);
    png_set_user_limits(reader.png, 0x7FFFFFFF, 0x7FFFFFFF);  // checkTextureSize() names the size
    png_read_info(reader.png, reader.info);
}

// Asks for RGB or RGBA of 8 bits, whatever the file has.
void readPixels(PngReader& reader) {
    png_set_expand(reader.png);
    png_set_scale_16(reader.png);
    png_set_gray_to_rgb(reader.png);
    const int passes = png_set_interlace_handling(reader.png);
    png_read_update_info(reader.png, reader.info);
    const std::size_t stride = std::size_t(png_get_image_width(reader.png, reader.info)) * reader.channels;
    if (png_get_rowbytes(reader.png, reader.info) != stride) png_error(reader.png, "has unknown channels");
    const png_uint_32 height = png_get_image_height(reader.png, reader.info);
    for (int pass = 0; pass < passes; ++pass)
        for (png_uint_32 y = 0; y < height; ++y) png_read_row(reader.png, reader.pixels + y * stride, nullptr);
    png_read_end(reader.png, nullptr);
}

// Takes RGBA apart.
void splitAlpha(std::span<const std::uint8_t> pixels, TexturePicture& picture) {
    picture.rgb.resize(pixels.size() / 4 * 3);
    picture.alpha.resize(pixels.size() / 4);
    for (std::size_t i = 0; i < picture.alpha.size(); ++i) {
        std::copy_n(pixels.begin() + std::ptrdiff_t(4 * i), 3, picture.rgb.begin() + std::ptrdiff_t(3 * i));
        picture.alpha[i] = pixels[4 * i + 3];
    }
}

}  // namespace

TexturePicture decodePng(std::span<const std::byte> bytes, const std::string& name) {
    PngReader reader;
    reader.bytes = bytes.data();
    reader.size = bytes.size();
    reader.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, stop, hearWarning);
    struct Release {
        PngReader& reader;
        ~Release() { png_destroy_read_struct(&reader.png, &reader.info, nullptr); }
    } const release{reader};
    if (reader.png) reader.info = png_create_info_struct(reader.png);
    if (!reader.info) throw std::bad_alloc();
    const auto run = [&](void (*work)(PngReader&)) {
        if (!attempt(reader, work)) throw InvalidInput(name + ": PNG: " + reader.problem);
    };
    run(readHeader);
    TexturePicture picture;
    const png_uint_32 width = png_get_image_width(reader.png, reader.info);
    const png_uint_32 height = png_get_image_height(reader.png, reader.info);
    checkTextureSize(width, height, bytes.size() * kMaxPixelsOfPngByte, name);
    picture.width = int(width);
    picture.height = int(height);
    const bool has_alpha = (png_get_color_type(reader.png, reader.info) & PNG_COLOR_MASK_ALPHA) != 0 ||
                           png_get_valid(reader.png, reader.info, PNG_INFO_tRNS) != 0;
    reader.channels = has_alpha ? 4 : 3;
    std::vector<std::uint8_t> pixels(std::size_t(width) * std::size_t(height) * reader.channels);
    reader.pixels = pixels.data();
    run(readPixels);
    if (has_alpha)
        splitAlpha(pixels, picture);
    else
        picture.rgb = std::move(pixels);
    return picture;
}

}  // namespace penumbra
