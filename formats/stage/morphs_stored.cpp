#include "formats/stage/morphs_stored.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

constexpr const char* kNames = "/mesh/morphs/names";
constexpr const char* kFirst = "/mesh/morphs/first";
constexpr const char* kVertices = "/mesh/morphs/vertices";

// Checks that every target has a range of the rows, one after the other, and each vertex once.
void checkRows(const Hdf5Reader& in, const MorphTargets& morphs) {
    if (morphs.first.front() != 0 || morphs.first.back() != morphs.vertices.size() ||
        !std::is_sorted(morphs.first.begin(), morphs.first.end()))
        throw InvalidInput(in.name + ": " + kFirst + ": are not ranges of the " +
                           std::to_string(morphs.vertices.size()) + " rows");
    for (std::size_t m = 0; m < morphs.count(); ++m)
        for (std::size_t r = morphs.first[m] + 1; r < morphs.first[m + 1]; ++r)
            if (morphs.vertices[r] <= morphs.vertices[r - 1])
                throw InvalidInput(in.name + ": " + kVertices + ": row " + std::to_string(r) + " does not ascend");
}

}  // namespace

void writeMorphs(hid_t file, const MorphTargets& morphs) {
    if (morphs.empty()) return;
    writeStrings(file, kNames, morphs.names);
    writeFloats(file, "/mesh/morphs/rest_weights", morphs.rest_weights, {morphs.count()});
    writeIndices(file, kFirst, morphs.first);
    if (morphs.vertices.empty()) return;
    writeIndices(file, kVertices, morphs.vertices);
    writeVectors(file, "/mesh/morphs/positions", morphs.positions);
    writeVectors(file, "/mesh/morphs/normals", morphs.normals);
}

MorphTargets readMorphs(const Hdf5Reader& in, std::size_t vertices) {
    MorphTargets morphs;
    if (!exists(in, kNames)) return morphs;
    morphs.names = readStrings(in, kNames);
    if (morphs.names.empty() || morphs.names.size() > 65535)
        throw InvalidInput(in.name + ": " + kNames + ": " + std::to_string(morphs.names.size()) + " targets");
    checkUnique(in, kNames, morphs.names);
    morphs.rest_weights = readExactly(in, "/mesh/morphs/rest_weights", {morphs.count()});
    morphs.first = readIndices(in, kFirst, morphs.count() + 1, std::size_t(UINT32_MAX));
    if (exists(in, kVertices)) {
        morphs.vertices = readIndices(in, kVertices, 0, vertices);
        morphs.positions = readVectors(in, "/mesh/morphs/positions", morphs.vertices.size());
        morphs.normals = readVectors(in, "/mesh/morphs/normals", morphs.vertices.size());
    }
    checkRows(in, morphs);
    return morphs;
}

void checkMorphInputs(const Hdf5Reader& in, const MorphTargets& morphs, const std::vector<std::string>& inputs) {
    if (inputs.size() < morphs.count() || !std::equal(morphs.names.rbegin(), morphs.names.rend(), inputs.rbegin()))
        throw InvalidInput(in.name + ": /inputs/names: do not end with the names of " + kNames);
}

}  // namespace penumbra
