#pragma once
// Puts the fields of a character and of the occluders that it was baked with together (docs/formulas.md, section 7).
#include <span>
#include <string>

#include "formats/stage/field_file.h"
#include "formats/stage/model_file.h"
#include "formats/stage/visibility_file.h"

namespace penumbra {

// Throws InvalidInput or UsageError unless the files are those of the character in `header` (at most one, which a
// skeleton must have and a deforming mesh cannot have) and of occluders that its bake had, which stand still or move
// with a point of its inputs. `file` names the visibility file in messages.
void checkFields(const VisibilityHeader& header, const std::string& file, std::span<const FieldFile> fields);

// Makes the parts of a model whose mesh, skin and input joints are set, from fields that passed checkFields(). Parts of
// the character come first. Every vertex sees all occluders. The vertices of a deforming mesh belong to part 0 and see
// nothing else. `header` is that of the bake.
Composition compositionOf(const Model& model, std::span<const FieldFile> fields, const VisibilityHeader& header);

// Tells which joints are input joints that a part of the composition moves with, [J]. No model needs to learn these.
std::vector<bool> composedInputs(const Model& model);

}  // namespace penumbra
