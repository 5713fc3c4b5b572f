#pragma once
// The nodes of an FBX file, binary (6.x and 7.x) or ASCII, as they stand there: names and values, and of the arrays
// only those that fbx_scan.h looks into. Nothing is evaluated.
//
// Binary: "Kaydara FBX Binary  \0\x1a\0", u32 version, then records until an empty one: end, number of values, bytes of
// values (u32 each, u64 from version 7500 on), u8 length of the name, the name, the values, child records until an
// empty one. A value is a letter and its bytes; arrays are deflated or not.
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra {

struct FbxValue {
    std::string text;          // a string; in ASCII files also a bare word such as T, L or a number
    double number = 0;         // 0 for strings
    std::int64_t integer = 0;  // for whole numbers
};

struct FbxNode {
    std::string name;
    std::vector<FbxValue> values;  // the first kMaxFbxValues; none of the bytes of pictures
    std::vector<double> numbers;   // an array, if it is looked into
    std::uint64_t count = 0;       // how many numbers an array has, or values an ASCII list
    std::vector<FbxNode> children;

    // Returns the first child of that name, or null.
    const FbxNode* child(std::string_view child_name) const;
    // Returns the value at that place, or an empty one.
    const FbxValue& value(std::size_t index) const;
};

constexpr std::size_t kMaxFbxValues = 64;

struct FbxTree {
    int version = 0;  // 7400
    bool ascii = false;
    FbxNode root;
};

// Reads a file. Throws IoError, and InvalidInput where it is no FBX file, damaged or cut short.
FbxTree readFbxTree(const std::filesystem::path& path);

// The same for bytes in memory; `path` is for messages.
FbxTree parseFbxTree(std::string_view bytes, const std::filesystem::path& path);
FbxTree parseFbxText(std::string_view text, const std::filesystem::path& path);

// Tells whether the numbers of an array of this name are kept, and counts them against the most that a file may have.
bool isFbxArrayRead(std::string_view name);
constexpr std::uint64_t kMaxFbxNumbers = std::uint64_t(1) << 26;
constexpr std::uint64_t kMaxFbxNodes = std::uint64_t(1) << 23;
constexpr int kDeepestFbxNode = 64;

}  // namespace penumbra
