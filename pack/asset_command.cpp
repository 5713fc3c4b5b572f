// penumbra-pack asset X.model.h5 --brdf M.brdf.h5 --light E.light.h5 -o X.pnb: the run-time asset.
#include <algorithm>
#include <cstdio>

#include "formats/brdf/fit_slices.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/warning.h"
#include "formats/common/write_file.h"
#include "formats/image/surface_textures.h"
#include "formats/rig/rig_options_json.h"
#include "formats/rig/rig_surface.h"
#include "formats/source/source_looks.h"
#include "formats/source/source_readers.h"
#include "formats/stage/blocker_file.h"
#include "formats/stage/stage_file_kind.h"
#include "pack/compress/coarsen_fields.h"
#include "pack/lod_mesh.h"
#include "pack/named_input.h"
#include "pack/pack_asset.h"
#include "pack/pack_transfer.h"
#include "pack/pack_verbs.h"
#include "pack/resample_model.h"
#include "pack/sections/material_section.h"
#include "pack/sections/source_materials.h"
#include "pack/sections/surface_materials.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

constexpr Word<AssetPrecision> kPrecisionWords[] = {
    {"f32", AssetPrecision::kF32}, {"f16", AssetPrecision::kF16}, {"i8", AssetPrecision::kI8}};

constexpr Word<std::optional<TextureStorage>> kTextureWords[] = {
    {"embed", TextureStorage::kEmbed}, {"link", TextureStorage::kLink}, {"none", {}}};

struct AssetCommand {
    fs::path model, output, blockers, materials_of;
    std::vector<fs::path> brdfs, lights;
    std::vector<std::string> slots;
    PackOptions options;
    std::string albedo;
    std::optional<TextureStorage> textures;
    std::string lod;  // a file, or a node of `rig`
    fs::path rig;
    bool no_playback = false, strict = false;
    float field_step = 0;  // 0: as the fields are
    const CLI::App* app = nullptr;

    // Refuses options that what is packed cannot have.
    void refuse(std::initializer_list<const char*> names, const std::string& why) const {
        for (const char* name : names)
            if (app->get_option(name)->count() > 0) throw UsageError(name + (": " + why));
    }

    std::vector<fs::path> inputs() const {
        std::vector<fs::path> all = {model};
        all.insert(all.end(), brdfs.begin(), brdfs.end());
        all.insert(all.end(), lights.begin(), lights.end());
        all.push_back(blockers);
        all.push_back(materials_of);
        std::error_code error;  // a name that is no file may be a node, which needs --rig: drawLod() says so
        if (!rig.empty() || fs::exists(lod, error)) all.push_back(lodFile());
        return namedFiles(all);
    }
    fs::path lodFile() const { return lod.empty() || !rig.empty() ? rig : fs::path(lod); }
};

std::string provenanceOf(const AssetCommand& command) {
    const PackOptions& given = command.options;
    nlohmann::ordered_json options;
    options["precision"] = given.precision ? nameOf(*given.precision) : "auto";
    if (given.max_error) options["max_error"] = *given.max_error;
    if (given.max_bytes_per_vertex) options["max_bytes_per_vertex"] = *given.max_bytes_per_vertex;
    if (!command.slots.empty()) options["slots"] = command.slots;
    if (given.indirect_bytes_per_vertex) options["bounce_bytes"] = *given.indirect_bytes_per_vertex;
    if (command.no_playback) options["playback"] = false;
    if (command.field_step > 0) options["field_step"] = command.field_step;
    if (!command.albedo.empty()) options["albedo"] = command.albedo;
    if (!command.materials_of.empty()) options["materials_of"] = command.materials_of.filename();
    if (command.textures) options["textures"] = wordOf(kTextureWords, command.textures);
    if (!command.lod.empty())
        options["lod"] = command.rig.empty() ? fs::path(command.lod).filename().string() : command.lod;
    return toJson(makeProvenance("penumbra-pack asset", options.dump(), command.inputs()));
}

// Reports the bytes of every section, and what counts at run time: the bytes a vertex of the visibility model alone,
// and of everything.
void reportSizes(const Packed& packed, bool quiet, Report& report) {
    const AssetView asset = openAsset(packed.bytes);
    const double vertices = double(asset.mesh.positions.size());
    const double model = double(modelBytes(asset, packed.bytes.size()));
    for (const SizeOf& size : sectionSizes(asset, packed.bytes.size())) {
        report.figures["bytes"][size.section] = size.bytes;
        if (!quiet)
            std::printf("  %-17s %10zu bytes  %8.1f a vertex\n", size.section.c_str(), size.bytes,
                        double(size.bytes) / vertices);
    }
    if (const PlaybackView& playback = asset.animation.playback; !playback.positions.empty()) {
        report.figures["playback_error"] = playback.error;
        if (!quiet)
            std::printf("  playback: %zu frames, every position within %.2e m of where it was\n",
                        asset.animation.frameCount(), double(playback.error));
    }
    if (asset.model.composition) {
        const double megabytes = double(asset.model.composition->byteCount()) / 1e6;
        report.figures["fields_megabytes"] = megabytes;
        if (!quiet)
            std::printf("  fields of %zu parts: %.2f MB, not counted in the bytes a vertex\n",
                        asset.model.composition->parts.size(), megabytes);
    }
    if (const std::size_t spheres = asset.blockers.spheres.size(); spheres > 0) {
        report.figures["blockers"] = spheres;
        if (!quiet) std::printf("  %zu sphere blockers: %zu bytes\n", spheres, asset.blockers.byteCount());
    }
    const double all = double(packed.bytes.size());
    report.figures["bytes"]["file"] = packed.bytes.size();
    report.figures["model_bytes_per_vertex"] = model / vertices;
    report.figures["file_bytes_per_vertex"] = all / vertices;
    if (!quiet)
        std::printf("  %-17s %10.0f bytes  %8.1f a vertex\n  %-17s %10.0f bytes  %8.1f a vertex\n", "model alone",
                    model, model / vertices, "file", all, all / vertices);
}

void reportIndirect(const Packed& packed, const IndirectModel& indirect, bool quiet, Report& report) {
    const AssetView asset = openAsset(packed.bytes);
    const double vertices = double(asset.mesh.positions.size());
    double bytes = 0;
    for (const SizeOf& size : sectionSizes(asset, packed.bytes.size()))
        if (size.section == kBouncedSection) bytes = double(size.bytes);
    report.figures["bounced"] = {{"bounces", indirect.bounces},
                                 {"bytes_per_vertex", bytes / vertices},
                                 {"packing_error", packed.indirect_error},
                                 {"components", packed.indirect_components},
                                 {"model_components", packed.all_indirect_components},
                                 {"train_share_of_direct", indirect.train_share}};
    if (!quiet)
        std::printf(
            "  light that bounces: %.1f bytes a vertex, %zu of %zu components; error of packing %.2e of the "
            "signal\n",
            bytes / vertices, packed.indirect_components, packed.all_indirect_components, packed.indirect_error);
}

BrdfFile readMaterial(const fs::path& path) {
    BrdfFile brdf = readBrdf(path);
    naming<Unsupported>(path, [&] { checkMaterial(brdf); });
    return brdf;
}

Vec3 parseAlbedo(const std::string& text) {
    if (text.empty()) return {0.8f, 0.8f, 0.8f};
    const std::optional<Vec3> color = parseColor(text);
    if (!color || std::max({color->x, color->y, color->z}) > 1)
        throw std::invalid_argument("must be R/G/B, linear and within 0..1, not '" + text + "'");
    return *color;
}

// Refuses two files of one name, which cannot be in one asset. `verb` is the verb of penumbra-fit that makes such
// files.
template <class File>
void checkNames(const std::vector<File>& files, const std::vector<fs::path>& paths, const std::string& verb) {
    for (std::size_t i = 0; i < files.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (files[i].name == files[j].name)
                throw InvalidInput(paths[j].string() + " and " + paths[i].string() + " are both \"" + files[i].name +
                                   "\": penumbra-fit " + verb + " --name gives one another name");
}

// The looks of an asset as they are read.
struct Looks {
    std::vector<BrdfFile> brdfs;
    std::vector<LightFile> lights;

    // Slices need the bands of the light: more see nothing, and fewer blur what a glossy surface reflects.
    int bands() const {
        int most = SliceOrders().slice_order;
        for (const LightFile& light : lights) most = std::max(most, light.order);
        return most;
    }
};

// Tells what materials have that is not seen, or refuses it.
void warnOfMaterials(const AssetCommand& command, const std::vector<std::string>& notes) {
    if (command.strict && !notes.empty()) throw Unsupported(notes.front());
    for (const std::string& note : notes) reportWarning("penumbra-pack", note);
}

// Adds the materials that the source file describes, says them, and returns those of the slots of the mesh. Without a
// mesh they are those of the whole file.
std::vector<std::string> addSourceMaterials(const AssetCommand& command, const Mesh* mesh, const CommonOptions& common,
                                            Report& report, Looks& given) {
    report.phase("materials");
    const SourceLooks looks = readSourceLooks(command.materials_of);
    report.willRead(looks.files_read);
    std::vector<std::string> slots = mesh ? mesh->slots : std::vector<std::string>();
    if (mesh && slots.empty()) slots.emplace_back();
    SourceMaterials made;
    try {
        made = materialsOf(looks, slots, given.bands(), common.threads);
    } catch (const InvalidInput& error) {
        throw InvalidInput(command.materials_of.string() + ": " + error.what());
    }
    for (std::string& warning : made.warnings) warning = command.materials_of.string() + ": " + warning;
    warnOfMaterials(command, made.warnings);
    for (const std::string& line : made.said)
        if (!common.quiet) std::printf("  %s\n", line.c_str());
    report.figures["slots"] = made.said;
    for (BrdfFile& brdf : made.materials)
        if (std::ranges::find(given.brdfs, brdf.name, &BrdfFile::name) == given.brdfs.end())
            given.brdfs.push_back(std::move(brdf));
    return mesh && mesh->slots.empty() ? std::vector<std::string>() : std::move(made.of_slot);
}

// Draws the model with the mesh of --lod.
void drawLod(const AssetCommand& command, const CommonOptions& common, Report& report, Model& model) {
    std::error_code error;
    if (command.rig.empty() && !fs::exists(command.lod, error))
        throw BadOption("lod", "'" + command.lod + "' is not a file; --rig names the file of which it is a node");
    report.phase("level of detail");
    const LodMesh lod = readLod(model, command.lodFile(), command.rig.empty() ? "" : command.lod, common.threads);
    report.willRead(lod.files_read);
    for (const std::string& note : lod.notes) reportWarning("penumbra-pack", note);
    const std::size_t fitted = model.mesh.vertexCount();
    Resampled resampled = resampledModel(model, lod.drawn, common.threads);
    model = std::move(resampled.model);
    report.figures["lod"] = {{"vertices", model.mesh.vertexCount()}, {"fitted_vertices", fitted},
                             {"rms_distance", lod.rms_distance},     {"max_distance", lod.max_distance},
                             {"turned_share", lod.turned_share},     {"border_corners", resampled.border_corners}};
    if (!common.quiet)
        std::printf(
            "  %s: %zu vertices take what %zu have; they lie %.2e diagonals from that surface (rms), %.2e at most\n",
            command.lod.c_str(), model.mesh.vertexCount(), fitted, lod.rms_distance, lod.max_distance);
}

// Tells that the asset draws more vertices than it evaluates.
void reportPoints(const CommonOptions& common, Report& report, const Model& model) {
    report.figures["points"] = model.mesh.vertexCount();
    report.figures["drawn_vertices"] = model.drawn->mesh.vertexCount();
    if (!common.quiet)
        std::printf("  %zu vertices are drawn; they follow %zu points\n", model.drawn->mesh.vertexCount(),
                    model.mesh.vertexCount());
}

SphereBlockers readBlockersOf(const Model& model, const fs::path& path) {
    BlockerFile file = readBlockers(path);
    naming(path, [&] { checkCharacter(file, model.mesh, model.skin); });
    return std::move(file.blockers);
}

// Reads the materials of the rig with their pictures, and says them.
SurfaceLook readSurface(const AssetCommand& command, const Model& model, const CommonOptions& common, Report& report) {
    // The rig is read as the bake read it.
    RigOptions options = naming(command.model, [&] { return rigOptionsOf(model.provenance.options_json); });
    if (model.mesh.two_sided) options.sides = RigSides::kFronts;
    const std::string name = command.materials_of.string();
    const SourceLooks looks = readSourceLooks(command.materials_of);
    const Rig rig = readRig({command.materials_of}, options);
    report.willRead(rig.files_read);
    RigSurface read = surfaceOf(rig, name);
    fitSurface(rig, model.mesh, name, read.surface);
    const OpenedTextures opened = openTextures(name, read.surface);
    report.willRead(opened.files);
    read.notes.insert(read.notes.end(), opened.notes.begin(), opened.notes.end());
    const std::vector<std::string> said = setLooks(looks, model.mesh.slots, name, read);
    storeTextures(*command.textures, command.output.parent_path(), read.surface);
    warnOfMaterials(command, read.notes);
    SurfaceLook look{std::move(read.surface), {}};
    addSurfaceMaterials(look, common.threads);
    for (const std::string& line : said)
        if (!common.quiet) std::printf("  %s\n", line.c_str());
    report.figures["slots"] = said;
    report.figures["textures"] = look.surface.textures.size();
    return look;
}

// Packs a linear model of transfer. Without a material it gets one of --albedo.
void runTransfer(const AssetCommand& command, const std::vector<SlotChoice>& slots, const CommonOptions& common,
                 Report& report) {
    command.refuse({"--max-error", "--max-bytes-per-vertex", "--bounce-bytes", "--no-playback", "--field-step",
                    "--blockers", "--materials-of", "--lod"},
                   command.model.string() + " has linear transfer, whose size is that of its components");
    const TransferModel model = readTransfer(command.model);
    TransferPackOptions options;
    options.slots = slots;
    if (command.options.precision) options.precision = *command.options.precision;
    std::vector<BrdfFile> brdfs;
    std::vector<LightFile> lights;
    for (const fs::path& path : command.brdfs) brdfs.push_back(readMaterial(path));
    for (const fs::path& path : command.lights) lights.push_back(readLight(path));
    checkNames(brdfs, command.brdfs, "brdf");
    checkNames(lights, command.lights, "light");
    if (brdfs.empty()) brdfs.push_back(diffuseMaterial(parseAlbedo(command.albedo)));
    report.phase("pack");
    Packed packed;
    packed.bytes =
        naming(command.model, [&] { return packTransfer(model, brdfs, lights, options, provenanceOf(command)); });
    report.figures["precision"] = nameOf(options.precision);
    report.figures["paper_bytes"] = paperBytes(model);
    report.figures["paper_mesh_bytes"] = paperMeshBytes(model);
    if (!common.quiet)
        std::printf("%s: linear transfer, %zu bytes as the paper counts, %.2f%% of one mesh\n", command.output.c_str(),
                    paperBytes(model), 100 * double(paperBytes(model)) / double(paperMeshBytes(model)));
    reportSizes(packed, common.quiet, report);
    report.phase("write");
    if (!common.dry_run) writeWholeFile(command.output, packed.bytes);
}

void runAsset(const AssetCommand& command, const CommonOptions& common, Report& report) {
    PackOptions options = command.options;
    for (const std::string& text : command.slots) options.slots.push_back(parseSlotChoice(text));
    options.playback = !command.no_playback;
    report.phase("read");
    if (!command.model.empty() && stageFileKind(command.model) == "penumbra.transfer")
        return runTransfer(command, options.slots, common, report);
    command.refuse({"--albedo"}, "needs transfer, X.transfer.h5");
    std::optional<Model> model;
    if (!command.model.empty()) model = readModel(command.model);
    if (!model) command.refuse({"--no-playback"}, "needs a model");
    if (!(model && model->composition)) command.refuse({"--field-step"}, "needs a composed model, which has fields");
    if (command.field_step > 0) coarsenFields(command.field_step, model->composition->fields);
    if (!(model && model->indirect))
        command.refuse({"--bounce-bytes"}, "needs a model with light that bounces (penumbra-fit indirect)");
    if (model && !command.blockers.empty()) options.blockers = readBlockersOf(*model, command.blockers);
    if (model && !command.lod.empty())
        drawLod(command, common, report, *model);
    else if (model && model->drawn)
        reportPoints(common, report, *model);
    Looks looks;
    std::vector<BrdfFile>& brdfs = looks.brdfs;
    std::vector<LightFile>& lights = looks.lights;
    for (const fs::path& path : command.brdfs) brdfs.push_back(readMaterial(path));
    for (const fs::path& path : command.lights) lights.push_back(readLight(path));
    checkNames(brdfs, command.brdfs, "brdf");
    checkNames(lights, command.lights, "light");
    if (!command.materials_of.empty() && !command.textures)
        options.slot_materials = addSourceMaterials(command, model ? &model->mesh : nullptr, common, report, looks);
    if (!model) {
        command.refuse({"--lod", "--blockers", "--slot", "--precision", "--max-error", "--max-bytes-per-vertex"},
                       "needs a model");
        command.refuse({"--textures"}, "needs a model");
        const std::vector<std::byte> library = packLibrary(brdfs, lights, provenanceOf(command));
        if (!common.quiet)
            std::printf("%s: %zu materials, %zu lights\n", command.output.c_str(), brdfs.size(), lights.size());
        if (!common.dry_run) writeWholeFile(command.output, library);
        return;
    }
    if (command.textures) options.surface = readSurface(command, *model, common, report);
    report.phase("quantise");
    const Packed packed = naming(command.model, [&] {
        return packAsset(*model, brdfs, lights, options, provenanceOf(command), common.threads);
    });
    report.figures["precision"] = nameOf(packed.precision);
    report.figures["quantization_error"] = packed.quantization_error;
    report.figures["dropped_error"] = packed.dropped_error;
    report.figures["components"] = packed.components;
    report.figures["model_components"] = packed.all_components;
    if (!common.quiet)
        std::printf(
            "%s: precision %s, %zu of %zu components; error of packing %.2e of the signal, %.2e of it by "
            "dropping (training frames)\n",
            command.output.c_str(), nameOf(packed.precision), packed.components, packed.all_components,
            packed.quantization_error, packed.dropped_error);
    if (model->indirect) reportIndirect(packed, *model->indirect, common.quiet, report);
    reportSizes(packed, common.quiet, report);
    report.phase("write");
    if (!common.dry_run) writeWholeFile(command.output, packed.bytes);
}

void defineAsset(CLI::App& app, AssetCommand& command) {
    app.add_option("model", command.model,
                   "X.model.h5, or X.transfer.h5 of penumbra-fit transfer; without it the file holds "
                   "materials and lights for penumbra-player view to add");
    command.app = &app;
    CLI::Option* brdf =
        app.add_option("--brdf", command.brdfs, "M.brdf.h5; any number of them")->allow_extra_args(false);
    app.add_option("--light", command.lights, "E.light.h5; any number of them")->allow_extra_args(false);
    app.add_option("--slot", command.slots,
                   "SLOT=MATERIAL: the material of a part of the mesh (penumbra-bake info lists the "
                   "slots); any number of them, the other parts have the first --brdf")
        ->allow_extra_args(false);
    app.add_option(
        "--materials-of", command.materials_of,
        "RIG.glb (.gltf, .vrm, .fbx, .dae, .x): every slot gets the material that the file describes; --slot "
        "goes before it");
    app.add_option("--blockers", command.blockers,
                   "X.blockers.h5 of penumbra-fit blockers: spheres that cast in the place of the character");
    addChoice(app, "--textures", command.textures, kTextureWords,
              "the pictures of --materials-of: inside the asset, by the names of their files, or left out")
        ->default_str("none")
        ->needs(app.get_option("--materials-of"));
    app.add_flag("--strict", command.strict,
                 "refuse materials of --materials-of of which something would be left out, as a picture that cannot be "
                 "read")
        ->needs(app.get_option("--materials-of"));
    CLI::Option* lod = app.add_option(
        "--lod", command.lod,
        "draw another mesh of the same skeleton, a level of detail, with what the model knows of the surface near it: "
        "a rig file, or with --rig a node of that file (name or glob)");
    app.add_option("--rig", command.rig, "the file that has the node of --lod")->needs(lod);
    app.add_option("--albedo", command.albedo,
                   "R/G/B of the one material of transfer that has no --brdf (default 0.8/0.8/0.8)")
        ->check(readableBy(parseAlbedo))
        ->excludes(brdf);
    app.add_option("-o,--output", command.output, "X.pnb")->required();
    addChoice(app, "--precision", command.options.precision, kPrecisionWords,
              "precision of the visibility basis (i8 unless --max-error); without a bound it keeps every component");
    app.add_option("--max-error", command.options.max_error,
                   "bound on the error of packing (rounded and dropped components), relative to the "
                   "signal: takes the fewest components and the coarsest precision within it")
        ->check(aboveZero());
    app.add_option("--max-bytes-per-vertex", command.options.max_bytes_per_vertex,
                   "bound on the visibility model: drops the components that add least to predictions")
        ->check(aboveZero());
    app.add_option("--bounce-bytes", command.options.indirect_bytes_per_vertex,
                   "bytes a vertex that the light that bounces of penumbra-fit indirect may take "
                   "(default: 60, or as it is with --precision alone)")
        ->check(aboveZero());
    app.add_flag("--no-playback", command.no_playback,
                 "leave out the frames: for engines that move the character themselves");
    app.add_option("--field-step", command.field_step,
                   "store fields in coarser steps, as shares of the sky at the surface of a part: for assets that go "
                   "over a network compressed (0.05 halves the fields; docs/web.md)")
        ->check(aboveZero());
}

}  // namespace

Verb assetVerb() {
    return verbOf<AssetCommand, const AssetCommand>(
        "asset", "Pack a model with materials and lights into a run-time asset.", defineAsset, runAsset);
}

}  // namespace penumbra
