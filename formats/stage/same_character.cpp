#include "formats/stage/same_character.h"

#include "formats/common/errors.h"

namespace penumbra {

void checkSameCharacter(const CharacterParts& model, const VisibilityHeader& header, const std::string& file) {
    const auto refuse = [&](const char* field) {
        throw InvalidInput(file + ": " + field + " of the poses is not that of the model: another character");
    };
    if (!header.skin || header.skin->joint_names != model.skin.joint_names) refuse("/skin/joint_names");
    if (header.mesh.two_sided != model.mesh.two_sided) refuse("attribute two_sided");
    if (header.mesh.vertexCount() != model.mesh.vertexCount()) refuse("/mesh/rest_positions");
    if (header.mesh.triangles != model.mesh.triangles) refuse("/mesh/triangles");
    if (header.input_names != model.input_names) refuse("/inputs/names");
    if (std::size_t(header.pose_size) != model.pose_size) refuse("/frames/pose");
}

}  // namespace penumbra
