#include "formats/image_file.h"
