#pragma once
// Words and numbers of a text file, blanks and line ends between them; '#' starts a comment that ends with its line.
#include <string>
#include <string_view>

namespace penumbra {

class NumberScanner {
public:
    NumberScanner(std::string_view text, std::string name) : rest_(text), name_(std::move(name)) {}

    bool atEnd();                             // nothing but blanks and comments is left
    std::string_view word();                  // "" at the end of the text
    double number(const std::string& field);  // finite, else InvalidInput
    int integer(const std::string& field, int least, int most);
    [[noreturn]] void fail(const std::string& problem) const;  // InvalidInput with the file's name and the line

private:
    void skipBlanks();

    std::string_view rest_;
    std::string name_;
    int line_ = 1;
};

}  // namespace penumbra
