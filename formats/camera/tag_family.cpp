#include "formats/camera/tag_family.h"

#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h11.h>

#include <cstdlib>
#include <cstring>
#include <new>

namespace penumbra {

// OpenCV 4.6, modules/aruco/src/predefined_dictionaries.hpp: two bytes a tag, of the tag upright.
const std::array<std::uint16_t, 50> kAruco4x4 = {
    0xb532, 0x0f9a, 0x332d, 0x9946, 0x549e, 0x79cd, 0x9e2e, 0xc4f2, 0xfeda, 0xcf56, 0xf991, 0x11a7, 0x0eb7,
    0x2a0f, 0x24b1, 0x263e, 0x4665, 0x6600, 0x6c5e, 0x76af, 0x868b, 0xb02b, 0xccd5, 0xdd82, 0xfe47, 0x9471,
    0xace4, 0xa554, 0x2123, 0x346f, 0x4415, 0x57b2, 0x9ecf, 0xf0cb, 0x08ae, 0x0929, 0x1875, 0x04ff, 0x0df6,
    0x1c5a, 0x1718, 0x2a28, 0x328c, 0x38b2, 0x24e8, 0x2eeb, 0x2d3f, 0x4b64, 0x502e, 0x5013};

namespace {

constexpr int kSide = 4, kBits = kSide * kSide;

// libapriltag frees nothing of a family that it has not made.
void destroyAruco(apriltag_family_t* family) {
    std::free(family->codes);
    std::free(family->bit_x);
    std::free(family->bit_y);
    std::free(family->name);
    std::free(family);
}

template <class T>
T* cleared(std::size_t count) {
    void* memory = std::calloc(count, sizeof(T));
    if (!memory) throw std::bad_alloc();
    return static_cast<T*>(memory);
}

// libapriltag turns a tag by a quarter when it rotates its code by a quarter of the bits. The bits therefore stand in
// four groups, each of which is the one before it, turned.
FamilyPointer makeAruco() {
    FamilyPointer family(cleared<apriltag_family_t>(1), destroyAruco);
    family->ncodes = kAruco4x4.size();
    family->codes = cleared<std::uint64_t>(kAruco4x4.size());
    family->width_at_border = kSide + 2;
    family->total_width = kSide + 4;
    family->nbits = kBits;
    family->bit_x = cleared<std::uint32_t>(kBits);
    family->bit_y = cleared<std::uint32_t>(kBits);
    family->h = 3;
    family->name = strdup("4x4_50");
    constexpr int kFirst[kSide][2] = {{1, 1}, {2, 1}, {3, 1}, {2, 2}};  // x, y of a quarter: 0 is the black border
    for (int bit = 0; bit < kBits; ++bit) {
        int x = kFirst[bit % kSide][0], y = kFirst[bit % kSide][1];
        for (int quarter = 0; quarter < bit / kSide; ++quarter) {
            const int old_x = x;
            x = kSide + 1 - y;
            y = old_x;
        }
        family->bit_x[bit] = std::uint32_t(x);
        family->bit_y[bit] = std::uint32_t(y);
        const int place = kBits - 1 - ((y - 1) * kSide + x - 1);
        for (std::size_t tag = 0; tag < kAruco4x4.size(); ++tag)
            family->codes[tag] = 2 * family->codes[tag] + (kAruco4x4[tag] >> place & 1);
    }
    return family;
}

}  // namespace

FamilyPointer makeFamily(TagFamily family) {
    switch (family) {
        case TagFamily::k36h11:
            return {tag36h11_create(), tag36h11_destroy};
        case TagFamily::k25h9:
            return {tag25h9_create(), tag25h9_destroy};
        case TagFamily::k16h5:
            return {tag16h5_create(), tag16h5_destroy};
        case TagFamily::k4x4_50:
            break;
    }
    return makeAruco();
}

}  // namespace penumbra
