#pragma once
// Scans the names, properties and arrays of an FBX file, which is enough to say beforehand what a reader of it will get
// wrong (fbx_faults.h). Nothing is evaluated.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "formats/rig/fbx/fbx_tree.h"

namespace penumbra {

struct FbxModel {
    std::string name, kind;  // kind: "Mesh", "LimbNode", "Null", ...
    int parent = -1;         // index; -1: the scene
    // 0: rotation, then scales of parent and node (RrSs); 1: the parent's whole transform (RSrs); 2: without the
    // parent's scale, as Maya's segment scale compensation (Rrs)
    int inherit = 0;
    int rotation_order = 0;  // 6: spherical
    std::array<double, 3> scale{1, 1, 1};
    std::array<double, 9> geometric{0, 0, 0, 0, 0, 0, 1, 1, 1};  // translation, rotation, scale of its mesh alone
    bool pivots = false;                                         // a pivot or an offset is not 0
    bool hidden = false;                                         // itself or by what it hangs on
};

struct FbxCluster {
    int model = -1;  // the bone
    std::vector<double> vertices, weights;
};

struct FbxSkin {
    std::string type;  // "", "Rigid", "Linear", "DualQuaternion", "Blend"
    std::vector<FbxCluster> clusters;
};

struct FbxShapes {
    std::string name;                  // name of the channel of blend shapes
    int shapes = 0;                    // more than 1: in-betweens
    double percent = 0;                // how far it is at rest
    std::vector<double> full_weights;  // one for each shape; some exporters write one for each vertex
};

struct FbxGeometry {
    std::string name;
    std::uint64_t vertices = 0;
    std::vector<int> models;  // models that draw it
    std::vector<FbxSkin> skins;
    std::vector<FbxShapes> shapes;
};

struct FbxCurve {
    std::vector<double> times;  // seconds
    std::vector<double> values;
    std::vector<int> flags;          // [keys] 2: constant, 4: linear, 8: cubic
    char before = 'C', after = 'C';  // extrapolation; C: constant
    bool varies() const;             // true if its values are not all the same
    double first() const { return times.front(); }
    double last() const { return times.back(); }
};

// The curves of one property of one model, or of one channel of shapes.
struct FbxTrack {
    bool by_channel = false;                        // true if its layer adds rotations angle by angle
    int take = -1, layer = -1;                      // layer: index in the take
    int model = -1;                                 // -1: of something else
    int shapes = -1;                                // index of its geometry where it is of a channel of shapes
    std::string name;                               // name of the model or channel
    std::string property;                           // "Lcl Rotation", "DeformPercent", ...
    std::array<std::optional<FbxCurve>, 3> curves;  // x, y, z; the first alone where it has one number
};

struct FbxTake {
    std::string name;
    std::optional<double> start, stop;  // seconds, as the file says
};

struct FbxTexture {
    std::string name, file;  // the picture's file as the file names it
};

struct FbxScan {
    std::filesystem::path file;
    int version = 0;
    int time_mode = 0;
    double seconds_a_tick = 0;
    std::vector<FbxModel> models;
    std::vector<FbxGeometry> geometries;
    std::vector<FbxTexture> textures;
    std::vector<FbxTake> takes;
    std::vector<FbxTrack> tracks;
    bool audio = false;
    bool maya = false;         // written by Maya
    bool other_ticks = false;  // counts times as FBX 2020 does
    bool odd_names = false;    // a name is not UTF-8
    bool old_clips = false;    // clips of FBX 6, whose curves are not looked into
};

// Reads a file. Throws IoError, and InvalidInput where it is no FBX file, damaged or cut short.
FbxScan scanFbx(const std::filesystem::path& path);
FbxScan scanOf(const FbxTree& tree, const std::filesystem::path& path);

}  // namespace penumbra
