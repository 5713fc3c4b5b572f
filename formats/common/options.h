#pragma once
// Options of types that CLI11 does not read, and those that several verbs share. Only the files of verbs include this.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "formats/common/errors.h"
#include "formats/common/frame_range.h"
#include "formats/common/joined.h"
#include "formats/common/name_list_option.h"
#include "formats/common/picture_text.h"
#include "formats/common/words.h"

namespace penumbra {

// Adds an option whose value `parse` makes of a text. `parse` throws std::invalid_argument, which says what is wrong.
template <class T, class Parse>
CLI::Option* addParsed(CLI::App& app, const std::string& option, T& value, const Parse& parse,
                       const std::string& help) {
    const auto store = [&value, option, parse](const std::string& text) {
        try {
            value = parse(text);
        } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError(option, error.what());
        }
    };
    return app.add_option_function<std::string>(option, store, help);
}

// Returns the value of a word. Throws std::invalid_argument, which lists the words, for any other text.
template <class T, std::size_t N>
T valueOf(const Word<T> (&words)[N], const std::string& text) {
    for (const Word<T>& word : words)
        if (word.word == text) return word.value;
    throw std::invalid_argument("must be one of " + joined(words, ", ", &Word<T>::word) + ", not '" + text + "'");
}

// Adds an option that takes one of these words; the table must outlive the app.
template <class Value, class T, std::size_t N>
CLI::Option* addChoice(CLI::App& app, const std::string& option, Value& value, const Word<T> (&words)[N],
                       const std::string& help) {
    return addParsed(
               app, option, value, [&words](const std::string& text) { return valueOf(words, text); }, help)
        ->type_name("{" + joined(words, ",", &Word<T>::word) + "}")
        ->default_str(std::string(wordOf(words, value)));
}

// Checks a text that goes on as it is by what will read it; see addParsed().
template <class Parse>
CLI::Validator readableBy(const Parse& parse) {
    const auto problem = [parse](const std::string& text) -> std::string {
        try {
            (void)parse(text);
            return "";
        } catch (const std::invalid_argument& error) {
            return error.what();
        }
    };
    return CLI::Validator(problem, "");
}

// Adds an option that takes the name of one of these kinds, as kModelKinds.
template <class Kinds>
CLI::Option* addKind(CLI::App& app, const std::string& option, typename Kinds::value_type& value, const Kinds& kinds,
                     const std::string& help) {
    const auto find = [&kinds](const std::string& text) {
        for (const auto kind : kinds)
            if (text == nameOf(kind)) return kind;
        throw std::invalid_argument("must be one of " + joined(kinds, ", ", [](auto kind) { return nameOf(kind); }) +
                                    ", not '" + text + "'");
    };
    return addParsed(app, option, value, find, help)
        ->type_name("{" + joined(kinds, ",", [](auto kind) { return nameOf(kind); }) + "}")
        ->default_str(nameOf(value));
}

// Adds an option that takes several of these words, with commas between.
template <class T, std::size_t N>
CLI::Option* addChoices(CLI::App& app, const std::string& option, std::vector<T>& values, const Word<T> (&words)[N],
                        const std::string& help) {
    const auto take = [&values, &words, option](const std::string& text) {
        try {
            values.push_back(valueOf(words, text));
        } catch (const std::invalid_argument& error) {
            throw CLI::ValidationError(option, error.what());
        }
    };
    return addListOption(app, option, take, help);
}

// Checks a number: "must be 16..65536 rays, not 3". `range` stands in --help.
template <class Good>
CLI::Validator numberThat(const std::string& wanted, const std::string& range, const Good& good) {
    const auto problem = [wanted, good](const std::string& text) {
        char* end = nullptr;
        const long double number = std::strtold(text.c_str(), &end);  // holds every 64-bit integer
        const bool read = end != text.c_str() && *end == '\0' && std::isfinite(number);
        return read && good(number) ? std::string() : "must " + wanted + ", not " + text;
    };
    return CLI::Validator(problem, range);
}

// Whole numbers where T is a type of such. `unit` follows the range in the message. A real number is rounded to T
// first, as the option will be: 0.01 in a text is nearer to 1/100 than a bound of 0.01 in the source, and below it.
template <class T>
CLI::Validator within(T least, T most, const std::string& unit = "") {
    std::ostringstream range;
    range << least << ".." << most;
    return numberThat("be " + range.str() + (unit.empty() ? "" : " " + unit), range.str(),
                      [least, most](long double x) {
                          if constexpr (std::is_floating_point_v<T>)
                              return T(x) >= least && T(x) <= most;
                          else
                              return x >= least && x <= most && x == std::floor(x);
                      });
}

inline CLI::Validator aboveZero() {
    return numberThat("be a finite number above 0", "> 0", [](long double x) { return x > 0; });
}

inline CLI::Validator aShare() {
    return numberThat("lie in (0, 1]", "(0, 1]", [](long double x) { return x > 0 && x <= 1; });
}

inline CLI::Option* addFile(CLI::App& app, const std::string& option, std::optional<std::filesystem::path>& file,
                            const std::string& help) {
    return addParsed(
        app, option, file, [](const std::string& text) { return std::filesystem::path(text); }, help);
}

inline CLI::Option* addSeed(CLI::App& app, std::uint64_t& seed, const std::string& help) {
    return app.add_option("--seed", seed, help)->check(within<std::int64_t>(0, INT64_MAX));
}

// Adds --frames A:B[:S].
inline CLI::Option* addFrames(CLI::App& app, std::optional<FrameRange>& frames, const std::string& help) {
    return addParsed(app, "--frames", frames, parseFrameRange, help);
}

// Adds --size WIDTHxHEIGHT.
inline CLI::Option* addSize(CLI::App& app, int& width, int& height) {
    const auto store = [&width, &height](const std::string& text) {
        const std::optional<PictureSize> size = parseSize(text);
        if (!size || std::min(size->width, size->height) < 1 || std::max(size->width, size->height) > kMaxPictureSide)
            throw CLI::ValidationError("--size", "must be WIDTHxHEIGHT in pixels, each 1..16384, not '" + text + "'");
        width = size->width;
        height = size->height;
    };
    return app.add_option_function<std::string>("--size", store, "WIDTHxHEIGHT in pixels")
        ->default_str(std::to_string(width) + "x" + std::to_string(height));
}

// Reads a background; transparent is none.
inline std::optional<Vec3> readBackground(const std::string& text) {
    const std::optional<Vec3> color = parseColor(text);
    if (color || text == "transparent") return color;
    throw std::invalid_argument("must be transparent or R/G/B (linear, 0 or more), not '" + text + "'");
}

// Checks the name of a file by how it ends.
inline CLI::Validator endsIn(const std::vector<std::string>& extensions) {
    const auto problem = [extensions](const std::string& file) {
        const std::string extension = std::filesystem::path(file).extension();
        const bool good = std::ranges::find(extensions, extension) != extensions.end();
        return good ? std::string() : "must end in " + joined(extensions, " or ") + ", not " + file;
    };
    return CLI::Validator(problem, "");
}

}  // namespace penumbra
