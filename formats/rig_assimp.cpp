#include "formats/rig_file.h"
