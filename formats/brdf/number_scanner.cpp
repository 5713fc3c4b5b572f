#include "formats/brdf/number_scanner.h"

#include <charconv>
#include <cmath>

#include "formats/common/errors.h"

namespace penumbra {

void NumberScanner::skipBlanks() {
    bool comment = false;
    while (!rest_.empty()) {
        const char c = rest_.front();
        if (c == '\n') {
            ++line_;
            comment = false;
        } else if (c == '#') {
            comment = true;
        } else if (!comment && c != ' ' && c != '\t' && c != '\r') {
            break;
        }
        rest_.remove_prefix(1);
    }
}

bool NumberScanner::atEnd() {
    skipBlanks();
    return rest_.empty();
}

std::string_view NumberScanner::word() {
    skipBlanks();
    const std::size_t end = std::min(rest_.find_first_of(" \t\r\n#"), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(end);
    return word;
}

double NumberScanner::number(const std::string& field) {
    const std::string_view text = word();
    if (text.empty()) fail("ends before " + field);
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        fail(field + " is '" + std::string(text.substr(0, 40)) + "', not a finite number");
    return value;
}

int NumberScanner::integer(const std::string& field, int least, int most) {
    const double value = number(field);
    if (!(value >= least && value <= most) || value != std::floor(value))
        fail(field + " must be an integer of " + std::to_string(least) + ".." + std::to_string(most));
    return int(value);
}

void NumberScanner::fail(const std::string& problem) const {
    throw InvalidInput(name_ + ": line " + std::to_string(line_) + ": " + problem);
}

}  // namespace penumbra
