#include "formats/provenance.h"
