#include "formats/write_file.h"
