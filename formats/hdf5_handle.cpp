#include "formats/hdf5_handle.h"
