// penumbra-bake reference X.vis.h5 --frame N -o REF.png: a ray-traced picture to compare results with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <utility>

#include "bake/bake_verbs.h"
#include "bake/reference/bake_reference.h"
#include "bake/reference/bounced_light.h"
#include "bake/reference/reference_blockers.h"
#include "bake/reference/scene_frame.h"
#include "bake/source/surface_colors.h"
#include "formats/brdf/brdf_source.h"
#include "formats/common/errors.h"
#include "formats/common/options.h"
#include "formats/common/rest_in_scene.h"
#include "formats/common/slot_choice.h"
#include "formats/common/warning.h"
#include "formats/image/exposure.h"
#include "formats/image/light_picture_flags.h"
#include "formats/image/surface_textures.h"
#include "formats/rig/rig_options_json.h"
#include "formats/rig/rig_surface.h"
#include "formats/source/source_looks.h"
#include "formats/source/source_readers.h"
#include "sh/light/light_rotation.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

constexpr Word<ReferenceChannel> kChannelWords[] = {
    {"shaded", ReferenceChannel::kShaded}, {"ao", ReferenceChannel::kAmbient}, {"normals", ReferenceChannel::kNormals}};
constexpr Word<bool> kSelfBounceWords[] = {{"on", true}, {"off", false}};

// Tells an analytic light from a file: the text starts with the name of one.
bool isAnalytic(const std::string& light) {
    const std::vector<std::string> names = analyticLightNames();
    const std::string start = light.substr(0, light.find_first_of(":+"));
    return std::find(names.begin(), names.end(), start) != names.end();
}

BrdfSource slotSource(const SlotChoice& choice) {
    BrdfSource source = brdfSource(choice.material);
    source.analytic_option = "slot";
    return source;
}

struct ReferenceCommand {
    std::filesystem::path input, scene, output, tangents, materials_of;
    std::optional<double> time;  // seconds, for a scene
    std::string light;           // a file or analytic lights
    PictureOptions reading;      // how to read a light from a file
    BrdfSource brdf{.analytic_option = "brdf"};
    std::vector<std::string> slots;
    std::vector<std::filesystem::path> occluders;
    ReferenceOptions options;
    std::optional<std::size_t> frame;
    std::string light_rotation;
    int light_order = 0;  // 0: the picture itself
    std::optional<int> bounces;
    bool self_bounces = true;
    ColorChoice albedo;  // colours for --bounces
    std::string camera;
    std::optional<float> exposure;       // unset: automaticExposure()
    std::optional<Vec3> png_background;  // background of a shaded PNG; options.background is then unset
    bool strict = false;

    std::vector<std::filesystem::path> inputs() const {
        std::vector<std::filesystem::path> files = singleFilesOf(occluders);
        files.insert(files.end(),
                     {input, scene, tangents, materials_of, albedo.table.value_or(""), isAnalytic(light) ? "" : light});
        std::vector<BrdfSource> sources = {brdf};
        for (const std::string& slot : slots) sources.push_back(slotSource(parseSlotChoice(slot)));
        for (const BrdfSource& source : sources)
            for (const std::filesystem::path& file : source.files()) files.push_back(file);
        return namedFiles(files);
    }
};

void finishOptions(ReferenceCommand& command) {
    ReferenceOptions& options = command.options;
    if (command.input.empty() && command.scene.empty())
        throw UsageError("a bake, X.vis.h5, or a --scene S.json is required");
    if (command.scene.empty() && !command.frame) throw UsageError("--frame is required");
    options.bounces = command.bounces.value_or(command.scene.empty() ? 0 : 1);
    if (const std::string problem = endsIn({".exr", ".png"})(command.output.string()); !problem.empty())
        throw UsageError("-o " + problem);
    // The background of a shaded PNG is put behind the exposed picture.
    if (command.output.extension() == ".png" && options.channel == ReferenceChannel::kShaded)
        command.png_background = std::exchange(options.background, std::nullopt);
}

// Writes the picture, a shaded PNG exposed. Prints an automatic exposure, so that other pictures can have the same.
void writePicture(const ReferenceCommand& command, const CommonOptions& common, const Image& image, Report& report) {
    if (command.output.extension() != ".png" || command.options.channel != ReferenceChannel::kShaded)
        return writeImage(command.output, image, 1);
    const float exposure = command.exposure ? *command.exposure : automaticExposure(image);
    report.figures["exposure"] = exposure;
    if (!command.exposure && !common.quiet) std::printf("automatic exposure: --exposure %.4g\n", double(exposure));
    if (!command.png_background) return writePng(command.output, image, exposure);
    writePng(command.output, overBackground(image, exposure, *command.png_background), 1);
}

EnvironmentLight readLight(const ReferenceCommand& command, const CommonOptions& common) {
    if (isAnalytic(command.light)) {
        refuseReading(command.reading, "--light " + command.light);
        return EnvironmentLight::fromAnalytic(parseLights(command.light));
    }
    PictureNotes notes;
    EnvironmentLight light = readEnvironmentLight(command.light, command.reading, notes);
    for (const std::string& warning : notes.warnings) reportWarning("penumbra-bake", command.light + ": " + warning);
    if (!common.quiet)
        for (const std::string& line : notes.lines) std::printf("%s: %s\n", command.light.c_str(), line.c_str());
    return light;
}

EnvironmentLight readLightOf(const ReferenceCommand& command, const CommonOptions& common) {
    if (command.light.empty()) {
        refuseReading(command.reading, "the default white light");
        return EnvironmentLight::white();
    }
    EnvironmentLight light = readLight(command, common);
    if (command.light_order > 0) light = light.bandLimited(command.light_order);
    return light.turned(parseLightRotation(command.light_rotation));
}

BrdfReading readMaterialOf(const ReferenceCommand& command, int threads) {
    BrdfSource source = command.brdf;
    if (source.analytic.empty() && source.files().empty()) source.analytic = "lambert";
    return readBrdfSource(source, threads);
}

void addMaterial(ReferenceCommand& command, const BrdfReading& material, bool two_sided) {
    if (material.membrane && !two_sided)
        throw Unsupported(material.brdf.name + ": a membrane needs a two-sided mesh (visibility --two-sided)");
    if (material.membrane && material.membrane->open_back)
        throw Unsupported(material.brdf.name + ": no real material has back=open; use back=own");
    command.options.brdfs.push_back(material.brdf);
    command.options.membranes.push_back(material.membrane);
    command.options.emissions.push_back(toFloat(material.emission));
}

// Adds the materials that the rig's file describes, and returns which of options.brdfs each slot has; 0 where the file
// has no such slot.
std::vector<std::uint16_t> addSourceMaterials(ReferenceCommand& command, const Mesh& mesh, int threads) {
    const SourceLooks looks = readSourceLooks(command.materials_of);
    std::map<std::string, std::uint16_t> known;
    std::vector<std::uint16_t> brdf_of_slot;
    for (const std::string& slot : mesh.slots) {
        const SourceLook* look = findLook(looks, slot);
        if (!look) reportWarning("penumbra-bake", command.materials_of.string() + ": has no slot '" + slot + "'");
        if (look && !look->problem.empty())
            throw InvalidInput(command.materials_of.string() + ": slot '" + slot + "': " + look->problem);
        const std::string name = look ? toString(shownLook(*look)) : "";
        const auto [found, is_new] = known.try_emplace(name, std::uint16_t(look ? command.options.brdfs.size() : 0));
        if (is_new && look) addMaterial(command, readBrdfSource({.analytic = name}, threads), mesh.two_sided);
        brdf_of_slot.push_back(found->second);
    }
    return brdf_of_slot;
}

// Reads the materials of the parts that have one of their own, and tells which of options.brdfs each vertex has.
std::vector<std::uint16_t> chooseSlots(ReferenceCommand& command, const Mesh& mesh, int threads) {
    if (command.slots.empty() && command.materials_of.empty()) return {};
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    std::vector<std::uint16_t> brdf_of_slot(slots.size(), 0), brdf_of_vertex;
    if (!command.materials_of.empty()) brdf_of_slot = addSourceMaterials(command, mesh, threads);
    for (const std::string& text : command.slots) {
        const SlotChoice choice = parseSlotChoice(text);
        for (const std::size_t slot : findSlots(slots, choice.slot))
            brdf_of_slot[slot] = std::uint16_t(command.options.brdfs.size());
        addMaterial(command, readBrdfSource(slotSource(choice), threads), mesh.two_sided);
    }
    for (const std::uint16_t slot : mesh.slot_of_vertex) brdf_of_vertex.push_back(brdf_of_slot[slot]);
    return brdf_of_vertex;
}

// Tells whether all vertices of a material have another side.
bool isSheet(const SceneFrame& scene, std::size_t material) {
    for (std::size_t v = 0; v < scene.brdf_of_vertex.size(); ++v)
        if (scene.brdf_of_vertex[v] == material && scene.back_of_vertex[v] == v) return false;
    return true;
}

// Reads the materials that the assets name: those that --slot or --brdf give, and analytic ones by their names.
void readMaterialsOf(ReferenceCommand& command, const SceneFrame& scene, std::size_t ground, int threads) {
    command.options.brdfs.clear();
    command.options.emissions.clear();
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const std::string& name = scene.materials[m];
        BrdfSource source{.analytic = name, .analytic_option = "brdf"};
        if (m != ground && (!command.brdf.analytic.empty() || !command.brdf.files().empty())) source = command.brdf;
        for (const std::string& text : command.slots)
            if (const SlotChoice choice = parseSlotChoice(text); choice.slot == name) source = slotSource(choice);
        try {
            addMaterial(command, readBrdfSource(source, threads), isSheet(scene, m));
        } catch (const UsageError& error) {
            if (source.analytic != name) throw;
            throw UsageError("the scene's material \"" + name +
                             "\" is not an analytic one: say what it is by --slot '" + name + "=FILE'");
        }
    }
}

EnvironmentLight readLightOf(const ReferenceCommand& command, const CommonOptions& common, const SceneFrame& scene) {
    EnvironmentLight light = EnvironmentLight::white();
    if (!command.light.empty()) {
        light = readLight(command, common);
        if (command.light_order > 0) light = light.bandLimited(command.light_order);
    } else if (refuseReading(command.reading, "the scene's light"); scene.light_order > 0) {
        light = EnvironmentLight::fromSh(scene.light_order, scene.light);
    }
    return light.turned(scene.light_rotation);
}

RigOptions bakedRigOptions(const std::filesystem::path& bake, const VisibilityHeader& header) try {
    return rigOptionsOf(header.provenance.options_json);
} catch (const InvalidInput& error) {
    throw InvalidInput(bake.string() + ": " + error.what());
}

// Tells whether nothing of a surface changes from point to point of a slot.
bool isPlain(const MeshSurface& surface) {
    return surface.textures.empty() && surface.colors.empty() &&
           std::ranges::none_of(surface.slots, &SlotSurface::blends);
}

// Reads the pictures of --materials-of, whose slots have no other material by --slot; nothing where it has none.
std::optional<PictureSurface> picturesOf(const ReferenceCommand& command, const VisibilityHeader& header,
                                         Report& report) {
    const Mesh& mesh = header.mesh;
    if (command.materials_of.empty()) return {};
    // The rig is read as the bake read it.
    RigOptions options = bakedRigOptions(command.input, header);
    if (mesh.two_sided) options.sides = RigSides::kFronts;
    const std::string name = command.materials_of.string();
    const Rig rig = readRig({command.materials_of}, options);
    report.willRead(rig.files_read);
    RigSurface read = surfaceOf(rig, name);
    if (isPlain(read.surface))  // then any mesh with these slots will do
        read.surface.slots.resize(std::max<std::size_t>(1, mesh.slots.size()));
    else
        fitSurface(rig, mesh, name, read.surface);
    const OpenedTextures opened = openTextures(name, read.surface);
    report.willRead(opened.files);
    read.notes.insert(read.notes.end(), opened.notes.begin(), opened.notes.end());
    (void)setLooks(readSourceLooks(command.materials_of), mesh.slots, name, read);
    if (command.strict && !read.notes.empty()) throw Unsupported(read.notes.front());
    for (const std::string& note : read.notes) reportWarning("penumbra-bake", note);
    if (isPlain(read.surface)) return {};
    std::vector<std::uint16_t> slot_of_triangle;
    for (const Triangle& triangle : mesh.triangles)
        slot_of_triangle.push_back(mesh.slot_of_vertex.empty() ? 0 : mesh.slot_of_vertex[triangle[0]]);
    PictureSurface pictures(std::move(read.surface), std::move(slot_of_triangle), "", name);
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    for (const std::string& text : command.slots)
        for (const std::size_t slot : findSlots(slots, parseSlotChoice(text).slot)) pictures.leaveOut(slot);
    return pictures;
}

// Returns what the mesh reflects, as --albedo says or as the bake has it, and what it lets through in the bake.
SurfaceColors colorsOf(const ReferenceCommand& command, const VisibilityHeader& header) {
    if (command.options.bounces == 0) return {};
    if (!command.albedo.any() && header.colors.albedo.empty())
        throw UsageError("--bounces needs --albedo: " + command.input.string() + " has none");
    if (!command.albedo.any()) return header.colors;
    const SurfaceColors colors{readAlbedo(command.albedo, header.mesh), header.colors.transmission};
    if (const std::string problem = findProblem(colors, header.mesh); !problem.empty())
        throw UsageError("--albedo: " + command.input.string() + " has " + problem);
    return colors;
}

// Returns the share of white light from everywhere that each material reflects; a membrane reflects its rho. Emission
// is left out, because it lights nobody.
std::vector<Vec3> albedosOf(const ReferenceOptions& options) {
    std::vector<Vec3> out;
    for (std::size_t m = 0; m < options.brdfs.size(); ++m) {
        const bool membrane = !options.membranes.empty() && options.membranes[m];
        out.push_back(membrane ? options.membranes[m]->rho : toFloat(whiteAlbedo(options.brdfs[m])));
    }
    return out;
}

void runScene(ReferenceCommand& command, const CommonOptions& common, Report& report) {
    finishOptions(command);
    report.phase("read");
    const bool shaded = command.options.channel == ReferenceChannel::kShaded;
    const SceneDescription description = readScene(command.scene);
    report.willRead(filesNamedIn(description));
    const bool own = command.brdf.analytic.empty() && command.brdf.files().empty();
    const SceneLook look = !shaded ? SceneLook::kNone : own ? SceneLook::kPictures : SceneLook::kMaterials;
    const SceneFrame scene = poseScene(description, command.time, command.camera, look);
    const std::size_t ground = description.ground ? scene.brdf_of_vertex.back() : scene.materials.size();
    if (shaded) readMaterialsOf(command, scene, ground, common.threads);
    const EnvironmentLight light = readLightOf(command, common, scene);
    report.figures = {{"members", description.characters.size() + description.props.size()},
                      {"triangles", scene.mesh.triangles.size()}};
    if (common.dry_run) {
        std::printf("%zu triangles, %dx%d pixels, %d shadow rays a pixel\n", scene.mesh.triangles.size(),
                    command.options.width, command.options.height, command.options.samples);
        return;
    }
    report.phase("render");
    ReferenceFrame input{scene.mesh, scene.frame};
    if (shaded) input.brdf_of_vertex = scene.brdf_of_vertex;
    input.casting_triangles = scene.casting_triangles;
    input.unseen_positions = scene.unseen_positions;
    input.unseen_triangles = scene.unseen_triangles;
    input.ground = scene.ends_at_horizon;
    input.floor = scene.floor;
    input.member_of_vertex = scene.member_of_vertex;
    input.others_alone = !command.self_bounces;
    std::vector<Vec3> albedo;
    if (shaded && command.options.bounces > 0) {
        const std::vector<Vec3> of_material = albedosOf(command.options);
        for (const std::uint16_t m : scene.brdf_of_vertex) albedo.push_back(of_material[m]);
    }
    input.albedo = albedo;
    input.scale = scene.scale;
    input.back_of_vertex = scene.back_of_vertex;
    input.twins = scene.twins;
    input.front_alone = scene.front_alone;
    input.pictures = scene.pictures;
    const Image image = renderReference(input, scene.camera, light, command.options, common.threads, common.progress);
    report.phase("write");
    writePicture(command, common, image, report);
}

// The corners of the character's boxes at rest and in a frame, by which penumbra-player frames pictures, too.
std::array<std::array<Vec3, 2>, 2> framedBoxes(const VisibilityReader& reader, const VisibilityFrame& frame) {
    const Mesh& mesh = reader.header().mesh;
    std::vector<Vec3> rest = mesh.rest_positions;
    if (const std::optional<Skin>& skin = reader.header().skin)
        rest = restInScene(rest, {skin->influences, skin->joints, skin->weights}, reader.readPose(0).bones);
    const BoundingBox at_rest = characterBox(mesh.frontTriangles(), rest);
    const BoundingBox seen = characterBox(mesh.frontTriangles(), frame.positions);
    return {{{at_rest.low, at_rest.high}, {seen.low, seen.high}}};
}

void runReference(ReferenceCommand& command, const CommonOptions& common, Report& report) {
    if (!command.scene.empty()) return runScene(command, common, report);
    finishOptions(command);
    report.phase("read");
    const BrdfReading material = readMaterialOf(command, common.threads);
    report.figures["brdf"] = material.brdf.name;
    for (const auto& [name, value] : material.figures) report.figures[name] = value;
    const VisibilityReader reader(command.input);
    const VisibilityHeader& header = reader.header();
    if (header.distance)
        throw Unsupported(
            command.input.string() +
            ": was baked with --distance, but light of a picture by brute force is hidden at any distance");
    command.options.brdfs.clear();
    addMaterial(command, material, header.mesh.two_sided);
    const std::size_t index = *command.frame, count = header.frames.frameCount();
    if (index >= count)
        throw UsageError("--frame must be 0.." + std::to_string(count - 1) + ", not " + std::to_string(index));
    const VisibilityFrame frame = reader.readPose(index);
    Camera camera;
    try {
        const auto [rest, seen] = framedBoxes(reader, frame);
        camera =
            makeCamera(command.camera, seen, length(toDouble(rest[1]) - toDouble(rest[0])) / 2, defaultPitch(rest));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--camera: ") + error.what());
    }
    const ReferenceBlockers blockers = blockersOfFrame(header, index, command.input.string(), command.occluders);
    const std::vector<std::uint16_t> brdf_of_vertex = chooseSlots(command, header.mesh, common.threads);
    const std::optional<PictureSurface> pictures = picturesOf(command, header, report);
    const EnvironmentLight light = readLightOf(command, common);
    const SurfaceColors colors = colorsOf(command, header);
    if (common.dry_run) {
        std::printf("frame %zu, %dx%d pixels, %d shadow rays a pixel\n", index, command.options.width,
                    command.options.height, command.options.samples);
        return;
    }
    std::optional<PosedTangents> tangents;
    if (!command.tangents.empty())
        tangents = posedTangents(readModel(command.tangents), header.mesh, frame, command.tangents.string());
    report.phase("render");
    ReferenceFrame input{header.mesh, frame, header.ground_y.has_value()};
    if (tangents) input.tangents = &*tangents;
    input.brdf_of_vertex = brdf_of_vertex;
    if (!blockers.blockers.triangles.empty()) input.blockers = &blockers.blockers;
    input.occluder_positions = blockers.occluder_positions;
    input.back_of_vertex = blockers.other_side;
    input.front_alone = blockers.front_alone;
    input.albedo = colors.albedo;
    input.transmission = colors.transmission;
    const PicturePart part{0, pictures ? &*pictures : nullptr};
    if (pictures) input.pictures = {&part, 1};
    const Image image = renderReference(input, camera, light, command.options, common.threads, common.progress);
    report.phase("write");
    writePicture(command, common, image, report);
}

void defineReference(CLI::App& app, ReferenceCommand& command) {
    ReferenceOptions& options = command.options;
    CLI::Option* input =
        app.add_option("visibility", command.input, "X.vis.h5: mesh and frames; its visibility is not used");
    CLI::Option* scene =
        app.add_option("--scene", command.scene,
                       "S.json instead of a bake: everyone casts on everyone and on the ground (docs/scene.md)")
            ->excludes(input);
    app.add_option("--time", command.time, "scene only: seconds into each character's clip (default: as its file says)")
        ->check(within(0.0, 1e6))
        ->needs(scene);
    app.add_option("-o,--output", command.output, "REF.exr or REF.png")->required();
    app.add_option("--frame", command.frame, "index into the file's frames")
        ->check(within<std::int64_t>(0, UINT32_MAX))
        ->excludes(scene);
    app.add_option("--brdf", command.brdf.analytic, "NAME[:key=value,...] (default: lambert)");
    app.add_option("--merl", command.brdf.merl, "measurements of the MERL database (.binary)");
    app.add_option("--table", command.brdf.table,
                   "scattered measurements (Cornell's .brdf), fits (.csv) or a Penumbra BRDF table");
    app.add_option("--material", command.brdf.material, "which row of a --table of fits");
    app.add_option(
           "--slot", command.slots,
           "SLOT=SPEC: the material of a part of the mesh (info lists the slots), an analytic one or the file of "
           "a measured one (FILE.csv:ROW of fits); any number of them, the other parts have the one above. For a "
           "scene: MATERIAL=SPEC, the reflectance of a material of its assets")
        ->allow_extra_args(false);
    app.add_option("--materials-of", command.materials_of,
                   "RIG.glb (.gltf, .vrm, .fbx, .dae, .x): every slot has the material that the file describes, "
                   "with its pictures; --slot goes before it")
        ->excludes(scene);
    app.add_flag("--strict", command.strict,
                 "refuse materials of --materials-of of which something would be left out, as a picture that cannot be "
                 "read")
        ->needs(app.get_option("--materials-of"));
    app.add_option("--occluder", command.occluders,
                   "occluders of the bake, each as it was given there and in that order; they are not drawn")
        ->allow_extra_args(false)
        ->excludes(scene);
    app.add_option("--tangents", command.tangents,
                   "X.model.h5 whose tangents anisotropic materials follow (default: a stand-in tangent)")
        ->excludes(scene);
    const auto analytic = [](const std::string& text) {
        if (isAnalytic(text)) (void)parseLights(text);
        return 0;
    };
    CLI::Option* light = app.add_option("--light", command.light,
                                        "picture (.exr, .hdr), .light.h5, or analytic lights as in penumbra-fit light "
                                        "--analytic (default: white, radiance 1)")
                             ->check(readableBy(analytic));
    addLightPictureOptions(app, command.reading);
    app.add_option("--light-rotation", command.light_rotation,
                   "yaw=,pitch=,roll= or axis=X/Y/Z,angle=, degrees, as in penumbra-player render")
        ->check(readableBy(parseLightRotation))
        ->needs(light)
        ->excludes(scene);
    app.add_option("--light-order", command.light_order,
                   "replace the picture of --light by its SH of this order (0: do not)")
        ->check(within(0, kMaxOrder, "bands"))
        ->needs(light);
    CLI::Option* bounces = app.add_option("--bounces", command.bounces,
                                          "how often surfaces reflect light diffusely, or let it through as the bake "
                                          "says (default: 0, for a scene 1)")
                               ->check(within(0, kMaxBounces, "reflections"));
    addParsed(
        app, "--albedo", command.albedo, readColorChoice,
        "with --bounces: what the mesh reflects, R/G/B or FILE.csv as in visibility (default: as the bake has it)")
        ->needs(bounces)
        ->excludes(scene);
    addChoice(
        app, "--self-bounces", command.self_bounces, kSelfBounceWords,
        "scene only: whether light bounces between parts of the same character too, which run-time pictures of an "
        "asset without light that bounces do not show")
        ->needs(scene);
    app.add_option("--camera", command.camera, "yaw=,pitch=,fov=,distance=,target=x/y/z; framed where not given");
    addSize(app, options.width, options.height);
    app.add_option("--samples", options.samples, "shadow rays a pixel")
        ->check(within(4, 1 << 20, "shadow rays a pixel"));
    app.add_option("--aa", options.camera_rays, "camera rays a pixel")->check(within(1, 64, "camera rays a pixel"));
    app.add_option("--exposure", command.exposure,
                   "factor on the colours of a shaded PNG (default: automatic and printed: the 90th percentile of the "
                   "picture's luminance is shown as 0.6)")
        ->check(aboveZero());
    addParsed(app, "--background", options.background, readBackground, "transparent or R/G/B (linear)")
        ->default_str("transparent");
    addChoice(app, "--channel", options.channel, kChannelWords, "what to draw");
    app.footer(describeBrdfs() + "\n" + describeAnalyticLights() + "\n" + app.get_footer());
}

}  // namespace

Verb referenceVerb() {
    return verbOf<ReferenceCommand>("reference",
                                    "Ray-trace a picture of a baked frame: full-resolution light, true BRDF, shadow "
                                    "rays.",
                                    defineReference, runReference);
}

}  // namespace penumbra
