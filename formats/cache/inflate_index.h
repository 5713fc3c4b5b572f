#pragma once
// Random access into a raw deflate stream (RFC 1951) in bounded memory.
#include <cstdint>
#include <string>

#include "formats/common/random_bytes.h"

namespace penumbra {

// Decompresses `packed` once to check its size and CRC-32, and keeps a copy of the decoder (40 KB) every megabyte of
// output, so that a read starts there and not at the beginning. Reads that follow one another go on where the last one
// ended. InvalidInput "WHAT: ..." where the stream is damaged or gives another size or checksum.
RandomBytes inflateIndexed(const RandomBytes& packed, std::uint64_t size, std::uint32_t crc, const std::string& what);

}  // namespace penumbra
