#pragma once
#include <cstdint>
#include <string>

#include "formats/common/random_bytes.h"

namespace penumbra {

// Inflates `packed`, a raw deflate stream (RFC 1951), into a file of the folder for temporary files (TMPDIR, or
// /var/tmp), which has no name any more, so that nothing stays behind. Memory does not grow with `size`. Throws
// InvalidInput "WHAT: ..." where the stream is damaged, ends before `packed` does or gives another size or checksum,
// and IoError "WHAT: ..." where the folder has no room for `size` bytes.
RandomBytes inflateToFile(const RandomBytes& packed, std::uint64_t size, std::uint32_t crc, const std::string& what);

}  // namespace penumbra
