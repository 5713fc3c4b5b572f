#pragma once
#include "formats/stage/visibility_file.h"

namespace penumbra {

// The properties of the bake that a model of a skinned character keeps.
struct CharacterParts {
    const Mesh& mesh;
    const Skin& skin;
    const std::vector<std::string>& input_names;
    std::size_t pose_size;
};
// Throws InvalidInput where the poses of `file` are those of another character.
void checkSameCharacter(const CharacterParts& model, const VisibilityHeader& header, const std::string& file);

}  // namespace penumbra
