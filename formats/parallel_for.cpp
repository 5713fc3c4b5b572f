#include "formats/parallel_for.h"
