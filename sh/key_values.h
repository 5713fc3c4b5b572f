#pragma once
// Parses "key=value,key=value", the small language of cameras and BRDFs. Every failure is a std::invalid_argument with
// one sentence that names what is wrong, the range and the value.
#include <string>
#include <string_view>
#include <vector>

#include "sh/vec3.h"

namespace penumbra {

struct KeyValue {
    std::string_view key, value;
};

// Splits a text into its items; "" has none. An item without '=' or with an empty side, and a key that comes twice, are
// errors.
std::vector<KeyValue> splitKeyValues(std::string_view text);

// Returns a finite number in [least, most]; `what` names it in the message.
double parseNumber(std::string_view what, std::string_view text, double least, double most);
// Returns as few digits as are needed to read back the same number.
std::string shortest(double value);
std::string shortest(float value);
// Reads "x/y/z", or one number for all three.
Vec3d parseTriple(std::string_view what, std::string_view text, double least, double most);

}  // namespace penumbra
