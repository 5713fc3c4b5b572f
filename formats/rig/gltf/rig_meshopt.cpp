#include "formats/rig/gltf/rig_meshopt.h"

#include <meshoptimizer.h>

namespace penumbra {

namespace {

// Checks what the decoder only asserts.
std::string findProblem(const MeshoptView& view) {
    if (view.count == 0) return "has no elements";
    if (view.mode == "ATTRIBUTES") {
        if (view.stride == 0 || view.stride > 256 || view.stride % 4 != 0) return "has a wrong byteStride";
        if (view.filter == "OCTAHEDRAL" && view.stride != 4 && view.stride != 8) return "has a wrong byteStride";
        if (view.filter == "QUATERNION" && view.stride != 8) return "has a wrong byteStride";
        return {};
    }
    if (view.mode != "TRIANGLES" && view.mode != "INDICES") return "has the unknown mode '" + view.mode + "'";
    if (view.stride != 2 && view.stride != 4) return "has a wrong byteStride";
    if (view.mode == "TRIANGLES" && view.count % 3 != 0) return "has a count that is not a multiple of 3";
    if (view.filter != "NONE") return "has a filter on indices";
    return {};
}

// Tells whether so few bytes can hold that many elements. The codecs need at least 2 bits for 16 bytes of a vertex
// attribute, a byte for a triangle, and a byte for an index of a sequence. This runs before memory is taken, so that
// a small file cannot ask for a lot.
bool canHold(const MeshoptView& view, std::size_t bytes) {
    if (view.mode == "TRIANGLES") return view.count / 3 <= bytes;
    if (view.mode == "INDICES") return view.count <= bytes;
    return view.count / 64 <= bytes / view.stride;
}

}  // namespace

std::string decodeMeshopt(const MeshoptView& view, std::span<const unsigned char> encoded,
                          std::vector<unsigned char>& out) {
    if (std::string problem = findProblem(view); !problem.empty()) return problem;
    if (!canHold(view, encoded.size())) return "is cut short";
    out.resize(view.count * view.stride);
    int failed = 0;
    if (view.mode == "ATTRIBUTES")
        failed = meshopt_decodeVertexBuffer(out.data(), view.count, view.stride, encoded.data(), encoded.size());
    else if (view.mode == "TRIANGLES")
        failed = meshopt_decodeIndexBuffer(out.data(), view.count, view.stride, encoded.data(), encoded.size());
    else
        failed = meshopt_decodeIndexSequence(out.data(), view.count, view.stride, encoded.data(), encoded.size());
    if (failed != 0) return "cannot be decoded (damaged, or a newer version of the codec)";
    if (view.filter == "OCTAHEDRAL")
        meshopt_decodeFilterOct(out.data(), view.count, view.stride);
    else if (view.filter == "QUATERNION")
        meshopt_decodeFilterQuat(out.data(), view.count, view.stride);
    else if (view.filter == "EXPONENTIAL")
        meshopt_decodeFilterExp(out.data(), view.count, view.stride);
    else if (view.filter != "NONE")
        return "has the unknown filter '" + view.filter + "'";
    return {};
}

}  // namespace penumbra
