#pragma once
// Turns a verified FlatBuffer into a view in which everything is checked. asset_file.cpp and the writer use it.
#include <flatbuffers/flatbuffers.h>

#include <functional>
#include <string>

#include "formats/asset/asset_file.h"

namespace penumbra::fbs {
struct Asset;
struct Mesh;
struct Animation;
struct Cluster;
struct Model;
struct Numbers;
}  // namespace penumbra::fbs

namespace penumbra {

// Throws InvalidInput "FILE: FIELD ...".
AssetView viewOfAsset(const fbs::Asset& asset, const std::string& file);

// Readers of materials and lights. `at` names the field in errors; for slots it names the file.
struct Field;
std::vector<MaterialView> materialsOf(const fbs::Asset& asset, const Field& at);
std::vector<LightView> lightsOf(const fbs::Asset& asset, const Field& at);
// Without the field every slot has the first material. This function reads the mesh and the materials of `asset`.
std::vector<std::uint16_t> slotMaterialsOf(const fbs::Asset& stored, const Field& at, const AssetView& asset);

// Returns rows of numbers, which may be at most as coarse as `coarsest`.
NumbersView numbersOf(const fbs::Numbers* stored, const Field& at, std::uint64_t rows, std::uint64_t row_length,
                      AssetPrecision coarsest);

// Two-sided and deforming meshes and inputs, in asset_checks_deform.cpp. The mesh is checked except for these. `at` is
// the mesh or the animation itself; for the model it is the file.
void setTwoSided(const fbs::Mesh& stored, const Field& at, MeshView& mesh);
void setInputs(const fbs::Animation& stored, const Field& at, AnimationView& animation);
// Reads the mesh, the model and the frames of `asset`.
void setPlayback(const fbs::Animation& stored, const Field& at, const AssetView& asset, PlaybackView& playback);
// `model` has its kind of features already. Reads the mesh and the animation of `asset`.
void setDeforming(const fbs::Model& stored, const Field& file, const AssetView& asset, ModelView& model);

// The pictures on the mesh, in asset_checks_surface.cpp. Reads the mesh and the materials of `view`. `file` is the
// file.
std::optional<SurfaceView> surfaceOfAsset(const fbs::Asset& asset, const Field& file, const AssetView& view);

// Checks that the mesh and the model have what the materials need of them.
void checkLooks(const AssetView& asset, const Field& file);

// Composed models, in asset_checks_compose.cpp. Reads the mesh and the animation of `asset`, and the clusters of
// `model`. `read_cluster` reads a cluster as those of the model are read.
using ReadCluster = std::function<ClusterView(const fbs::Cluster& stored, const Field& at)>;
void setComposition(const fbs::Model& stored, const Field& at, const AssetView& asset, const ReadCluster& read_cluster,
                    ModelView& model);
// Reads clusters that must have the joints and vertices of the model's, one for one; or none.
using StoredClusters = flatbuffers::Vector<flatbuffers::Offset<fbs::Cluster>>;
std::vector<ClusterView> sameClustersOf(const StoredClusters* stored, const Field& at, const ModelView& model,
                                        const ReadCluster& read_cluster);
// Light that bounces, in asset_checks_indirect.cpp. `read_cluster` reads rows of kIndirectStride.
void setIndirect(const fbs::Model& stored, const Field& at, const ReadCluster& read_cluster, ModelView& model);
// The blockers of the file, in asset_checks_compose.cpp. `at` is the file.
BlockersView blockersOf(const fbs::Asset& stored, const Field& at, std::size_t joints);
// Morph targets, in asset_checks_morph.cpp. Reads all but the materials of `asset`. `file` is the file.
void setMorphs(const fbs::Asset& stored, const Field& file, AssetView& asset);
// Linear models of transfer, in asset_checks_transfer.cpp. Reads the mesh and the animation of `asset`, and
// sets the transfer and what stands in for the model. `at` is the file.
void setTransfer(const fbs::Asset& stored, const Field& at, AssetView& asset);

}  // namespace penumbra
