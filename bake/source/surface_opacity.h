#pragma once
// How many rays the triangles of a rig stop, by the alpha of their materials.
#include "formats/rig/rig_file.h"

namespace penumbra {

// Fills rig.mesh.opacity with the triangles whose materials say MASK or BLEND and whose texels are not all opaque.
// Adds the pictures that it reads to rig.files_read. A part whose alpha cannot be known stays opaque, and a note says
// why.
void readOpacity(Rig& rig);

}  // namespace penumbra
