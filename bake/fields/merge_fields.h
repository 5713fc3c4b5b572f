#pragma once
// Merges shards of x.fields.h5, which `penumbra-bake fields --parts` made, to the very file that one run makes.
#include <filesystem>
#include <vector>

#include "formats/stage/field_file.h"

namespace penumbra {

// Tells whether any of these files that can be read holds fields.
bool anyHoldsFields(const std::vector<std::filesystem::path>& paths);

// Reads the shards and puts their parts together. Throws the errors of readFieldShard(), and InvalidInput that names
// every gap, every overlap, and every shard of another input or with other options.
FieldFile mergeFields(const std::vector<std::filesystem::path>& paths);

}  // namespace penumbra
