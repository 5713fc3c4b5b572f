#include "formats/sha256.h"
