#include "formats/light_file.h"
