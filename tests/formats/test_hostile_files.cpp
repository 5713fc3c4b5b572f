// Files as an enemy, a full disk or a bad cable would leave them: cut short, or with bytes changed. A reader throws
// InvalidInput, IoError or Unsupported and names the file. Nothing else may happen, least of all a crash.
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <random>

#include "formats/common/errors.h"
#include "formats/common/write_file.h"
#include "formats/stage/hdf5_handle.h"
#include "formats/stage/visibility_header.h"
#include "tests/formats/stage_samples.h"
#include "tests/synthetic_cloth.h"

namespace penumbra::test_hostile_files {
namespace {

void readAllOfVisibility(const std::filesystem::path& path) {
    const VisibilityReader reader(path);
    for (std::size_t f = 0; f < reader.header().frames.frameCount(); ++f) (void)reader.readFrame(f);
    if (!reader.header().local) return;
    std::vector<float> local(reader.header().frames.frameCount() * reader.header().local->coefficientCount());
    reader.readLocalVertices(0, 1, local);
}

struct Victim {
    const char* name;
    std::function<void(const std::filesystem::path&)> write, read;
    double structure = 0.5;  // share of the file under HDF5's checksums, at least
};

const std::vector<Victim>& victims() {
    static const std::vector<Victim> all = {
        {"visibility f32",
         [](const auto& path) { samples::writeVisibility(path, samples::visibilityHeader(3, 2), Precision::kFloat32); },
         readAllOfVisibility},
        {"visibility f16",
         [](const auto& path) { samples::writeVisibility(path, samples::visibilityHeader(3, 2), Precision::kFloat16); },
         readAllOfVisibility},
        {"visibility with local moments",
         [](const auto& path) { samples::writeVisibility(path, samples::localHeader(3, 2), Precision::kFloat16); },
         readAllOfVisibility},
        {"sheet",
         [](const auto& path) { samples::writeVisibility(path, samples::sheetHeader(3, 2), Precision::kFloat32); },
         readAllOfVisibility},
        {"model", [](const auto& path) { writeModel(path, samples::model(FeatureKind::kRelativeBones)); },
         [](const auto& path) { (void)readModel(path); }},
        {"cloth model", [](const auto& path) { writeModel(path, synthetic::clothModel()); },
         [](const auto& path) { (void)readModel(path); }},
        {"cloth model of angles",
         [](const auto& path) { writeModel(path, synthetic::clothModel({.features = FeatureKind::kDihedrals})); },
         [](const auto& path) { (void)readModel(path); }},
        {"poses", [](const auto& path) { writePoseFile(path, samples::poseFile()); },
         [](const auto& path) { (void)readPoseFile(path); }},
        {"fields", [](const auto& path) { writeFields(path, samples::fieldFile()); },
         [](const auto& path) { (void)readFields(path); }},
        {"blockers", [](const auto& path) { writeBlockers(path, samples::blockerFile()); },
         [](const auto& path) { (void)readBlockers(path); }},
        {"mixed poses", [](const auto& path) { writePoseFile(path, samples::mixedPoseFile()); },
         [](const auto& path) { (void)readPoseFile(path); }},
        {"transfer", [](const auto& path) { writeTransfer(path, samples::transferModel(TransferModelKind::kPca)); },
         [](const auto& path) { (void)readTransfer(path); }},
        {"points",
         [](const auto& path) { samples::writeVisibility(path, samples::pointsHeader(2), Precision::kFloat32); },
         [](const auto& path) { (void)VisibilityReader(path).readFrame(1); }},
        {"lobes", [](const auto& path) { writeLobes(path, samples::lobeModel()); },
         [](const auto& path) { (void)readLobes(path); }},
        {"brdf",
         [](const auto& path) {
             BrdfFile brdf = samples::sampleBrdf();
             brdf.operators = samples::sampleOperators();
             writeBrdf(path, brdf);
         },
         [](const auto& path) { (void)readBrdf(path); }},
        {"light",
         [](const auto& path) {
             LightFile light = samples::sampleLight();
             light.lobes = samples::sampleLobes();
             light.window = {1, 0.5};
             writeLight(path, light);
         },
         [](const auto& path) { (void)readLight(path); }, 0.4},
    };
    return all;
}

// Returns true when the reader took the file, and false when it refused it properly.
bool accepted(const Victim& victim, const std::filesystem::path& path) {
    try {
        victim.read(path);
        return true;
    } catch (const InvalidInput& error) {
        EXPECT_NE(std::string(error.what()).find(path.filename().string()), std::string::npos) << error.what();
    } catch (const IoError&) {
    } catch (const Unsupported&) {
    } catch (const std::exception& error) {
        ADD_FAILURE() << victim.name << ": " << error.what();
    }
    return false;
}

TEST(HostileFiles, EveryTruncationIsRefused) {
    const samples::Folder folder("truncated");
    for (const Victim& victim : victims()) {
        victim.write(folder.path / "whole");
        const std::string whole = samples::bytesOf(folder.path / "whole");
        ASSERT_TRUE(accepted(victim, folder.path / "whole"));
        // The lengths are every one near both ends, and every 97th between.
        for (std::size_t n = 0; n < whole.size(); n += (n < 256 || n + 256 > whole.size()) ? 1 : 97) {
            samples::writeBytes(folder.path / "cut", whole.substr(0, n));
            EXPECT_FALSE(accepted(victim, folder.path / "cut")) << victim.name << ", first " << n << " bytes";
        }
    }
}

TEST(HostileFiles, ChangedBytesNeverCrash) {
    const samples::Folder folder("changed");
    std::mt19937 random(20240607);
    for (const Victim& victim : victims()) {
        victim.write(folder.path / "whole");
        const std::string whole = samples::bytesOf(folder.path / "whole");
        int refused = 0;
        constexpr int kTrials = 500;
        for (int trial = 0; trial < kTrials; ++trial) {
            std::string changed = whole;
            for (int flips = 1 + int(random() % 3); flips > 0; --flips)
                changed[random() % changed.size()] ^= char(1u << random() % 8);
            samples::writeBytes(folder.path / "changed", changed);
            refused += !accepted(victim, folder.path / "changed");
        }
        // Bits of stored numbers may change unnoticed. HDF5's own structures, about half of these small files, have
        // checksums.
        EXPECT_GT(refused, kTrials * victim.structure) << victim.name;
    }
}

// Edits one object of a good file by HDF5 itself, and expects a refusal that names it.
void expectRefused(const std::function<void(hid_t)>& edit, const std::string& named,
                   const VisibilityHeader& good = samples::visibilityHeader(3, 2)) {
    const samples::Folder folder("edited");
    const std::filesystem::path path = folder.path / "x.vis.h5";
    samples::writeVisibility(path, good, Precision::kFloat32);
    {
        const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT), H5Fclose, "test");
        edit(file);
    }
    try {
        readAllOfVisibility(path);
        ADD_FAILURE() << "accepted, though " << named << " is wrong";
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find(named), std::string::npos) << error.what();
    }
}

void removeLink(hid_t file, const char* path) { checkHdf5(H5Ldelete(file, path, H5P_DEFAULT), path); }

TEST(HostileFiles, MissingPartsAreNamed) {
    for (const char* path :
         {"/mesh/triangles", "/mesh/rest_positions", "/mesh/source_vertex", "/skin/joint_names", "/skin/weights",
          "/frames/positions", "/frames/bones", "/frames/time", "/clips/names", "/visibility/coefficients"})
        expectRefused([&](hid_t file) { removeLink(file, path); }, path);
    for (const char* name : {"format", "format_version", "sh_convention", "sh_order", "quantity", "frame", "rays",
                             "seed", "bounces", "provenance"})
        expectRefused([&](hid_t file) { checkHdf5(H5Adelete(file, name), name); }, name);
}

TEST(HostileFiles, OtherFilesAreOutOfReach) {
    const char* path = "/visibility/coefficients";
    expectRefused(
        [&](hid_t file) {
            removeLink(file, path);
            checkHdf5(H5Lcreate_external("/etc/passwd", "/x", file, path, H5P_DEFAULT, H5P_DEFAULT), path);
        },
        path);
    expectRefused(
        [&](hid_t file) {
            removeLink(file, path);
            checkHdf5(H5Lcreate_soft("/frames/normals", file, path, H5P_DEFAULT, H5P_DEFAULT), path);
        },
        path);
    expectRefused(
        [&](hid_t file) {
            removeLink(file, path);
            const hsize_t shape[] = {2, 8, 9};
            const Hdf5Handle space(H5Screate_simple(3, shape, nullptr), H5Sclose, path);
            const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, path);
            checkHdf5(H5Pset_external(creation, "/etc/passwd", 0, 2 * 8 * 9 * 4), path);
            const Hdf5Handle made(H5Dcreate2(file, path, H5T_IEEE_F32LE, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                                  H5Dclose, path);
        },
        path);
}

// 2^50 vertices in a file of some kilobytes are refused before anything is allocated, and so is what nobody wrote, in
// chunks or in one piece.
TEST(HostileFiles, SizesAreHeldToTheFilesLength) {
    for (const hsize_t vertices : {hsize_t(1) << 50, hsize_t(8)})
        expectRefused(
            [&](hid_t file) {
                removeLink(file, "/mesh/rest_positions");
                (void)createDataset(file, "/mesh/rest_positions", H5T_IEEE_F32LE, {vertices, 3}, {8, 3});
            },
            "/mesh/rest_positions");
    expectRefused(
        [&](hid_t file) {
            removeLink(file, "/mesh/rest_positions");
            const hsize_t shape[] = {8, 3};
            const Hdf5Handle space(H5Screate_simple(2, shape, nullptr), H5Sclose, "test");
            const Hdf5Handle made(
                H5Dcreate2(file, "/mesh/rest_positions", H5T_IEEE_F32LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                H5Dclose, "test");
        },
        "/mesh/rest_positions: was never written");
}

TEST(HostileFiles, WrongTypesAndShapesAreNamed) {
    const auto replaced = [](const char* path, hid_t type, std::vector<hsize_t> shape) {
        return [=](hid_t file) {
            removeLink(file, path);
            std::size_t count = 1;
            for (hsize_t n : shape) count *= n;
            writeIntegers(file, path, std::vector<std::int64_t>(count, 0), shape, type);
        };
    };
    expectRefused(replaced("/frames/normals", H5T_STD_I32LE, {2, 8, 3}), "/frames/normals");
    expectRefused(replaced("/frames/time", H5T_STD_I32LE, {2}), "/frames/time");
    expectRefused(replaced("/mesh/triangles", H5T_STD_U32LE, {6, 4}), "/mesh/triangles");
    expectRefused(replaced("/skin/parents", H5T_STD_I32LE, {3}), "/skin/parents");
    expectRefused(replaced("/clips/names", H5T_STD_I32LE, {2}), "/clips/names");
    expectRefused(replaced("/mesh", H5T_STD_I32LE, {2}), "/mesh");
}

// Refuses fronts and backs that do not pair, and edges and inputs that do not fit the pose.
TEST(HostileFiles, SheetsAreChecked) {
    const VisibilityHeader sheet = samples::sheetHeader(3, 2);
    const auto with = [&](const std::function<void(VisibilityHeader&)>& spoil) {
        VisibilityHeader header = sheet;
        spoil(header);
        return header;
    };
    const auto asItIs = [](hid_t) {};
    expectRefused(asItIs, "/mesh/triangles",
                  with([](auto& h) { std::swap(h.mesh.triangles[0], h.mesh.triangles[1]); }));
    expectRefused(asItIs, "/mesh/triangles", with([](auto& h) { h.mesh.triangles[0][0] = 9; }));
    expectRefused(asItIs, "two_sided", with([](auto& h) { h.mesh.triangles.pop_back(); }));
    expectRefused(asItIs, "/mesh/rest_positions", with([](auto& h) { h.mesh.rest_positions[9].x += 1; }));
    expectRefused(asItIs, "/mesh/source_vertex", with([](auto& h) { h.mesh.source_vertex[0] = 8; }));
    expectRefused(asItIs, "/mesh/edges", with([](auto& h) { std::swap(h.edges[0], h.edges[1]); }));
    expectRefused(asItIs, "/mesh/edges", with([](auto& h) { h.edges[0][3] = 8; }));
    expectRefused(asItIs, "/frames/pose", with([](auto& h) { h.edges.pop_back(); }));
    expectRefused(asItIs, "/inputs/names", with([](auto& h) { h.input_names[1] = h.input_names[0]; }));
    expectRefused([](hid_t file) { removeLink(file, "/inputs/names"); }, "/inputs/names", sheet);
    expectRefused([](hid_t file) { removeLink(file, "/mesh/edges"); }, "/frames/pose", sheet);
}

TEST(HostileFiles, LocalMomentsAreChecked) {
    const auto withAttribute = [](const char* name, std::int64_t value) {
        return [=](hid_t file) {
            checkHdf5(H5Adelete_by_name(file, kLocal, name, H5P_DEFAULT), name);
            writeIntegerAttribute(file, kLocal, name, value);
        };
    };
    const VisibilityHeader good = samples::localHeader(3, 2);
    for (const int steps : {-1, 0, 9, 255}) expectRefused(withAttribute("steps", steps), "steps", good);
    for (const int order : {-5, 0, 4, 7}) expectRefused(withAttribute("order", order), "order", good);
    expectRefused(withAttribute("order", 5), "/visibility/local", good);  // a wrong shape
    for (const char* name : {"steps", "order"})
        expectRefused([&](hid_t file) { checkHdf5(H5Adelete_by_name(file, kLocal, name, H5P_DEFAULT), name); }, name,
                      good);
    const std::vector<float> zeros(2 * 8 * 36);
    const auto reshaped = [&](const std::vector<hsize_t>& shape) {
        return [&, shape](hid_t file) {
            removeLink(file, kLocal);
            writeFloats(file, kLocal, zeros, shape);
            writeLocalAttributes(file, {6, 3});
        };
    };
    expectRefused(reshaped({8, 2, 36}), "/visibility/local", good);
    expectRefused(reshaped({2 * 8 * 36}), "/visibility/local", good);
    expectRefused(
        [&](hid_t file) {
            std::vector<float> spoiled = zeros;
            spoiled[3] = std::numeric_limits<float>::quiet_NaN();
            const Hdf5Handle dataset(H5Dopen2(file, kLocal, H5P_DEFAULT), H5Dclose, "test");
            checkHdf5(H5Dwrite(dataset, H5T_NATIVE_FLOAT, H5S_ALL, H5S_ALL, H5P_DEFAULT, spoiled.data()), "test");
        },
        "/visibility/local: not a finite number", good);
    expectRefused(
        [](hid_t file) {
            removeLink(file, kLocal);
            makeGroup(file, kLocal);
        },
        "/visibility/local", good);
}

TEST(HostileFiles, OtherKindsAreNotGuessedAt) {
    const samples::Folder folder("kinds");
    writeModel(folder.path / "x.h5", samples::model(FeatureKind::kRelativeBones));
    EXPECT_THROW(VisibilityReader(folder.path / "x.h5"), InvalidInput);
    writeWholeFile(folder.path / "text", "not HDF5 at all");
    EXPECT_THROW(readModel(folder.path / "text"), InvalidInput);
}

}  // namespace
}  // namespace penumbra::test_hostile_files
