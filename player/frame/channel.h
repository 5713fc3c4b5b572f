#pragma once
// Tells what a picture shows.
#include "formats/common/words.h"

namespace penumbra {

enum class Channel {
    kShaded,          // radiance towards the eye, negative values (ringing of truncated SH) as 0
    kAmbient,         // E, cosine-weighted visibility / pi; 1 = unshadowed
    kError,           // |E - E of the baked truth| as a colour, viridis from 0 to RenderOptions::error_max
    kClusters,        // one colour a cluster
    kNormals,         // unit normal n, model frame, as n/2 + 1/2
    kParts,           // one colour a rigid part, only for composed assets
    kBouncedAmbient,  // E with the light that surfaces reflect to one another, only for assets that have it
    kTransferError,   // E_transfer against the baked truth (papers/transfer_error.h), coloured as kError; CPU path only
};

// Tells whether a channel compares with the truth.
constexpr bool needsTruth(Channel channel) { return channel == Channel::kError || channel == Channel::kTransferError; }

inline constexpr Word<Channel> kChannelWords[] = {{"shaded", Channel::kShaded},
                                                  {"ao", Channel::kAmbient},
                                                  {"error", Channel::kError},
                                                  {"clusters", Channel::kClusters},
                                                  {"normals", Channel::kNormals},
                                                  {"parts", Channel::kParts},
                                                  {"ao-bounced", Channel::kBouncedAmbient},
                                                  {"transfer-error", Channel::kTransferError}};
constexpr std::string_view nameOf(Channel channel) { return wordOf(kChannelWords, channel); }

}  // namespace penumbra
