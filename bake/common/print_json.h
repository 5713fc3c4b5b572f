#pragma once
#include <nlohmann/json.hpp>

namespace penumbra {

// Prints an object on stdout, a line each value. Objects and arrays with others inside are indented.
void printJson(const nlohmann::ordered_json& object);

}  // namespace penumbra
