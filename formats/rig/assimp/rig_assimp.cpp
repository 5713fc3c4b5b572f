// Reads FBX, Collada and DirectX .x through assimp and brings them to the model frame: y up, right-handed, metres.
// assimp mirrors .x, and applies Collada's unit and up axis itself. FBX states in its metadata what it has. Morph
// targets are ignored. assimp crashes on some files, so all this runs in a child process, and numbers and indices are
// checked behind it (rig_import.cpp).
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <fstream>
#include <map>

#include "formats/common/errors.h"
#include "formats/rig/assimp/rig_assimp_look.h"
#include "formats/rig/assimp/rig_named_nodes.h"
#include "formats/rig/rig_build.h"
#include "formats/rig/rig_import.h"
#include "formats/rig/rig_normals.h"
#include "formats/rig/rig_polygon.h"

namespace penumbra {

namespace {
struct AssimpImport {
    const aiScene* scene = nullptr;
    RigSource source;
    std::vector<const aiNode*> nodes;  // ours to assimp's; null where it has none
    NamedNodes named;
    std::map<const aiTexture*, std::shared_ptr<const Texture>> textures;  // textures inside the file; meshes share them

    [[noreturn]] void fail(const std::string& problem) const { failAtFile(source.file, problem); }
};

Matrix toMatrix(const aiMatrix4x4& m) {
    return {m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4};
}

std::string textOf(const aiString& s) { return cleanText({s.data, s.length}); }

void setTransform(const AssimpImport& import, const Matrix& m, Node& node) {
    if (!allFinite(m)) import.fail("node '" + node.name + "': its transform is not finite");
    const Decomposition parts = decompose(m);
    node.translation = parts.translation;
    node.rotation = parts.rotation;
    node.scale = parts.scale;
    if (!parts.exact)
        node.matrix = {m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1};
}

void convertNodes(AssimpImport& import, const Matrix& to_model) {
    struct Entry {
        const aiNode* node;
        int parent;
    };
    if (to_model != kIdentityMatrix) {
        Node axes;
        axes.name = "axes";
        setTransform(import, to_model, axes);
        import.source.nodes.push_back(std::move(axes));
        import.nodes.push_back(nullptr);
    }
    std::vector<Entry> stack{{import.scene->mRootNode, int(import.nodes.size()) - 1}};
    while (!stack.empty()) {
        const Entry entry = stack.back();
        stack.pop_back();
        const int index = int(import.source.nodes.size());
        Node node;
        node.name = textOf(entry.node->mName);
        if (node.name.empty()) node.name = "node" + std::to_string(index);
        node.parent = entry.parent;
        setTransform(import, toMatrix(entry.node->mTransformation), node);
        import.named.emplace(node.name, index);
        import.source.nodes.push_back(std::move(node));
        import.nodes.push_back(entry.node);
        for (unsigned c = entry.node->mNumChildren; c-- > 0;) stack.push_back({entry.node->mChildren[c], index});
    }
}

// Converts the bones of a mesh to a skin. Influences are gathered vertex by vertex; every vertex gets as many as the
// busiest.
void convertBones(AssimpImport& import, const aiMesh& mesh, SourcePart& part) {
    SourceSkin skin;
    std::vector<std::vector<std::pair<std::uint32_t, double>>> influences(mesh.mNumVertices);
    for (unsigned b = 0; b < mesh.mNumBones; ++b) {
        const aiBone& bone = *mesh.mBones[b];
        const int node =
            nodeOfBone(import.source, import.named, {textOf(bone.mName), toMatrix(bone.mOffsetMatrix), part.node});
        if (node < 0) failAtNode(import.source, part.node, "its bone '" + textOf(bone.mName) + "' has no node");
        skin.nodes.push_back(node);
        skin.inverse_bind.push_back(toMatrix(bone.mOffsetMatrix));
        for (unsigned w = 0; w < bone.mNumWeights; ++w) {
            const aiVertexWeight& weight = bone.mWeights[w];
            if (weight.mVertexId >= mesh.mNumVertices)
                failAtNode(import.source, node, "weighs a vertex that does not exist");
            if (weight.mWeight != 0) influences[weight.mVertexId].push_back({b, weight.mWeight});
        }
    }
    for (const auto& list : influences) part.influences = std::max(part.influences, int(list.size()));
    for (auto& list : influences) {
        list.resize(std::size_t(part.influences));
        for (const auto& [joint, weight] : list) {
            part.joints.push_back(joint);
            part.weights.push_back(weight);
        }
    }
    part.skin = int(import.source.skins.size());
    import.source.skins.push_back(std::move(skin));
}

}  // namespace

std::filesystem::path findPicture(const std::filesystem::path& rig, std::string name) {
    std::replace(name.begin(), name.end(), '\\', '/');
    const std::filesystem::path said = rig.parent_path() / name, beside = rig.parent_path() / said.filename();
    std::error_code error;
    return std::filesystem::exists(said, error) ? said : beside;
}

namespace {

TextureWrap wrapOf(aiTextureMapMode mode) {
    if (mode == aiTextureMapMode_Mirror) return TextureWrap::kMirror;
    return mode == aiTextureMapMode_Wrap ? TextureWrap::kRepeat : TextureWrap::kClamp;
}

// Reads the diffuse texture. Returns the number of the texture coordinates that it takes.
unsigned readTexture(AssimpImport& import, const aiMaterial& material, aiTextureType type, MaterialColor& color) {
    aiString name;
    unsigned uv_set = 0;
    aiTextureMapMode modes[2] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
    material.GetTexture(type, 0, &name, nullptr, &uv_set, nullptr, nullptr, modes);
    const aiTexture* inside = import.scene->GetEmbeddedTexture(name.C_Str());
    if (inside) color.texture = import.textures[inside];
    if (!color.texture) {
        Texture texture;
        texture.name = "material '" + textOf(material.GetName()) + "': picture '" + textOf(name) + "'";
        if (!inside) {
            texture.file = findPicture(import.source.file, name.C_Str());
        } else if (inside->mHeight == 0) {  // a whole file, mWidth bytes of it
            const auto* first = reinterpret_cast<const std::byte*>(inside->pcData);
            texture.bytes.assign(first, first + inside->mWidth);
        }
        color.texture = std::make_shared<const Texture>(std::move(texture));
        if (inside) import.textures[inside] = color.texture;
    }
    color.wrap_u = wrapOf(modes[0]);
    color.wrap_v = wrapOf(modes[1]);
    // A picture stands in place of the colour, except in .x, where the two are multiplied.
    if (!isExtension(import.source.file, ".x")) color.base = Vec3{1, 1, 1};
    return uv_set;
}

// Reads the texture coordinates. assimp's point up in every format that we read. Returns why they cannot be used; ""
// where they can.
std::string readUv(const AssimpImport& import, const aiMesh& mesh, unsigned uv_set, PartColor& color) {
    const std::string where = import.source.file.string() + ": mesh '" + textOf(mesh.mName) + "': ";
    if (uv_set >= AI_MAX_NUMBER_OF_TEXTURECOORDS || mesh.mTextureCoords[uv_set] == nullptr)
        return where + "has no texture coordinates for its picture";
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
        const aiVector3D& uv = mesh.mTextureCoords[uv_set][v];
        if (!(std::abs(uv.x) < kFarthestUv && std::abs(uv.y) < kFarthestUv))
            return where + "the texture coordinates of vertex " + std::to_string(v) + " are out of range";
        color.uv.push_back({double(uv.x), 1 - double(uv.y)});
    }
    return "";
}

bool isSolid(const aiMaterial& material) {
    ai_real opacity = 1;
    material.Get(AI_MATKEY_OPACITY, opacity);
    return !(opacity < 1) && material.GetTextureCount(aiTextureType_OPACITY) == 0;
}

// Reads the opacity of a material, and that of the picture of its colour where the two are one. An opacity of 0 stays
// unread: some exporters write it for solid surfaces.
void readOpacity(const aiMaterial& material, MaterialColor& color) {
    aiString opacity_picture, color_picture;
    const bool has_picture = material.GetTexture(aiTextureType_OPACITY, 0, &opacity_picture) == AI_SUCCESS;
    material.GetTexture(aiTextureType_DIFFUSE, 0, &color_picture);
    ai_real opacity = 1;
    material.Get(AI_MATKEY_OPACITY, opacity);
    if (isSolid(material) || !(opacity > 0) || (has_picture && !(opacity_picture == color_picture))) return;
    color.alpha_mode = AlphaMode::kBlend;
    color.alpha = std::min(float(opacity), 1.0f);
}

// Reads the diffuse colour of a material. Assimp's stand-in for a material that is missing has none.
PartColor colorOf(AssimpImport& import, const aiMaterial& material, const aiMesh& mesh) {
    aiColor3D color;
    PartColor out;
    if (textOf(material.GetName()) != AI_DEFAULT_MATERIAL_NAME &&
        material.Get(AI_MATKEY_COLOR_DIFFUSE, color) == AI_SUCCESS)
        out.material.base = Vec3{color.r, color.g, color.b};
    for (const aiTextureType type : {aiTextureType_DIFFUSE, aiTextureType_BASE_COLOR}) {
        if (out.material.texture || material.GetTextureCount(type) == 0) continue;
        out.material.problem = readUv(import, mesh, readTexture(import, material, type, out.material), out);
        if (out.material.problem.empty()) continue;
        out.material.texture = nullptr;  // a picture that lies nowhere
        out.uv.clear();
    }
    if (!isExtension(import.source.file, ".fbx")) readOpacity(material, out.material);
    int two_sided = 0;
    out.material.double_sided = material.Get(AI_MATKEY_TWOSIDED, two_sided) == AI_SUCCESS && two_sided != 0;
    return out;
}

void convertMesh(AssimpImport& import, int node, const aiMesh& mesh) {
    SourcePart part;
    part.node = node;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
        const aiVector3D& p = mesh.mVertices[v];
        part.positions.push_back({p.x, p.y, p.z});
    }
    std::vector<std::uint32_t> corners;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {  // points and lines cast no shadow
        const aiFace& face = mesh.mFaces[f];
        corners.assign(face.mIndices, face.mIndices + face.mNumIndices);
        for (const std::uint32_t corner : corners)
            if (corner >= mesh.mNumVertices) failAtNode(import.source, node, "names a vertex that does not exist");
        cutPolygon(part.positions, corners, part.triangles);
    }
    if ((mesh.mPrimitiveTypes & (aiPrimitiveType_POINT | aiPrimitiveType_LINE)) != 0)
        import.source.notes.push_back({import.source.file.string(), import.source.nodes[std::size_t(node)].name,
                                       "points or lines", "they are not drawn, and cast no shadow"});
    if (part.triangles.empty()) return;
    if (mesh.mMaterialIndex < import.scene->mNumMaterials) {
        const std::string name = textOf(import.scene->mMaterials[mesh.mMaterialIndex]->GetName());
        if (!name.empty()) part.material = name;
        part.color = colorOf(import, *import.scene->mMaterials[mesh.mMaterialIndex], mesh);
        part.look = readAssimpLook(*import.scene->mMaterials[mesh.mMaterialIndex]);
        if (part.color.material.alpha_mode == AlphaMode::kOpaque &&
            !isSolid(*import.scene->mMaterials[mesh.mMaterialIndex]))
            part.look.notes.push_back("transparency is not read: the surface is solid");
    }
    if (mesh.mNormals != nullptr) {
        std::vector<Vec3> normals;
        for (unsigned v = 0; v < mesh.mNumVertices; ++v)
            normals.push_back({mesh.mNormals[v].x, mesh.mNormals[v].y, mesh.mNormals[v].z});
        takeNormals(std::move(normals), import.source, part);
    }
    if (mesh.mNumBones > 0) convertBones(import, mesh, part);
    import.source.parts.push_back(std::move(part));
}

void convertMeshes(AssimpImport& import) {
    std::size_t vertices = 0;
    for (std::size_t n = 0; n < import.nodes.size(); ++n)
        for (unsigned m = 0; import.nodes[n] != nullptr && m < import.nodes[n]->mNumMeshes; ++m) {
            const aiMesh& mesh = *import.scene->mMeshes[import.nodes[n]->mMeshes[m]];
            vertices += mesh.mNumVertices;
            if (vertices > kMaxSourceVertices)
                throw Unsupported(import.source.file.string() + ": has too many vertices");
            convertMesh(import, int(n), mesh);
        }
}

void appendValue(const aiVector3D& v, std::vector<float>& out) { out.insert(out.end(), {v.x, v.y, v.z}); }
void appendValue(const aiQuaternion& q, std::vector<float>& out) { out.insert(out.end(), {q.x, q.y, q.z, q.w}); }

template <class Key>
void convertKeys(std::span<Key> keys, double seconds_a_tick, int node, Channel::Path path, Clip& clip) {
    if (keys.empty()) return;
    Channel channel;
    channel.node = node;
    channel.path = path;
    for (const Key& key : keys) {
        const double time = key.mTime * seconds_a_tick;
        if (!channel.times.empty() && time == channel.times.back()) continue;
        channel.times.push_back(time);
        appendValue(key.mValue, channel.values);
    }
    clip.channels.push_back(std::move(channel));
}

// DirectX counts 4800 ticks a second where the file does not tell (AnimTicksPerSecond); assimp's own default is 25.
double secondsPerTick(const AssimpImport& import, const aiAnimation& animation) {
    if (animation.mTicksPerSecond > 0) return 1 / animation.mTicksPerSecond;
    return isExtension(import.source.file, ".x") ? 1.0 / 4800 : 1.0 / 25;
}

// Sets the clip's duration, and moves its first key to 0 s where the clip starts before that.
void setDuration(RigSource& source, Clip& clip) {
    double first = 0;
    for (const Channel& channel : clip.channels) first = std::min(first, channel.times.front());
    if (first < 0)
        source.notes.push_back(
            {source.file.string(), "", "clip '" + clip.name + "'", "begins before 0 s, its keys are moved there"});
    for (Channel& channel : clip.channels) {
        for (double& t : channel.times) t -= first;
        clip.duration = std::max(clip.duration, channel.times.back());
    }
}

void convertClips(AssimpImport& import) {
    for (unsigned a = 0; a < import.scene->mNumAnimations; ++a) {
        const aiAnimation& animation = *import.scene->mAnimations[a];
        Clip clip;
        clip.name = animation.mName.length == 0 ? "clip" + std::to_string(a) : textOf(animation.mName);
        const double tick = secondsPerTick(import, animation);
        for (unsigned c = 0; c < animation.mNumChannels; ++c) {
            const aiNodeAnim& from = *animation.mChannels[c];
            const int node = nodeOfChannel(import.source, import.named, textOf(from.mNodeName));
            if (node < 0) continue;  // a .x file may animate frames that it does not have
            Node& target = import.source.nodes[std::size_t(node)];
            target.matrix.reset();
            convertKeys(std::span(from.mPositionKeys, from.mNumPositionKeys), tick, node, Channel::Path::kTranslation,
                        clip);
            convertKeys(std::span(from.mRotationKeys, from.mNumRotationKeys), tick, node, Channel::Path::kRotation,
                        clip);
            convertKeys(std::span(from.mScalingKeys, from.mNumScalingKeys), tick, node, Channel::Path::kScale, clip);
        }
        if (clip.channels.empty()) {
            import.source.notes.push_back(
                {import.source.file.string(), "", "clip '" + clip.name + "'", "has no keys, left out"});
            continue;
        }
        setDuration(import.source, clip);
        import.source.clips.push_back(std::move(clip));
    }
}

// Returns the transform to the model frame. FBX names its axes by index and sign, and its unit in centimetres. Row r
// of the result is model axis x (its "coord" axis), y (up), z (front).
Matrix fbxToModel(const aiScene& scene) {
    if (scene.mMetaData == nullptr) return kIdentityMatrix;
    double unit = 100;
    float unit_float = 0;
    if (!scene.mMetaData->Get("UnitScaleFactor", unit) && scene.mMetaData->Get("UnitScaleFactor", unit_float))
        unit = unit_float;
    const double scale = std::isfinite(unit) && unit > 0 ? unit / 100 : 1;
    Matrix m{};
    std::array<bool, 3> used{};
    std::size_t row = 0;
    for (const char* axis : {"CoordAxis", "UpAxis", "FrontAxis"}) {
        std::int32_t index = row == 0 ? 0 : int(row), sign = 1;
        scene.mMetaData->Get(axis, index);
        scene.mMetaData->Get(std::string(axis) + "Sign", sign);
        if (index < 0 || index > 2 || used[std::size_t(index)])
            return composeTransform({}, {0, 0, 0, 1}, {scale, scale, scale});
        used[std::size_t(index)] = true;
        m[4 * row++ + std::size_t(index)] = sign < 0 ? -scale : scale;
    }
    return m;
}

constexpr unsigned kImportSteps = aiProcess_TransformUVCoords;

const aiScene* readScene(Assimp::Importer& importer, const std::filesystem::path& path) {
    if (isExtension(path, ".x")) {
        std::ifstream in(path, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
        const std::string read = withoutEmptyWeights(text);
        if (read.size() < text.size()) return importer.ReadFileFromMemory(read.data(), read.size(), kImportSteps, "x");
    }
    return importer.ReadFile(path.string(), kImportSteps);
}

RigSource convertScene(Assimp::Importer& importer, const aiScene* scene, const std::filesystem::path& path) {
    AssimpImport import;
    import.source.file = path;
    import.scene = scene;
    if (scene == nullptr || scene->mRootNode == nullptr)
        import.fail("cannot be read: " +
                    std::string(importer.GetErrorString()).substr(0, 160));  // the error may quote the file
    const bool is_fbx = isExtension(path, ".fbx");
    const Matrix to_model = is_fbx ? fbxToModel(*scene) : kIdentityMatrix;
    // The root of an FBX file has no transform. Since 5.3 assimp gives it one by the same axes and unit, in
    // centimetres.
    if (is_fbx) scene->mRootNode->mTransformation = aiMatrix4x4();
    convertNodes(import, to_model);
    convertMeshes(import);
    convertClips(import);
    return std::move(import.source);
}

void setOptions(Assimp::Importer& importer) {
    importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);  // no stand-ins for files without a mesh
}

}  // namespace

RigSource importWithAssimp(const std::filesystem::path& path) {
    Assimp::Importer importer;
    setOptions(importer);
    return convertScene(importer, readScene(importer, path), path);
}

RigSource importTextWithAssimp(const std::filesystem::path& path, const std::string& text) {
    Assimp::Importer importer;
    setOptions(importer);
    const std::string extension = path.extension().string().substr(1);
    return convertScene(importer,
                        importer.ReadFileFromMemory(text.data(), text.size(), kImportSteps, extension.c_str()), path);
}

}  // namespace penumbra
