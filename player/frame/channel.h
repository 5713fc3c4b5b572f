#pragma once
// Tells what a picture shows.
#include <string>
#include <string_view>

namespace penumbra {

enum class Channel {
    kShaded,          // radiance towards the eye, negative values (ringing of truncated SH) as 0
    kAmbient,         // E, cosine-weighted visibility / pi; 1 = unshadowed
    kError,           // |E - E of the baked truth| as a colour, viridis from 0 to RenderOptions::error_max
    kClusters,        // one colour a cluster
    kNormals,         // unit normal n, model frame, as n/2 + 1/2
    kParts,           // one colour a rigid part, only for composed assets
    kBouncedAmbient,  // E with the light that surfaces reflect to one another, only for assets that have it
    kTransferError,   // E_transfer against the baked truth (transfer_error.h), coloured as kError; CPU path only
};

// Tells whether a channel compares with the truth.
constexpr bool needsTruth(Channel channel) { return channel == Channel::kError || channel == Channel::kTransferError; }

// Reads "shaded", "ao", "error", "clusters", "normals", "parts", "ao-bounced" or "transfer-error". Throws UsageError
// for other words.
Channel parseChannel(std::string_view word);
std::string_view nameOf(Channel channel);

}  // namespace penumbra
