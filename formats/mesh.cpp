#include "formats/mesh.h"
