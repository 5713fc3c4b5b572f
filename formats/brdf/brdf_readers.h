#pragma once
// Reads BRDF files from bytes in memory; each source file reads one kind. `name` starts every message.
// formats/README.md describes the formats.
#include <string>
#include <string_view>

#include "formats/brdf/brdf_source.h"

namespace penumbra {

bool looksLikeMerl(std::string_view bytes);
BrdfReading decodeMerl(std::string_view bytes, const std::string& name);

bool looksLikeFits(std::string_view text);
BrdfReading decodeFits(std::string_view text, const std::string& name, const std::string& material);

bool looksLikeBrdfTable(std::string_view text);
BrdfReading decodeBrdfTable(std::string_view text, const std::string& name);

BrdfReading decodeScattered(std::string_view text, const std::string& name, int threads);

}  // namespace penumbra
