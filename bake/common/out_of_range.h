#pragma once
#include <sstream>
#include <string>

namespace penumbra {

// Returns "--rays must be 16..65536 directions, not 3", what findProblem() says of an option.
template <class T>
std::string outOfRange(const char* option, const char* range, T value) {
    std::ostringstream text;
    text << option << " must be " << range << ", not " << value;
    return text.str();
}

}  // namespace penumbra
