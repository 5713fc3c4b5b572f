#pragma once
#include "formats/stage/brdf_file.h"
#include "pack/sections/asset_writer.h"

namespace penumbra {

// Throws Unsupported for operators over functions that are not even in z.
void checkMaterial(const BrdfFile& brdf);

// Writes one slice set and a colour where the three channels differ only by a factor (within 1e-6 of the largest
// entry), and three slice sets otherwise, in the most compact form. Operators, where the file has them, are also
// written as one set for each channel.
Offset<fbs::Material> writeMaterial(FlatBufferBuilder& builder, const BrdfFile& brdf);

}  // namespace penumbra
