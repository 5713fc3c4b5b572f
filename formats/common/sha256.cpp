#include "formats/common/sha256.h"

#include <algorithm>
#include <bit>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <vector>
#ifdef __x86_64__
#include <cpuid.h>
#include <immintrin.h>
#endif

#include "formats/common/errors.h"

namespace penumbra {

namespace {

// The first 32 bits of the fractional parts of the cube roots of the first 64 primes (FIPS 180-4, 4.2.2).
constexpr std::uint32_t kRound[64] = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

#ifdef __x86_64__

bool hasShaInstructions() {
    unsigned a = 0, b = 0, c = 0, d = 0;
    return __builtin_cpu_supports("sse4.1") && __get_cpuid_count(7, 0, &a, &b, &c, &d) != 0 && (b >> 29 & 1) != 0;
}

// One block by the SHA extensions of x86-64, which take four rounds in two instructions (Intel's manual, volume 2,
// SHA256RNDS2). They want the state as (f, e, b, a) and (h, g, d, c) from the lowest word on.
__attribute__((target("sha,sse4.1"))) void compressByInstructions(std::uint32_t* state, const std::uint8_t* block) {
    const __m128i big_endian = _mm_set_epi64x(0x0c0d0e0f08090a0bLL, 0x0405060700010203LL);
    auto* words = reinterpret_cast<__m128i*>(state);
    const __m128i badc = _mm_shuffle_epi32(_mm_loadu_si128(words), 0xb1);
    const __m128i hgfe = _mm_shuffle_epi32(_mm_loadu_si128(words + 1), 0x1b);
    const __m128i before_feba = _mm_alignr_epi8(badc, hgfe, 8), before_hgdc = _mm_blend_epi16(hgfe, badc, 0xf0);
    __m128i feba = before_feba, hgdc = before_hgdc;
    __m128i w[4] = {};  // the last 16 words of the message schedule
    for (std::size_t four = 0; four < 16; ++four) {
        __m128i& next = w[four % 4];
        const __m128i last = w[(four + 3) % 4];
        if (four < 4) {
            next = _mm_loadu_si128(reinterpret_cast<const __m128i*>(block) + four);
            next = _mm_shuffle_epi8(next, big_endian);
        } else {
            const __m128i middle = _mm_alignr_epi8(last, w[(four + 2) % 4], 4);
            next = _mm_add_epi32(_mm_sha256msg1_epu32(next, w[(four + 1) % 4]), middle);
            next = _mm_sha256msg2_epu32(next, last);
        }
        const __m128i round = _mm_loadu_si128(reinterpret_cast<const __m128i*>(kRound) + four);
        const __m128i sum = _mm_add_epi32(next, round);
        hgdc = _mm_sha256rnds2_epu32(hgdc, feba, sum);
        feba = _mm_sha256rnds2_epu32(feba, hgdc, _mm_shuffle_epi32(sum, 0x0e));
    }
    feba = _mm_shuffle_epi32(_mm_add_epi32(feba, before_feba), 0x1b);
    hgdc = _mm_shuffle_epi32(_mm_add_epi32(hgdc, before_hgdc), 0xb1);
    _mm_storeu_si128(words, _mm_blend_epi16(feba, hgdc, 0xf0));
    _mm_storeu_si128(words + 1, _mm_alignr_epi8(hgdc, feba, 8));
}

#else

bool hasShaInstructions() { return false; }
void compressByInstructions(std::uint32_t*, const std::uint8_t*) {}

#endif

}  // namespace

// The start state has the first 32 bits of the fractional parts of the square roots of the first 8 primes (5.3.3).
Sha256::Sha256()
    : state_{0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a, 0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19},
      block_{},
      has_instructions_(hasShaInstructions() && !std::getenv("PENUMBRA_NO_SIMD")) {}

void Sha256::compress(const std::uint8_t* block) {
    if (has_instructions_) return compressByInstructions(state_.data(), block);
    using std::rotr;
    std::uint32_t w[64];
    for (int t = 0; t < 16; ++t)
        w[t] = std::uint32_t(block[4 * t]) << 24 | std::uint32_t(block[4 * t + 1]) << 16 |
               std::uint32_t(block[4 * t + 2]) << 8 | block[4 * t + 3];
    for (int t = 16; t < 64; ++t) {
        const std::uint32_t s0 = rotr(w[t - 15], 7) ^ rotr(w[t - 15], 18) ^ w[t - 15] >> 3;
        const std::uint32_t s1 = rotr(w[t - 2], 17) ^ rotr(w[t - 2], 19) ^ w[t - 2] >> 10;
        w[t] = w[t - 16] + s0 + w[t - 7] + s1;
    }
    auto [a, b, c, d, e, f, g, h] = state_;
    for (int t = 0; t < 64; ++t) {
        const std::uint32_t s1 = rotr(e, 6) ^ rotr(e, 11) ^ rotr(e, 25), choice = (e & f) ^ (~e & g);
        const std::uint32_t s0 = rotr(a, 2) ^ rotr(a, 13) ^ rotr(a, 22), majority = (a & b) ^ (a & c) ^ (b & c);
        const std::uint32_t t1 = h + s1 + choice + kRound[t] + w[t], t2 = s0 + majority;
        h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
    }
    const std::array<std::uint32_t, 8> sum{a, b, c, d, e, f, g, h};
    for (int i = 0; i < 8; ++i) state_[i] += sum[i];
}

void Sha256::update(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const std::size_t used = length_ % 64, take = std::min<std::size_t>(64 - used, bytes.size());
        if (take == 64) {
            compress(reinterpret_cast<const std::uint8_t*>(bytes.data()));
        } else {
            std::memcpy(block_.data() + used, bytes.data(), take);
            if (used + take == 64) compress(block_.data());
        }
        length_ += take;
        bytes = bytes.subspan(take);
    }
}

std::string Sha256::hex() {
    const std::uint64_t bits = 8 * length_;
    std::vector<std::byte> padding(1 + (119 - length_ % 64) % 64, std::byte(0));
    padding[0] = std::byte(0x80);
    for (int shift = 56; shift >= 0; shift -= 8) padding.push_back(std::byte(bits >> shift));
    update(padding);
    std::string text;
    for (std::uint32_t word : state_)
        for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 15];
    return text;
}

std::string sha256Hex(std::span<const std::byte> bytes) {
    Sha256 hash;
    hash.update(bytes);
    return hash.hex();
}

std::string sha256OfFile(const std::filesystem::path& path) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"), std::fclose);
    if (!file) throw IoError(path.string() + ": cannot read: " + std::strerror(errno));
    Sha256 hash;
    std::vector<std::byte> buffer(1 << 20);
    while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file.get()))
        hash.update(std::span(buffer).first(count));
    if (std::ferror(file.get())) throw IoError(path.string() + ": cannot read: " + std::strerror(errno));
    return hash.hex();
}

}  // namespace penumbra
