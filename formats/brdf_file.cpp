#include "formats/brdf_file.h"
