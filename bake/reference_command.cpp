// penumbra-bake reference X.vis.h5 --frame N -o REF.png: a ray-traced picture to compare results with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <utility>

#include "bake/bake_verbs.h"
#include "bake/reference/bake_reference.h"
#include "bake/reference/reference_blockers.h"
#include "bake/reference/scene_frame.h"
#include "bake/source/surface_colors.h"
#include "formats/brdf/brdf_source.h"
#include "formats/common/errors.h"
#include "formats/common/picture_text.h"
#include "formats/common/slot_choice.h"
#include "formats/image/exposure.h"
#include "sh/light/light_rotation.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

struct ReferenceCommand {
    std::filesystem::path input, scene, output, tangents;
    double time = 0;            // of a scene, seconds
    std::string light, layout;  // light: a file or analytic lights; layout "": by the picture's shape
    BrdfSource brdf;
    std::vector<std::string> slots;
    std::vector<std::filesystem::path> occluders;
    ReferenceOptions options;
    std::int64_t frame = 0;
    std::string light_rotation;
    int light_order = 0;  // 0: the picture itself
    std::string albedo;   // of --bounces: R/G/B or a table
    const CLI::Option *light_order_option = nullptr, *frame_option = nullptr, *time_option = nullptr;
    std::vector<const CLI::Option*> bake_only;  // what a picture of a scene does not read
    std::string camera, size = "512x512", channel = "shaded", background = "transparent";
    std::optional<float> exposure;       // unset: automaticExposure()
    std::optional<Vec3> png_background;  // of a shaded PNG; options.background is then unset
};

void checkInput(const ReferenceCommand& command) {
    if (command.input.empty() == command.scene.empty())
        throw UsageError(command.input.empty() ? "a bake, X.vis.h5, or a --scene S.json is required"
                                               : "a bake or a --scene: one or the other");
    if (command.scene.empty() && command.frame_option->count() == 0) throw UsageError("--frame is required");
    if (command.scene.empty() && command.time_option->count() > 0)
        throw UsageError("--time is of no use without --scene");
    for (const CLI::Option* option : command.bake_only)
        if (!command.scene.empty() && option->count() > 0)
            throw UsageError(option->get_name() + " is of no use with --scene");
}

void finishOptions(ReferenceCommand& command) {
    checkInput(command);
    ReferenceOptions& options = command.options;
    const std::optional<PictureSize> size = parseSize(command.size);
    if (!size) throw UsageError("--size must be WIDTHxHEIGHT in pixels, not '" + command.size + "'");
    options.width = size->width;
    options.height = size->height;
    options.channel = command.channel == "ao"        ? ReferenceChannel::kAmbient
                      : command.channel == "normals" ? ReferenceChannel::kNormals
                                                     : ReferenceChannel::kShaded;
    if (command.background != "transparent") {
        options.background = parseColor(command.background);
        if (!options.background)
            throw UsageError("--background must be transparent or R/G/B (linear, 0 or more), not '" +
                             command.background + "'");
    }
    if (command.light_order_option->count() > 0 && command.light.empty())
        throw UsageError("--light-order needs --light: the default light is the same at any order");
    if (!command.layout.empty() && command.light.empty()) throw UsageError("--layout needs --light");
    if (!command.light_rotation.empty() && command.light.empty())
        throw UsageError("--light-rotation needs --light: the default light is the same from every side");
    if (command.light_order < 0 || command.light_order > kMaxOrder)
        throw UsageError("--light-order must be 0 (the picture itself) or 1..8, not " +
                         std::to_string(command.light_order));
    if (command.exposure && (!(*command.exposure > 0) || !std::isfinite(*command.exposure)))
        throw UsageError("--exposure must be a finite number above 0");
    if (const std::string problem = findProblem(options); !problem.empty()) throw UsageError(problem);
    if (options.bounces == 0 && !command.albedo.empty()) throw UsageError("--albedo goes with --bounces");
    const std::string extension = command.output.extension().string();
    if (extension != ".exr" && extension != ".png") throw UsageError("-o must end in .exr or .png");
    // The background of a shaded PNG is put behind the exposed picture.
    if (extension == ".png" && options.channel == ReferenceChannel::kShaded)
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

// Tells an analytic light from a file: the text starts with the name of one.
bool isAnalytic(const std::string& light) {
    const std::vector<std::string> names = analyticLightNames();
    const std::string start = light.substr(0, light.find_first_of(":+"));
    return std::find(names.begin(), names.end(), start) != names.end();
}

EnvironmentLight readLight(const ReferenceCommand& command) {
    if (!isAnalytic(command.light)) return readEnvironmentLight(command.light, command.layout);
    if (!command.layout.empty()) throw UsageError("--layout is of pictures, not of --light " + command.light);
    try {
        return EnvironmentLight::fromAnalytic(parseLights(command.light));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--light: ") + error.what());
    }
}

EnvironmentLight readLightOf(const ReferenceCommand& command) {
    if (command.light.empty()) return EnvironmentLight::white();
    EnvironmentLight light = readLight(command);
    if (command.light_order > 0) light = light.bandLimited(command.light_order);
    try {
        return light.turned(parseLightRotation(command.light_rotation));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--light-rotation: ") + error.what());
    }
}

BrdfSource slotSource(const SlotChoice& choice) {
    BrdfSource source = brdfSource(choice.material);
    source.analytic_option = "--slot";
    return source;
}

BrdfReading readMaterialOf(const ReferenceCommand& command, int threads) {
    BrdfSource source = command.brdf;
    source.analytic_option = "--brdf";
    if (source.analytic.empty() && source.files().empty()) source.analytic = "lambert";
    return readBrdfSource(source, threads);
}

void addMaterial(ReferenceCommand& command, const BrdfReading& material, bool two_sided) {
    if (material.membrane && !two_sided)
        throw Unsupported(material.brdf.name + ": a membrane needs a two-sided mesh (visibility --two-sided)");
    if (material.membrane && material.membrane->open_back)
        throw Unsupported(material.brdf.name + ": back=open is no material that light could make; use back=own");
    command.options.brdfs.push_back(material.brdf);
    command.options.membranes.push_back(material.membrane);
}

// Reads the materials of the parts that have one of their own, and tells which of options.brdfs each vertex has.
std::vector<std::uint16_t> chooseSlots(ReferenceCommand& command, const Mesh& mesh, int threads) {
    if (command.slots.empty()) return {};
    const std::vector<std::string_view> slots(mesh.slots.begin(), mesh.slots.end());
    std::vector<std::uint16_t> brdf_of_slot(slots.size(), 0), brdf_of_vertex;
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
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const std::string& name = scene.materials[m];
        BrdfSource source;
        source.analytic = name;
        source.analytic_option = "--brdf";
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

EnvironmentLight readLightOf(const ReferenceCommand& command, const SceneFrame& scene) {
    EnvironmentLight light = EnvironmentLight::white();
    if (!command.light.empty()) {
        light = readLight(command);
        if (command.light_order > 0) light = light.bandLimited(command.light_order);
    } else if (scene.light_order > 0) {
        light = EnvironmentLight::fromSh(scene.light_order, scene.light);
    }
    return light.turned(scene.light_rotation);
}

// Returns what the mesh reflects, as --albedo says or as the bake has it, and what it lets through in the bake.
SurfaceColors colorsOf(const ReferenceCommand& command, const VisibilityHeader& header) {
    if (command.options.bounces == 0) return {};
    if (command.albedo.empty() && header.colors.albedo.empty())
        throw UsageError("--bounces needs --albedo: " + command.input.string() + " has none");
    if (command.albedo.empty()) return header.colors;
    const SurfaceColors colors{readAlbedo(command.albedo, header.mesh), header.colors.transmission};
    if (const std::string problem = findProblem(colors, header.mesh); !problem.empty())
        throw UsageError("--albedo: " + command.input.string() + " has " + problem);
    return colors;
}

void runScene(ReferenceCommand& command, const CommonOptions& common, Report& report) {
    finishOptions(command);
    report.phase("read");
    const bool shaded = command.options.channel == ReferenceChannel::kShaded;
    std::optional<double> seconds;
    if (command.time_option->count() > 0) seconds = command.time;
    const SceneDescription description = readScene(command.scene);
    report.willRead(filesNamedIn(description));
    const SceneFrame scene = poseScene(description, seconds, command.camera, shaded);
    const std::size_t ground = description.ground ? scene.brdf_of_vertex.back() : scene.materials.size();
    if (shaded) readMaterialsOf(command, scene, ground, common.threads);
    const EnvironmentLight light = readLightOf(command, scene);
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
    input.scale = scene.scale;
    input.back_of_vertex = scene.back_of_vertex;
    const Image image = renderReference(input, scene.camera, light, command.options, common.threads,
                                        parseProgressStyle(common.quiet ? "none" : common.progress));
    report.phase("write");
    writePicture(command, common, image, report);
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
    command.options.brdfs.clear();
    addMaterial(command, material, header.mesh.two_sided);
    const auto count = std::int64_t(header.frames.frameCount());
    if (command.frame < 0 || command.frame >= count)
        throw UsageError("--frame must be 0.." + std::to_string(count - 1) + ", not " + std::to_string(command.frame));
    const VisibilityFrame frame = reader.readPose(std::size_t(command.frame));
    Camera camera;
    try {
        const std::vector<Vec3>& rest = header.mesh.rest_positions;
        camera = makeCamera(command.camera, frame.positions, boxDiagonal(rest) / 2, defaultPitch(rest));
    } catch (const std::invalid_argument& error) {
        throw UsageError(std::string("--camera: ") + error.what());
    }
    const ReferenceBlockers blockers =
        blockersOfFrame(header, std::size_t(command.frame), command.input.string(), command.occluders);
    const std::vector<std::uint16_t> brdf_of_vertex = chooseSlots(command, header.mesh, common.threads);
    const EnvironmentLight light = readLightOf(command);
    const SurfaceColors colors = colorsOf(command, header);
    if (common.dry_run) {
        std::printf("frame %zu, %dx%d pixels, %d shadow rays a pixel\n", std::size_t(command.frame),
                    command.options.width, command.options.height, command.options.samples);
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
    input.albedo = colors.albedo;
    input.transmission = colors.transmission;
    const Image image = renderReference(input, camera, light, command.options, common.threads,
                                        parseProgressStyle(common.quiet ? "none" : common.progress));
    report.phase("write");
    writePicture(command, common, image, report);
}

void defineReference(CLI::App& app, ReferenceCommand& command) {
    ReferenceOptions& options = command.options;
    app.add_option("visibility", command.input, "X.vis.h5: mesh and frames; its visibility is not used");
    app.add_option("--scene", command.scene,
                   "S.json instead of a bake: everyone casts on everyone and on the ground (docs/scene.md)");
    command.time_option =
        app.add_option("--time", command.time, "of a scene: seconds into everyone's clip (default: as it says)")
            ->check(CLI::Range(0.0, 1e6))
            ->default_str("");
    app.add_option("-o,--output", command.output, "REF.exr or REF.png")->required();
    command.frame_option = app.add_option("--frame", command.frame, "index into the file's frames")->default_str("");
    app.add_option("--brdf", command.brdf.analytic, "NAME[:key=value,...] (default: lambert)");
    app.add_option("--merl", command.brdf.merl, "measurements of the MERL database (.binary)");
    app.add_option("--table", command.brdf.table,
                   "scattered measurements (Cornell's .brdf), fits (.csv) or a Penumbra BRDF table");
    app.add_option("--material", command.brdf.material, "which row of a --table of fits");
    app.add_option(
           "--slot", command.slots,
           "SLOT=SPEC: the material of a part of the mesh (info lists the slots), an analytic one or the file of "
           "a measured one (FILE.csv:ROW of fits); any number of them, the other parts have the one above. Of a scene: "
           "MATERIAL=SPEC, what a material of its assets is")
        ->allow_extra_args(false);
    const CLI::Option* occluders =
        app.add_option("--occluder", command.occluders,
                       "of the bake, each as it was given there and in that order; not drawn")
            ->allow_extra_args(false);
    const CLI::Option* tangents =
        app.add_option("--tangents", command.tangents,
                       "X.model.h5 whose tangents anisotropic materials follow (default: a stand-in tangent)");
    app.add_option(
        "--light", command.light,
        "picture (.exr, .hdr), .light.h5, or analytic lights as in penumbra-fit light --analytic (default: white, "
        "radiance 1)");
    app.add_option("--layout", command.layout, "of the picture; by its shape when not given")
        ->check(CLI::IsMember({"latlong", "angular", "ball", "cube"}));
    const CLI::Option* rotation =
        app.add_option("--light-rotation", command.light_rotation,
                       "yaw=,pitch=,roll= or axis=X/Y/Z,angle=, degrees, as in penumbra-player render");
    const CLI::Option* bounces =
        app.add_option("--bounces", options.bounces,
                       "how often the mesh reflects light diffusely or lets it through as its bake says, 0..16");
    const CLI::Option* albedo = app.add_option(
        "--albedo", command.albedo,
        "of --bounces: what the mesh reflects, R/G/B or FILE.csv as in visibility (default: as the bake has it)");
    command.bake_only = {command.frame_option, occluders, tangents, rotation, bounces, albedo};
    command.light_order_option = app.add_option("--light-order", command.light_order,
                                                "replace the picture of --light by its SH of this order (0: do not)");
    app.add_option("--camera", command.camera, "yaw=,pitch=,fov=,distance=,target=x/y/z; framed where not given");
    app.add_option("--size", command.size, "WIDTHxHEIGHT, pixels");
    app.add_option("--samples", options.samples, "shadow rays a pixel");
    app.add_option("--aa", options.camera_rays, "camera rays a pixel");
    app.add_option("--exposure", command.exposure,
                   "factor on the colours of a shaded PNG (default: automatic and printed: the 90th percentile of the "
                   "picture's luminance is shown as 0.6)");
    app.add_option("--background", command.background, "transparent or R/G/B (linear)");
    app.add_option("--channel", command.channel, "what to draw")->check(CLI::IsMember({"shaded", "ao", "normals"}));
    app.footer(describeBrdfs() + "\n" + describeAnalyticLights() + "\n" + app.get_footer());
}

}  // namespace

Verb referenceVerb() {
    const auto command = std::make_shared<ReferenceCommand>();
    return {"reference",
            "Ray-trace a picture of a baked frame: full-resolution light, true BRDF, shadow rays.",
            [command](CLI::App& app) { defineReference(app, *command); },
            [command] {
                std::vector<std::filesystem::path> inputs;
                for (const std::filesystem::path& file : {command->input, command->scene})
                    if (!file.empty()) inputs.push_back(file);
                if (!command->light.empty() && !isAnalytic(command->light)) inputs.push_back(command->light);
                if (!command->tangents.empty()) inputs.push_back(command->tangents);
                if (const ColorChoice albedo = readColorChoice(command->albedo); albedo.table)
                    inputs.push_back(*albedo.table);
                const auto occluders = singleFilesOf(command->occluders);
                inputs.insert(inputs.end(), occluders.begin(), occluders.end());
                for (const std::filesystem::path& file : command->brdf.files()) inputs.push_back(file);
                for (const std::string& slot : command->slots)
                    for (const std::filesystem::path& file : slotSource(parseSlotChoice(slot)).files())
                        inputs.push_back(file);
                return inputs;
            },
            [command] { return command->output; },
            [command](const CommonOptions& common, Report& report) { runReference(*command, common, report); }};
}

}  // namespace penumbra
