// A reader accepts one version of its format and names every field that a file lacks. So a file of an earlier build,
// which lacks a field that a later one added, is refused by the field's name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <set>

#include "formats/common/errors.h"
#include "formats/stage/hdf5_handle.h"
#include "tests/formats/stage_samples.h"
#include "tests/synthetic_cloth.h"
#include "tests/synthetic_composition.h"
#include "tests/synthetic_indirect.h"

namespace penumbra::test_missing_fields {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

struct Sample {
    const char* format;
    std::function<void(const fs::path&)> write;
    std::function<void(const fs::path&)> read;
};

template <class Write>
Sample visibilityFile(const Write& change) {
    return {"penumbra.visibility",
            [change](const fs::path& path) {
                VisibilityHeader header = samples::sheetHeader(1, 2);
                change(header);
                samples::writeVisibility(path, header, Precision::kFloat32);
            },
            [](const fs::path& path) { (void)VisibilityReader(path).readFrame(1); }};
}

template <class Change>
Sample modelFile(const Model& model, const Change& change) {
    return {"penumbra.model",
            [model, change](const fs::path& path) {
                Model changed = model;
                change(changed);
                writeModel(path, changed);
            },
            [](const fs::path& path) { (void)readModel(path); }};
}

template <class Change>
Sample brdfFile(const Change& change) {
    return {"penumbra.brdf",
            [change](const fs::path& path) {
                BrdfFile brdf = samples::sampleBrdf();
                change(brdf);
                writeBrdf(path, brdf);
            },
            [](const fs::path& path) { (void)readBrdf(path); }};
}

template <class Change>
Sample fieldsFile(const Change& change) {
    return {"penumbra.fields",
            [change](const fs::path& path) {
                FieldFile fields = samples::fieldFile();
                change(fields);
                writeFields(path, fields);
            },
            [](const fs::path& path) { (void)readFieldShard(path); }};
}

Sample posesFile(const PoseFile& poses) {
    return {"penumbra.poses", [poses](const fs::path& path) { writePoseFile(path, poses); },
            [](const fs::path& path) { (void)readPoseFile(path); }};
}

Sample transferFile(TransferModelKind kind) {
    return {"penumbra.transfer", [kind](const fs::path& path) { writeTransfer(path, samples::transferModel(kind)); },
            [](const fs::path& path) { (void)readTransfer(path); }};
}

void addBounces(VisibilityHeader& header) {
    header.quantity = kDiffuseTransfer;
    header.bounces = 1;
    header.colors.albedo.assign(header.mesh.vertexCount(), {0.5f, 0.25f, 0});
    header.colors.transmission.assign(header.mesh.vertexCount(), {0.5f, 0, 0.75f});
}

void addSteps(BrdfFile& brdf) {
    brdf.lobes = {lobeOf(parseBrdf("ggx:alpha=0.2"))};
    brdf.steps = BrdfSteps{0, {0.1, 0.4}, brdf.slices, 0.01};
    brdf.steps->slices.insert(brdf.steps->slices.end(), brdf.slices.begin(), brdf.slices.end());
}

// Together they have every field that there is.
std::vector<Sample> allSamples() {
    return {
        visibilityFile([](VisibilityHeader&) {}),
        visibilityFile([](VisibilityHeader& header) { header = samples::localHeader(1, 2); }),
        visibilityFile(addBounces),
        modelFile(synthetic::clothModel({.features = FeatureKind::kDihedrals}), [](Model&) {}),
        modelFile(synthetic::composedTube({.joints = 5}),
                  [](Model& model) {
                      synthetic::addIndirect(model);
                      synthetic::addNearParts(model, 2);
                  }),
        brdfFile([](BrdfFile& brdf) {
            brdf.operators = samples::sampleOperators();
            brdf.membrane = Membrane();
        }),
        brdfFile(addSteps),
        fieldsFile([](FieldFile& fields) {
            fields.shard = FieldShard{0, fields.fields.parts.size()};
        }),
        fieldsFile([](FieldFile& fields) { fields.motion.follows = "ball"; }),
        posesFile(samples::poseFile()),
        posesFile(samples::mixedPoseFile()),
        transferFile(TransferModelKind::kLinear),
        transferFile(TransferModelKind::kPca),
        {"penumbra.lobes", [](const fs::path& path) { writeLobes(path, samples::lobeModel()); },
         [](const fs::path& path) { (void)readLobes(path); }},
        {"penumbra.light",
         [](const fs::path& path) {
             LightFile light = samples::sampleLight();
             light.lobes = samples::sampleLobes();
             light.window = {1, 0.5};
             light.factor = "hand-over";
             light.suns = {{{0.6, 0, 0.8}, {5, 4, 3}, 0.01}};
             light.picture = {4, 2, std::vector<float>(24, 0.25f)};
             writeLight(path, light);
         },
         [](const fs::path& path) { (void)readLight(path); }},
        {"penumbra.blockers", [](const fs::path& path) { writeBlockers(path, samples::blockerFile()); },
         [](const fs::path& path) { (void)readBlockers(path); }},
    };
}

// Lists the fields that a file may lack by formats/README.md. The error attributes of materials are named by whoever
// measured them.
bool mayBeMissing(const std::string& object, const std::string& field) {
    static const std::set<std::string> fields = {
        "two_sided",    "ground_y",      "distance",    "holdout_error",     "holdout_share",      "/mesh/rest_normals",
        "/frames/pose", "/light/window", "/light/suns", "/visibility/local", "/mesh/transmission", "/light/picture"};
    return object == "/error" || fields.contains(field);
}

struct Field {
    std::string object, attribute;  // attribute "": the dataset itself
};

herr_t collectLink(hid_t, const char* name, const H5L_info_t*, void* names) {
    static_cast<std::vector<std::string>*>(names)->push_back("/" + std::string(name));
    return 0;
}

herr_t collectAttribute(hid_t, const char* name, const H5A_info_t*, void* names) {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
    return 0;
}

std::vector<Field> fieldsOf(const fs::path& path) {
    const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, "test");
    std::vector<std::string> objects = {"/"};
    checkHdf5(H5Lvisit(file, H5_INDEX_NAME, H5_ITER_INC, collectLink, &objects), "test");
    std::vector<Field> fields;
    for (const std::string& object : objects) {
        const Hdf5Handle opened(H5Oopen(file, object.c_str(), H5P_DEFAULT), H5Oclose, "test");
        if (H5Iget_type(opened) == H5I_DATASET) fields.push_back({object, ""});
        std::vector<std::string> attributes;
        checkHdf5(H5Aiterate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, collectAttribute, &attributes), "test");
        for (const std::string& attribute : attributes) fields.push_back({object, attribute});
    }
    return fields;
}

void remove(const fs::path& path, const Field& field) {
    const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "test");
    if (field.attribute.empty())
        checkHdf5(H5Ldelete(file, field.object.c_str(), H5P_DEFAULT), field.object);
    else
        checkHdf5(H5Adelete_by_name(file, field.object.c_str(), field.attribute.c_str(), H5P_DEFAULT), field.attribute);
}

std::string refusalOf(const Sample& sample, const fs::path& path) {
    try {
        sample.read(path);
    } catch (const std::exception& error) {
        return error.what();
    }
    return "accepted";
}

TEST(MissingFields, AreRefusedByTheirNames) {
    const samples::Folder folder("missing", samples::memoryFolder());
    const fs::path whole = folder.path / "whole.h5", lacking = folder.path / "lacking.h5";
    std::set<std::string> formats;
    for (const Sample& sample : allSamples()) {
        formats.insert(sample.format);
        sample.write(whole);
        ASSERT_EQ(refusalOf(sample, whole), "accepted") << sample.format;
        std::size_t removed = 0;
        for (const Field& field : fieldsOf(whole)) {
            const std::string name = field.attribute.empty() ? field.object : field.attribute;
            if (mayBeMissing(field.object, name)) continue;
            fs::copy_file(whole, lacking, fs::copy_options::overwrite_existing);
            remove(lacking, field);
            const std::string said = refusalOf(sample, lacking);
            EXPECT_THAT(said, HasSubstr("lacking.h5: ")) << sample.format << " without " << field.object << " " << name;
            EXPECT_THAT(said, HasSubstr(name)) << sample.format << " without that of " << field.object;
            ++removed;
        }
        EXPECT_GT(removed, 10u) << sample.format;
    }
    EXPECT_EQ(formats.size(), 9u);
}

TEST(MissingFields, OtherVersionsAreRefusedByTheirNumbers) {
    const samples::Folder folder("versions", samples::memoryFolder());
    const fs::path path = folder.path / "x.h5";
    for (const Sample& sample : allSamples())
        for (const int version : {2, 5}) {
            sample.write(path);
            remove(path, {"/", "format_version"});
            {
                const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "test");
                writeIntegerAttribute(file, "/", "format_version", version);
            }
            EXPECT_THROW(sample.read(path), Unsupported) << sample.format;
            EXPECT_EQ(refusalOf(sample, path), path.string() + ": is version " + std::to_string(version) + " of " +
                                                   sample.format +
                                                   ", and this build reads version 1 alone: make the file again with "
                                                   "this build");
        }
}

}  // namespace
}  // namespace penumbra::test_missing_fields
