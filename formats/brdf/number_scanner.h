#pragma once
// Scans the words and numbers of a text file, between blanks and line ends. '#' starts a comment up to the end of the
// line.
#include <string>
#include <string_view>

namespace penumbra {

class NumberScanner {
public:
    NumberScanner(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

    bool atEnd();                             // only blanks and comments are left
    std::string_view word();                  // "" at the end of the text
    double number(const std::string& field);  // finite; otherwise throws InvalidInput
    int integer(const std::string& field, int least, int most);
    [[noreturn]] void fail(const std::string& problem) const;  // throws InvalidInput with the file's name and the line

private:
    void skipBlanks();

    std::string_view rest_;
    std::string name_;
    int line_ = 1;
};

}  // namespace penumbra
