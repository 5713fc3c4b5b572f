// libjpeg reports errors by a call that must not return. Every call of the library therefore runs inside attempt(),
// which a longjmp ends; between the two places there is nothing that has a destructor.
#include <csetjmp>
#include <cstdio>
// <cstdio> comes first, because jpeglib.h uses what it declares.
#include <jerror.h>
#include <jpeglib.h>

#include "formats/common/errors.h"
#include "formats/image/image_codecs.h"

namespace penumbra {

namespace {

// A block of 8 x 8 pixels takes at least one bit in some scan, so a byte holds at most 512 pixels.
constexpr std::uint64_t kMaxPixelsOfJpegByte = 512;

struct JpegReader {
    jpeg_error_mgr errors;  // comes first: the library's callbacks know only this
    std::jmp_buf out;
    char problem[JMSG_LENGTH_MAX];
    jpeg_decompress_struct jpeg;
    const unsigned char* bytes;
    unsigned long size;
    std::uint8_t* rgb;  // where pixels() writes
};

[[noreturn]] void stop(j_common_ptr jpeg) {
    auto* reader = reinterpret_cast<JpegReader*>(jpeg->err);
    jpeg->err->format_message(jpeg, reader->problem);
    std::longjmp(reader->out, 1);
}

// The library fills what a file lacks with grey and only warns. A picture that is cut short is an error here.
void hearWarning(j_common_ptr jpeg, int level) {
    const int code = jpeg->err->msg_code;
    if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER)) stop(jpeg);
}

bool attempt(JpegReader& reader, void (*work)(JpegReader&)) {
    if (setjmp(reader.out) != 0) return false;
    work(reader);
    return true;
}

void readHeader(JpegReader& reader) {
    jpeg_create_decompress(&reader.jpeg);
    jpeg_mem_src(&reader.jpeg, reader.bytes, reader.size);
    jpeg_read_header(&reader.jpeg, TRUE);
}

void readPixels(JpegReader& reader) {
    reader.jpeg.out_color_space = JCS_RGB;
    jpeg_start_decompress(&reader.jpeg);
    while (reader.jpeg.output_scanline < reader.jpeg.output_height) {
        JSAMPROW row = reader.rgb + std::size_t(reader.jpeg.output_scanline) * reader.jpeg.output_width * 3;
        jpeg_read_scanlines(&reader.jpeg, &row, 1);
    }
    jpeg_finish_decompress(&reader.jpeg);
}

}  // namespace

TexturePicture decodeJpeg(std::span<const std::byte> bytes, const std::string& name) {
    JpegReader reader{};
    reader.jpeg.err = jpeg_std_error(&reader.errors);
    reader.errors.error_exit = stop;
    reader.errors.emit_message = hearWarning;
    reader.bytes = reinterpret_cast<const unsigned char*>(bytes.data());
    reader.size = static_cast<unsigned long>(bytes.size());
    struct Release {
        jpeg_decompress_struct& jpeg;
        ~Release() { jpeg_destroy_decompress(&jpeg); }
    } const release{reader.jpeg};
    const auto run = [&](void (*work)(JpegReader&)) {
        if (!attempt(reader, work)) throw InvalidInput(name + ": JPEG: " + reader.problem);
    };
    run(readHeader);
    TexturePicture picture;
    checkTextureSize(reader.jpeg.image_width, reader.jpeg.image_height, bytes.size() * kMaxPixelsOfJpegByte, name);
    picture.width = int(reader.jpeg.image_width);
    picture.height = int(reader.jpeg.image_height);
    picture.rgb.resize(std::size_t(picture.width) * std::size_t(picture.height) * 3);
    reader.rgb = picture.rgb.data();
    run(readPixels);
    return picture;
}

}  // namespace penumbra
