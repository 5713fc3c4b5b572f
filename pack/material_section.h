#pragma once
#include "formats/stage/brdf_file.h"
#include "pack/asset_writer.h"

namespace penumbra {

// Unsupported: operators over functions that are not even in z.
void checkMaterial(const BrdfFile& brdf);

// One slice set and a colour where the three channels differ by a factor only (1e-6 of the largest entry), else three,
// in the most compact form; operators, where the file has them, likewise a set a channel.
Offset<fbs::Material> writeMaterial(FlatBufferBuilder& builder, const BrdfFile& brdf);

}  // namespace penumbra
