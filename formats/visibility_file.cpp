#include "formats/visibility_file.h"
