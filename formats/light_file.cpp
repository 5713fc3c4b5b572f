#include "formats/light_file.h"

#include <cassert>

#include "formats/errors.h"
#include "formats/stage_parts.h"
#include "formats/write_file.h"
#include "sh/sh_basis.h"

namespace penumbra {

constexpr FileKind kKind{"penumbra.light", kLightVersion};

void writeLight(const std::filesystem::path& path, const LightFile& light) {
    const hsize_t count = hsize_t(coefficientCount(light.order));
    assert(light.sh.size() == count * 3);
    PartialFile partial(path);
    Hdf5Handle file = createHdf5(partial.path());
    writeRoot(file, kKind, light.order, light.provenance);
    writeTextAttribute(file, "/", "name", light.name);
    writeDoubles(file, "/light/sh", light.sh, {count, 3});
    writeNumberAttribute(file, "/light", "residual", light.residual);
    closeHdf5(file);
    partial.commit();
}

LightFile readLight(const std::filesystem::path& path) {
    const Hdf5Reader in = openHdf5(path);
    LightFile light;
    light.order = readRoot(in, kKind, light.provenance);
    light.name = readTextAttribute(in, "/", "name");
    std::vector<hsize_t> shape{hsize_t(coefficientCount(light.order)), 3};
    light.sh = readDoubles(in, "/light/sh", shape);
    light.residual = readNumberAttribute(in, "/light", "residual");
    if (light.residual < 0) throw InvalidInput(in.name + ": /light residual: negative");
    return light;
}

}  // namespace penumbra
