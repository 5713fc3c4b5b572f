#include "fit/compare/compare_character.h"

#include <algorithm>

#include "fit/clusters/tangent_frames.h"

namespace penumbra {

CompareCharacter prepareCharacter(const CompareInput& input, const CompareOptions& options) {
    const VisibilityHeader& header = input.reader.header();
    CompareCharacter character;
    character.clusters =
        clustersOf(header.mesh, input.poses, std::size_t(options.referenceClusters()), options.threads);
    character.rest_tangents = restTangents(header.mesh, header.rest_normals, character.clusters, options.threads);
    for (std::size_t f = 0; f < header.frames.frameCount(); ++f) {
        const std::string& clip = header.frames.clip_names[header.frames.clip[f]];
        const bool held = std::find(options.holdout.begin(), options.holdout.end(), clip) != options.holdout.end();
        (held ? character.held_out : character.train).push_back(f);
    }
    return character;
}

}  // namespace penumbra
