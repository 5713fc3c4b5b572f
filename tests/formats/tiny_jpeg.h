#pragma once
// A JPEG file of 16 x 8 pixels, made with Pillow 9.4: the left half is (200, 40, 40), the right one (30, 60, 220).
#include <cstddef>
#include <string>
#include <vector>

namespace penumbra::samples {

inline std::vector<std::byte> tinyJpeg() {
    const std::string hex =
        "ffd8ffe000104a46494600010100000100010000ffdb0043000302020302020303030304030304050805050404050a070706080c0a0c0c"
        "0b"
        "0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f171816141812141514ffdb00430103040405040509050509140d0b0d141414"
        "14"
        "14141414141414141414141414141414141414141414141414141414141414141414141414141414141414141414141414ffc000110800"
        "08"
        "001003011100021101031101ffc4001500010100000000000000000000000000000607ffc4001410010000000000000000000000000000"
        "00"
        "00ffc400160101010100000000000000000000000000090708ffc40014110100000000000000000000000000000000ffda000c03010002"
        "11"
        "0311003f008a26edaa1a4ac6fbffd9";
    std::vector<std::byte> bytes;
    for (std::size_t i = 0; i < hex.size(); i += 2)
        bytes.push_back(std::byte(std::stoi(hex.substr(i, 2), nullptr, 16)));
    return bytes;
}

}  // namespace penumbra::samples
