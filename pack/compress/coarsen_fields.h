#pragma once
#include "formats/common/part_fields.h"

namespace penumbra {

// Makes fields that take fewer bytes once they are compressed. A byte 1 of any level and band comes to stand for
// `step` r^2 at least, r the radius of the part, and the bytes become smaller for it. At the distance d from its center
// V is then rounded by step / (2 d^2 / r^2 + 1/2) at most. What is coarser already stays as it is; step > 0.
void coarsenFields(float step, PartFields& fields);

}  // namespace penumbra
