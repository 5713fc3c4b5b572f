#include "formats/brdf/brdf_source.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <stdexcept>

#include "formats/brdf/brdf_readers.h"
#include "formats/common/check_readable.h"
#include "formats/common/errors.h"
#include "formats/common/warning.h"
#include "sh/brdf/principled.h"

namespace penumbra {

namespace {

constexpr std::uintmax_t kMaxBytes = std::uintmax_t(1) << 30;

std::string readText(const std::filesystem::path& path) {
    checkReadable(path);
    std::error_code error;
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path.string() + ": cannot read: " + std::strerror(errno));
    if (const auto size = std::filesystem::file_size(path, error); !error && size > kMaxBytes)
        throw InvalidInput(path.string() + ": larger than any BRDF (1 GiB)");
    std::string text;
    std::string buffer(1 << 20, '\0');
    do {
        in.read(buffer.data(), std::ptrdiff_t(buffer.size()));
        text.append(buffer, 0, std::size_t(in.gcount()));
        if (text.size() > kMaxBytes) throw InvalidInput(path.string() + ": larger than any BRDF (1 GiB)");
    } while (in);
    if (in.bad()) throw IoError(path.string() + ": cannot read");
    return text;
}

}  // namespace

std::vector<std::filesystem::path> BrdfSource::files() const {
    if (!merl.empty()) return {merl};
    if (!table.empty()) return {table};
    return {};
}

BrdfSource brdfSource(const std::string& word) {
    BrdfSource source;
    std::vector<std::string> models = brdfNames();
    models.emplace_back(kPrincipledName);
    const std::string first = word.substr(0, word.find_first_of(":+"));
    const bool is_model = std::find(models.begin(), models.end(), first) != models.end();
    const auto exists = [](const std::string& path) {
        std::error_code error;
        return std::filesystem::exists(path, error);
    };
    const std::size_t colon = word.rfind(':');
    std::filesystem::path path = word;
    if (!exists(word) && colon != std::string::npos && exists(word.substr(0, colon))) {
        path = word.substr(0, colon);
        source.material = word.substr(colon + 1);
    }
    const bool means_file = exists(path.string()) || word.find_first_of("./") < colon;
    if (is_model || !means_file)
        source.analytic = word;
    else
        (path.extension() == ".binary" ? source.merl : source.table) = path;
    return source;
}

namespace {

BrdfReading readAnalytic(const BrdfSource& source) {
    if (std::error_code error; std::filesystem::is_regular_file(source.analytic, error))
        throw BadOption(source.analytic_option, source.analytic + " is a file: merl and table take measurements");
    try {
        if (const std::optional<Membrane> membrane = parseMembrane(source.analytic)) {
            BrdfReading reading{rgbBrdf({}), {}, {lobeOf({})}, membrane};
            reading.brdf.name = toString(*membrane);
            return reading;
        }
        if (const std::optional<BrdfRange> range = parseBrdfRange(source.analytic)) {
            if (!source.takes_ranges) throw std::invalid_argument("a range has no one picture: give one value");
            BrdfReading reading{sumBrdf(range->sum), {}, lobesOf(range->sum), {}, range, range->sum.emission};
            reading.brdf.name = range->name;
            return reading;
        }
        const BrdfSum sum = parseBrdfSum(source.analytic);
        return {sumBrdf(sum), {}, lobesOf(sum), {}, {}, sum.emission};
    } catch (const std::invalid_argument& error) {
        throw BadOption(source.analytic_option, error.what());
    }
}

// Tells whether the text starts with bytes that no text has.
bool looksBinary(std::string_view text) {
    const std::string_view start = text.substr(0, 4096);
    return std::any_of(start.begin(), start.end(), [](char c) {
        const auto byte = static_cast<unsigned char>(c);
        return byte == 127 || (byte < ' ' && c != '\t' && c != '\n' && c != '\r' && c != '\f' && c != '\v');
    });
}

BrdfReading decodeTable(const std::string& text, const BrdfSource& source, const std::string& name, int threads) {
    if (looksLikeFits(text)) return decodeFits(text, name, source.material);
    if (!source.material.empty())
        throw BadOption("material", "needs a table of several materials (a .csv of fits), " + name + " has one");
    if (looksLikeBrdfTable(text)) return decodeBrdfTable(text, name);
    if (looksLikeMerl(text)) throw InvalidInput(name + ": is a file of the MERL database, not a table");
    if (looksBinary(text))
        throw InvalidInput(name + ": binary, not a known table (Cornell's .brdf, fits .csv, penumbra-brdf-table)");
    return decodeScattered(text, name, threads);
}

}  // namespace

BrdfReading readBrdfSource(const BrdfSource& source, int threads) {
    const int given = !source.analytic.empty() + !source.merl.empty() + !source.table.empty();
    if (given != 1) throw BadOption(source.analytic_option, "give exactly one of this, merl and table");
    if (!source.material.empty() && source.table.empty()) throw BadOption("material", "needs a table");
    if (!source.analytic.empty()) return readAnalytic(source);
    const std::filesystem::path path = source.files()[0];
    const std::string text = readText(path);
    if (text.starts_with("\x89HDF"))
        throw InvalidInput(path.string() +
                           ": is HDF5, as fitted materials are (.brdf.h5): a file of measurements is needed here");
    BrdfReading reading =
        source.merl.empty() ? decodeTable(text, source, path.string(), threads) : decodeMerl(text, path.string());
    reading.brdf.name = oneLine(path.filename().string() + (source.material.empty() ? "" : ":" + source.material));
    return reading;
}

}  // namespace penumbra
