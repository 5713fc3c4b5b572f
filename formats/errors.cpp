#include "formats/errors.h"
