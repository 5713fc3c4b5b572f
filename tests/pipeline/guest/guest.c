#include <penumbra.h>
#include <stdio.h>

int main(void) {
    penumbra_asset* asset = NULL;
    penumbra_error error;
    if (penumbra_asset_open_memory("no asset", 8, PENUMBRA_COPY, &asset, &error) != PENUMBRA_INVALID_ASSET) return 1;
    printf("%s: %s\n", penumbra_version(), error.message);
    return 0;
}
