#include "formats/stage/morphs_stored.h"

#include <algorithm>

#include "formats/common/errors.h"
#include "formats/stage/stage_parts.h"

namespace penumbra {

namespace {

// Checks that every target has a range of the rows, one after the other, and each vertex once.
void checkTargets(const Hdf5Reader& in, const MorphTargets& morphs, const std::string& group) {
    if (morphs.first.front() != 0 || morphs.first.back() != morphs.vertices.size() ||
        !std::is_sorted(morphs.first.begin(), morphs.first.end()))
        throw InvalidInput(in.name + ": " + group + "first: are not ranges of the " +
                           std::to_string(morphs.vertices.size()) + " rows");
    for (std::size_t m = 0; m < morphs.count(); ++m)
        for (std::size_t r = morphs.first[m] + 1; r < morphs.first[m + 1]; ++r)
            if (morphs.vertices[r] <= morphs.vertices[r - 1])
                throw InvalidInput(in.name + ": " + group + "vertices: row " + std::to_string(r) + " does not ascend");
}

}  // namespace

void writeMorphs(hid_t file, const MorphTargets& morphs, const std::string& mesh) {
    if (morphs.empty()) return;
    const std::string group = mesh + "/morphs/";
    writeStrings(file, group + "names", morphs.names);
    writeFloats(file, group + "rest_weights", morphs.rest_weights, {morphs.count()});
    writeIndices(file, group + "first", morphs.first);
    if (morphs.vertices.empty()) return;
    writeIndices(file, group + "vertices", morphs.vertices);
    writeVectors(file, group + "positions", morphs.positions);
    writeVectors(file, group + "normals", morphs.normals);
}

MorphTargets readMorphs(const Hdf5Reader& in, std::size_t vertices, const std::string& mesh) {
    MorphTargets morphs;
    const std::string group = mesh + "/morphs/";
    if (!exists(in, group + "names")) return morphs;
    morphs.names = readStrings(in, group + "names");
    if (morphs.names.empty() || morphs.names.size() > 65535)
        throw InvalidInput(in.name + ": " + group + "names" + ": " + std::to_string(morphs.names.size()) + " targets");
    checkUnique(in, group + "names", morphs.names);
    morphs.rest_weights = readExactly(in, group + "rest_weights", {morphs.count()});
    morphs.first = readIndices(in, group + "first", morphs.count() + 1, std::size_t(UINT32_MAX));
    if (exists(in, group + "vertices")) {
        morphs.vertices = readIndices(in, group + "vertices", 0, vertices);
        morphs.positions = readVectors(in, group + "positions", morphs.vertices.size());
        morphs.normals = readVectors(in, group + "normals", morphs.vertices.size());
    }
    checkTargets(in, morphs, group);
    return morphs;
}

void checkMorphInputs(const Hdf5Reader& in, const MorphTargets& morphs, const std::vector<std::string>& inputs) {
    if (inputs.size() < morphs.count() || !std::equal(morphs.names.rbegin(), morphs.names.rend(), inputs.rbegin()))
        throw InvalidInput(in.name + ": /inputs/names: do not end with the names of /mesh/morphs/names");
}

}  // namespace penumbra
