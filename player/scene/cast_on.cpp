#include "player/scene/cast_on.h"

#include <algorithm>

#include "formats/common/parallel_for.h"

namespace penumbra {

namespace {

constexpr std::size_t kPiece = 512;  // receivers that a thread takes at once

}  // namespace

std::size_t castOn(const CastShadow& cast, CasterChoice choice, const CastReceivers& receivers, int threads,
                   std::vector<float>& mirrored) {
    const std::size_t count = receivers.positions.size(), pieces = (count + kPiece - 1) / kPiece;
    mirrored.resize(count * kFarNumbers);
    std::vector<std::size_t> seen(pieces);
    parallelFor(pieces, threads, [&](std::size_t piece) {
        const std::size_t first = piece * kPiece, n = std::min(kPiece, count - first);
        seen[piece] = cast.evaluate({receivers.positions.subspan(first, n), receivers.normals.subspan(first, n),
                                     receivers.tangents.subspan(first, n)},
                                    choice, std::span(mirrored).subspan(first * kFarNumbers, n * kFarNumbers));
    });
    std::size_t all = 0;
    for (const std::size_t n : seen) all += n;
    return all;
}

}  // namespace penumbra
