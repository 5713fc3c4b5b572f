#include "formats/asset_file.h"
