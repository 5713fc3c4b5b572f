/* Compiled as C99, pedantic, warnings as errors: the header needs nothing else, and its types are complete. */
#include "runtime/penumbra.h"

size_t sizes_seen_by_c(void);

size_t sizes_seen_by_c(void) {
    return sizeof(penumbra_error) + sizeof(penumbra_asset_info) + sizeof(penumbra_clip) + sizeof(penumbra_frame) +
           sizeof(penumbra_material) + sizeof(penumbra_light) + sizeof(penumbra_cluster) +
           sizeof(penumbra_shading_options) + sizeof(penumbra_vertices) + sizeof(penumbra_lobe) + sizeof(penumbra_sun) +
           sizeof(penumbra_sun_caster);
}
