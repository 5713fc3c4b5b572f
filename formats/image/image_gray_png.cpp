#include <png.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

struct Reading {
    std::span<const std::byte> bytes;
    std::size_t at = 0;
    char problem[128] = "";
};

void readSome(png_structp png, png_bytep out, std::size_t count) {
    Reading& reading = *static_cast<Reading*>(png_get_io_ptr(png));
    if (count > reading.bytes.size() - reading.at) png_error(png, "is cut short");
    std::memcpy(out, reading.bytes.data() + reading.at, count);
    reading.at += count;
}

[[noreturn]] void fail(png_structp png, png_const_charp message) {
    Reading& reading = *static_cast<Reading*>(png_get_error_ptr(png));
    std::strncpy(reading.problem, message, sizeof reading.problem - 1);
    png_longjmp(png, 1);
}

void warn(png_structp, png_const_charp) {}

// libpng jumps out of a step that fails. Nothing in these two has a destructor.
bool readHeader(png_structp png, png_infop info) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_read_info(png, info);
    return true;
}

bool readRows(png_structp png, png_infop info, png_bytepp rows) {
    if (setjmp(png_jmpbuf(png))) return false;
    png_set_interlace_handling(png);
    png_read_update_info(png, info);
    png_read_image(png, rows);
    return true;
}

struct Reader {
    png_structp png;
    png_infop info;
    explicit Reader(Reading& reading)
        : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, fail, warn)),
          info(png ? png_create_info_struct(png) : nullptr) {
        if (png) png_set_read_fn(png, &reading, readSome);
    }
    ~Reader() { png_destroy_read_struct(&png, &info, nullptr); }
    Reader(const Reader&) = delete;
};

}  // namespace

bool looksLikePng(std::span<const std::byte> bytes) {
    return bytes.size() >= 8 && png_sig_cmp(reinterpret_cast<png_const_bytep>(bytes.data()), 0, 8) == 0;
}

GrayImage decodeGrayPng(std::span<const std::byte> bytes, const std::string& name, const GrayChoice& choice) {
    Reading reading{bytes};
    Reader reader(reading);
    if (!reader.info) throw IoError(name + ": PNG: no memory");
    const auto damaged = [&] { return InvalidInput(name + ": PNG: " + reading.problem); };
    if (!readHeader(reader.png, reader.info)) throw damaged();
    const std::size_t width = png_get_image_width(reader.png, reader.info),
                      height = png_get_image_height(reader.png, reader.info);
    const int bits = png_get_bit_depth(reader.png, reader.info), type = png_get_color_type(reader.png, reader.info);
    if (type != PNG_COLOR_TYPE_GRAY || bits < 8)
        throw Unsupported(name + ": PNG: only grey without alpha, of 8 or 16 bits, is read as heights");
    if (std::max(width, height) > std::size_t(choice.most))
        throw InvalidInput(name + ": PNG: a side has " + std::to_string(std::max(width, height)) +
                           " pixels, more than " + std::to_string(choice.most));
    // A row of pixels takes at least some bits of the file, so that a short file cannot ask for much memory.
    if (width * height / 1024 > bytes.size()) throw InvalidInput(name + ": PNG: is cut short");
    const std::size_t row = width * std::size_t(bits / 8);
    std::vector<png_byte> pixels(row * height);
    std::vector<png_bytep> rows(height);
    for (std::size_t r = 0; r < height; ++r) rows[r] = pixels.data() + r * row;
    if (!readRows(reader.png, reader.info, rows.data())) throw damaged();
    GrayImage out{int(width), int(height), std::vector<float>(width * height)};
    for (std::size_t i = 0; i < out.numbers.size(); ++i)
        out.numbers[i] = bits == 8 ? float(pixels[i]) : float(pixels[2 * i] << 8 | pixels[2 * i + 1]);
    return out;
}

}  // namespace penumbra
