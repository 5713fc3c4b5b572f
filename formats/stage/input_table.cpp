#include "formats/stage/input_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>

#include "formats/common/check_readable.h"
#include "formats/common/errors.h"

namespace penumbra {

namespace {

constexpr std::size_t kMaxBytes = std::size_t(256) << 20, kMaxInputs = 1000;
constexpr double kMaxFrame = 1e9;

// The place in the file that a message names.
struct Place {
    const std::filesystem::path& file;
    std::size_t line;
    [[noreturn]] void fail(const std::string& what) const {
        throw InvalidInput(file.string() + ": line " + std::to_string(line) + ": " + what);
    }
};

std::string trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t");
    if (first == std::string_view::npos) return "";
    return std::string(text.substr(first, text.find_last_not_of(" \t") - first + 1));
}

// Splits a line as RFC 4180 asks: commas separate fields, and a field "a ""quoted"" field" may contain them.
std::vector<std::string> splitLine(std::string_view line, const Place& place) {
    std::vector<std::string> fields;
    for (std::size_t at = 0; at <= line.size();) {
        const std::size_t start = line.find_first_not_of(" \t", at);
        if (start == std::string_view::npos || line[start] != '"') {
            const std::size_t end = std::min(line.find(',', at), line.size());
            fields.push_back(trimmed(line.substr(at, end - at)));
            at = end + 1;
            continue;
        }
        std::string field;
        std::size_t i = start + 1;
        for (; i < line.size() && (line[i] != '"' || (i + 1 < line.size() && line[i + 1] == '"')); ++i) {
            i += line[i] == '"';
            field += line[i];
        }
        if (i >= line.size()) place.fail("a quotation mark is missing");
        const std::size_t end = std::min(line.find(',', i), line.size());
        if (!trimmed(line.substr(i + 1, end - i - 1)).empty()) place.fail("text after a quoted field");
        fields.push_back(field);
        at = end + 1;
    }
    return fields;
}

double parseNumber(const std::string& text, const std::string& column, const Place& place) {
    double value = 0;
    const char* end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + (text.starts_with('+') ? 1 : 0), end, value);
    if (error != std::errc() || stop != end || !std::isfinite(value) || !std::isfinite(float(value)))
        place.fail(column + ": '" + text + "' is not a number");
    return value;
}

// Splits "ball.x" into "ball" and 0. For other names it returns "" and -1.
std::pair<std::string, int> pointColumn(const std::string& name) {
    if (name.size() < 3 || name[name.size() - 2] != '.' || name.back() < 'x' || name.back() > 'z') return {"", -1};
    return {name.substr(0, name.size() - 2), name.back() - 'x'};
}

void checkNames(const std::vector<std::string>& names, const Place& place) {
    if (names.empty()) place.fail("no column of an input");
    if (names.size() > kMaxInputs) place.fail("more than " + std::to_string(kMaxInputs) + " inputs");
    std::set<std::string> seen;
    for (const std::string& name : names) {
        if (name.empty()) place.fail("a column has no name");
        if (name == "frame" || name == "time" || name == "clip" || !seen.insert(name).second)
            place.fail("column '" + name + "' occurs twice, or not where it belongs");
    }
    for (std::size_t i = 0; i < names.size(); ++i) {
        const auto [point, axis] = pointColumn(names[i]);
        if (axis < 0) continue;
        const std::size_t x = i - std::size_t(axis);  // wraps far beyond the end where there is none
        for (std::size_t k = 0; k < 3; ++k)
            if (x + 2 >= names.size() || x > i || names[x + k] != point + "." + char('x' + int(k)))
                place.fail("columns " + point + ".x, " + point + ".y and " + point +
                           ".z must be there, side by side: they are a point");
    }
}

// Tells what each column holds.
struct Columns {
    std::vector<std::string> names;  // names of all columns
    std::size_t clip = 0;            // 0: none
};

Columns readHeader(std::string_view line, InputTable& table, const Place& place) {
    Columns columns{splitLine(line, place), 0};
    const std::string key = columns.names.front();
    if (key != "frame" && key != "time") place.fail("the first column must be 'frame' or 'time', not '" + key + "'");
    table.by_frame = key == "frame";
    for (std::size_t c = 1; c < columns.names.size(); ++c) {
        if (columns.names[c] == "clip" && columns.clip == 0)
            columns.clip = c;
        else
            table.names.push_back(columns.names[c]);
    }
    checkNames(table.names, place);
    return columns;
}

void readRow(std::string_view line, const Columns& columns, InputTable& table, const Place& place) {
    const std::vector<std::string> fields = splitLine(line, place);
    if (fields.size() != columns.names.size())
        place.fail(std::to_string(fields.size()) + " fields, not " + std::to_string(columns.names.size()));
    for (std::size_t c = 0; c < fields.size(); ++c) {
        if (c > 0 && c == columns.clip) {
            table.clips.push_back(fields[c]);
            continue;
        }
        const double value = parseNumber(fields[c], columns.names[c], place);
        if (c > 0) {
            table.values.push_back(value);
            continue;
        }
        if (!(value >= 0) || (table.by_frame && (value > kMaxFrame || value != std::floor(value))))
            place.fail(columns.names[0] + ": '" + fields[c] + "' is not a " +
                       (table.by_frame ? "number of a frame (0, 1, 2, ...)" : "time in seconds, from 0"));
        table.keys.push_back(value);
    }
    table.lines.push_back(place.line);
}

}  // namespace

InputTable readInputTable(const std::filesystem::path& path) {
    checkReadable(path);
    std::ifstream in(path, std::ios::binary);
    if (std::filesystem::file_size(path) > kMaxBytes)
        throw InvalidInput(path.string() + ": larger than " + std::to_string(kMaxBytes >> 20) + " MiB");
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    std::string_view text = bytes;
    if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
    InputTable table;
    Columns columns;
    Place place{path, 0};
    while (!text.empty()) {
        ++place.line;
        const std::size_t end = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, end);
        text.remove_prefix(std::min(end + 1, text.size()));
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (line.find_first_not_of(" \t") == std::string_view::npos) continue;
        if (line.find('\0') != std::string_view::npos) place.fail("is not text");
        if (columns.names.empty())
            columns = readHeader(line, table, place);
        else
            readRow(line, columns, table, place);
    }
    if (table.keys.empty()) throw InvalidInput(path.string() + ": no line of numbers");
    return table;
}

}  // namespace penumbra
