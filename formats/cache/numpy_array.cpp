#include "formats/cache/numpy_array.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

#include "formats/common/errors.h"

namespace penumbra {

constexpr std::size_t kMaxHeaderSize = 65536;
constexpr std::size_t kMaxDimensions = 32;

namespace {
// Reads the header, a Python dictionary: {'descr': '<f4', 'fortran_order': False, 'shape': (600, 5041, 3), }
class HeaderScanner {
public:
    HeaderScanner(std::string_view text, const std::string& what) : rest_(text), what_(what) {}

    [[noreturn]] void fail() const { throw InvalidInput(what_ + ": its NumPy header is damaged"); }
    bool accept(char c) {
        skipBlanks();
        if (rest_.empty() || rest_.front() != c) return false;
        rest_.remove_prefix(1);
        return true;
    }
    void expect(char c) {
        if (!accept(c)) fail();
    }
    bool startsWith(char c) {
        skipBlanks();
        return !rest_.empty() && rest_.front() == c;
    }
    std::string text() {
        skipBlanks();
        if (rest_.empty() || (rest_.front() != '\'' && rest_.front() != '"')) fail();
        const std::size_t end = rest_.find(rest_.front(), 1);
        if (end == std::string_view::npos) fail();
        return std::string(take(end + 1).substr(1, end - 1));
    }
    std::string word() {
        skipBlanks();
        const auto in_word = [](unsigned char c) { return std::isalnum(c) != 0; };
        const auto end = std::find_if_not(rest_.begin(), rest_.end(), in_word);
        return std::string(take(std::size_t(end - rest_.begin())));
    }
    std::uint64_t integer() {
        const std::string digits = word();
        if (digits.empty() || digits.size() > 18) fail();
        std::uint64_t value = 0;
        for (const char c : digits) {
            if (c < '0' || c > '9') fail();
            value = 10 * value + std::uint64_t(c - '0');
        }
        return value;
    }
    bool atEnd() {
        skipBlanks();
        return rest_.empty();
    }

private:
    std::string_view take(std::size_t size) {
        const std::string_view taken = rest_.substr(0, size);
        rest_.remove_prefix(size);
        return taken;
    }
    void skipBlanks() {
        while (!rest_.empty() && (rest_.front() == ' ' || rest_.front() == '\n')) rest_.remove_prefix(1);
    }
    std::string_view rest_;
    const std::string& what_;
};

// Reads a type such as '<f4': byte order, kind, bytes.
void setType(const std::string& type, NumpyArray& array) {
    const auto unsupported = [&] {
        throw Unsupported(array.what + ": numbers of type '" + (type.size() < 16 ? type : "...") +
                          "' (f4, f8 and integers are read)");
    };
    if (type.size() != 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos) unsupported();
    array.kind = type[1];
    array.item_size = type[2] - '0';
    const bool is_float = array.kind == 'f' && (array.item_size == 4 || array.item_size == 8);
    const bool is_integer = (array.kind == 'i' || array.kind == 'u') && array.item_size >= 1 && array.item_size <= 8 &&
                            std::has_single_bit(unsigned(array.item_size));
    if (!is_float && !is_integer) unsupported();
    const bool little = std::endian::native == std::endian::little;
    array.swapped = type[0] == (little ? '>' : '<');
}

std::vector<std::uint64_t> readShape(HeaderScanner& header) {
    std::vector<std::uint64_t> shape;
    header.expect('(');
    while (!header.accept(')')) {
        if (shape.size() == kMaxDimensions) header.fail();
        shape.push_back(header.integer());
        if (header.accept(',')) continue;
        header.expect(')');
        break;
    }
    return shape;
}

void parseHeader(std::string_view text, NumpyArray& array) {
    HeaderScanner header(text, array.what);
    bool has_type = false, has_order = false, has_shape = false;
    header.expect('{');
    while (!header.accept('}')) {
        const std::string key = header.text();
        header.expect(':');
        if (key == "descr") {
            if (header.startsWith('[')) throw Unsupported(array.what + ": records (plain numbers are read)");
            setType(header.text(), array);
            has_type = true;
        } else if (key == "fortran_order") {
            const std::string value = header.word();
            if (value == "True")
                throw Unsupported(array.what + ": column-major order (numpy.ascontiguousarray() before saving helps)");
            if (value != "False") header.fail();
            has_order = true;
        } else if (key == "shape") {
            array.shape = readShape(header);
            has_shape = true;
        } else {
            header.fail();
        }
        if (header.accept(',')) continue;
        header.expect('}');
        break;
    }
    if (!header.atEnd() || !has_type || !has_order || !has_shape) header.fail();
}

// Returns the bytes of all numbers; nothing where that exceeds 64 bits.
std::optional<std::uint64_t> dataSize(const NumpyArray& array) {
    std::uint64_t size = std::uint64_t(array.item_size);
    for (const std::uint64_t n : array.shape) {
        if (n != 0 && size > std::numeric_limits<std::uint64_t>::max() / n) return std::nullopt;
        size *= n;
    }
    return size;
}

}  // namespace

NumpyArray openNumpy(const RandomBytes& bytes, const std::string& what) {
    NumpyArray array;
    array.what = what;
    const auto fail = [&](const std::string& problem) { throw InvalidInput(what + ": " + problem); };
    if (bytes.size < 12) fail("is not a NumPy array, or cut short");
    const std::vector<std::byte> start = readBytes(bytes, 0, 12);
    if (std::memcmp(start.data(), "\x93NUMPY", 6) != 0) fail("is not a NumPy array");
    const int version = int(start[6]);
    if (version < 1 || version > 3) throw Unsupported(what + ": NumPy format version " + std::to_string(version));
    const std::size_t length_bytes = version == 1 ? 2 : 4;
    std::size_t header_size = 0;
    for (std::size_t i = length_bytes; i-- > 0;) header_size = header_size << 8 | std::size_t(start[8 + i]);
    const std::size_t header_start = 8 + length_bytes;
    if (header_size > kMaxHeaderSize || header_size > bytes.size - header_start) fail("its NumPy header is damaged");
    const std::vector<std::byte> header = readBytes(bytes, header_start, header_size);
    parseHeader({reinterpret_cast<const char*>(header.data()), header.size()}, array);
    const std::uint64_t data_start = header_start + header_size, data_size = bytes.size - data_start;
    if (dataSize(array) != data_size)
        fail(describe(array) + " needs another size than the " + std::to_string(data_size) + " bytes that are there");
    array.data = partOf(bytes, data_start, data_size);
    return array;
}

namespace {

template <class T>
void appendNumbers(std::vector<std::byte>& bytes, bool swapped, std::vector<double>& out) {
    for (std::size_t at = 0; at < bytes.size(); at += sizeof(T)) {
        if (swapped) std::reverse(bytes.begin() + std::ptrdiff_t(at), bytes.begin() + std::ptrdiff_t(at + sizeof(T)));
        T value;
        std::memcpy(&value, &bytes[at], sizeof(T));
        out.push_back(double(value));
    }
}

}  // namespace

std::vector<double> readNumbers(const NumpyArray& array, std::uint64_t first, std::size_t count) {
    const std::uint64_t item = std::uint64_t(array.item_size);
    assert(first + count <= array.count());
    std::vector<std::byte> bytes = readBytes(array.data, first * item, count * std::size_t(item));
    std::vector<double> out;
    out.reserve(count);
    const auto append = [&]<class T>(T) { appendNumbers<T>(bytes, array.swapped, out); };
    switch (array.kind == 'f' ? 8 + item : array.kind == 'i' ? 16 + item : item) {
        case 8 + 4:
            append(float());
            break;
        case 8 + 8:
            append(double());
            break;
        case 16 + 1:
            append(std::int8_t());
            break;
        case 16 + 2:
            append(std::int16_t());
            break;
        case 16 + 4:
            append(std::int32_t());
            break;
        case 16 + 8:
            append(std::int64_t());
            break;
        case 1:
            append(std::uint8_t());
            break;
        case 2:
            append(std::uint16_t());
            break;
        case 4:
            append(std::uint32_t());
            break;
        case 8:
            append(std::uint64_t());
            break;
    }
    return out;
}

std::string describe(const NumpyArray& array) {
    std::string text = array.kind + std::to_string(array.item_size) + " [";
    for (std::size_t i = 0; i < array.shape.size(); ++i) text += (i > 0 ? "," : "") + std::to_string(array.shape[i]);
    return text + "]";
}

}  // namespace penumbra
