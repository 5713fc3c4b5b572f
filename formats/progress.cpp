#include "formats/progress.h"
