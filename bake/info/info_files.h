#pragma once
// Describes one file of each kind as JSON, each in a source of its own. All throw IoError, and InvalidInput and
// Unsupported with the file and the field.
#include <filesystem>

#include "bake/info/describe.h"

namespace penumbra {

// Which vertices the figures of coefficients are made of.
enum class VertexSample { kSome, kAll };
Json describeVisibility(const std::filesystem::path& path, VertexSample sample);
Json describeModel(const std::filesystem::path& path);
Json describeTransfer(const std::filesystem::path& path);
Json describeLobeModel(const std::filesystem::path& path);
Json describeBrdf(const std::filesystem::path& path);
Json describeLight(const std::filesystem::path& path);
Json describePoses(const std::filesystem::path& path);
Json describeFields(const std::filesystem::path& path);
Json describeBlockers(const std::filesystem::path& path);
// A rig or a point cache, as it would be baked without options: its parts, clips, and what its reader does not do.
Json describeSource(const std::filesystem::path& path);
Json describeAsset(const std::filesystem::path& path);

}  // namespace penumbra
