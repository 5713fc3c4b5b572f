// Turns files into characters, materials and lights.
#include <algorithm>

#include "formats/common/errors.h"
#include "formats/common/fp16.h"
#include "formats/common/warning.h"
#include "formats/image/factor_light.h"
#include "formats/image/picture_light.h"
#include "formats/scene/scene_origin.h"
#include "formats/scene/scene_placement.h"
#include "player/frame/framed_rest.h"
#include "player/frame/truth_frames.h"
#include "player/scene/side_by_side.h"
#include "player/view/view_cast.h"
#include "player/view/view_look.h"
#include "player/view/view_shapes.h"
#include "sh/sh_basis.h"

namespace penumbra {

namespace {

static_assert((kGroundUnderResolution - 1) % kGroundTiles == 0, "tiles are alike");

bool isCharacter(const AssetView& asset) { return asset.has_mesh && asset.hasCharacter(); }

// Moves the slots' materials behind `first` others. Returns the slots, to which `asset` points.
std::vector<SlotSurface> moveSurface(std::size_t first, AssetView& asset) {
    if (!asset.surface) return {};
    std::vector<SlotSurface> slots(asset.surface->slots.begin(), asset.surface->slots.end());
    const auto move = [&](std::uint16_t& material) { material = std::uint16_t(material + first); };
    for (SlotSurface& slot : slots) {
        move(slot.materials.diffuse);
        for (std::size_t step = 0; step < slot.materials.steps; ++step) {
            move(slot.materials.f0[step]);
            move(slot.materials.f90[step]);
        }
    }
    asset.surface->slots = slots;
    return slots;
}

// Gathers every file's materials and lights. The slots of the character's own file keep theirs. Returns the slots with
// pictures, to which `asset` points.
std::vector<SlotSurface> gatherLibrary(const Scene& scene, const SceneFile& own, AssetView& asset) {
    std::vector<SlotSurface> slots;
    // the first material where the file names none
    asset.slot_material.resize(std::max<std::size_t>(1, asset.mesh.slots.size()));
    asset.materials.clear();
    asset.lights.clear();
    for (const SceneFile& file : scene.files) {
        if (!file.asset) {
            asset.lights.push_back({file.light_name,
                                    kPictureLightOrder,
                                    file.light_sh,
                                    {},
                                    file.light_suns,
                                    {},
                                    {file.picture_width, file.picture_width / 2, file.picture}});
            continue;
        }
        const AssetView& view = file.asset->view;
        if (&file == &own && !view.materials.empty()) {  // a file without materials of its own takes the scene's first
            for (std::uint16_t& material : asset.slot_material) material += std::uint16_t(asset.materials.size());
            slots = moveSurface(asset.materials.size(), asset);
        }
        asset.materials.insert(asset.materials.end(), view.materials.begin(), view.materials.end());
        asset.lights.insert(asset.lights.end(), view.lights.begin(), view.lights.end());
    }
    if (asset.lights.empty()) return slots;
    int order = 1;
    for (const LightView& light : asset.lights) order = std::max(order, light.order);
    asset.lights.push_back({"", order, std::span(scene.dark_light).first(std::size_t(3 * coefficientCount(order)))});
    return slots;
}

void attachTruth(Scene& scene, const AssetView& truth) {
    std::string problem;
    bool fits = false;
    for (const auto& character : scene.characters) try {
            checkTruth(character->asset, truth);
            character->truth = &truth;
            fits = true;
        } catch (const InvalidInput& error) {
            problem = error.what();
        }
    if (!fits) throw InvalidInput(problem);
}

void placeCharacters(Scene& scene) {
    std::vector<BoundingBox> boxes;
    for (const auto& character : scene.characters) boxes.push_back(restBox(character->asset));
    const std::vector<float> places = placesSideBySide(boxes);
    for (std::size_t i = 0; i < places.size(); ++i) scene.characters[i]->placement.m[3] = places[i];
}

// Places everyone where the scene's file says, and finds the poses that it names.
void placeMembers(Scene& scene) {
    for (std::size_t i = 0; const SceneCharacter* member = memberOf(scene, i); ++i) {
        Character& character = *scene.characters[i];
        character.placement = placementOf(*member);
        if (member->pose) character.file_pose = &scene.poses.poseOf(*member, character.asset);
    }
}

// Reads the scene's file among the paths, if there is one. Returns the paths of its members, in their order, and then
// all others.
std::vector<std::filesystem::path> filesOf(std::span<const std::filesystem::path> paths, Scene& scene) {
    std::vector<std::filesystem::path> files;
    for (const std::filesystem::path& path : paths) {
        if (path.extension() != ".json") continue;
        if (scene.file) throw InvalidInput(path.string() + ": a second scene; the window shows one");
        scene.file = readScene(path);
        if (scene.file->characters.empty())
            throw InvalidInput(path.string() + ": has no characters, which the window needs");
        for (const SceneCharacter& one : scene.file->props)
            if (isRealMesh(one)) throw InvalidInput(one.at + ": is a mesh, which the window does not show");
        for (const std::vector<SceneCharacter>* list : {&scene.file->characters, &scene.file->props})
            for (const SceneCharacter& one : *list) files.push_back(one.asset);
        if (!scene.file->light.asset.empty()) files.push_back(scene.file->light.asset);
    }
    std::ranges::copy_if(paths, std::back_inserter(files),
                         [](const auto& path) { return path.extension() != ".json"; });
    return files;
}

// Makes a character. `like` is a character of the same file, whose decoded models it shares, or null.
std::unique_ptr<Character> makeCharacter(const Scene& scene, const SceneFile& file, const Character* like) {
    auto character = std::make_unique<Character>();
    character->file_bytes = file.asset->file.bytes().size();
    character->asset = file.asset->view;
    if (character->asset.animation.clips.empty()) throw InvalidInput(character->asset.name + ": holds no clip");
    requireFrames(character->asset);
    character->pictured_slots = gatherLibrary(scene, file, character->asset);
    character->posed.evaluator =
        like ? std::make_unique<Evaluator>(*like->posed.evaluator) : std::make_unique<Evaluator>(character->asset);
    character->timeline.evaluator = std::make_unique<Evaluator>(*character->posed.evaluator);
    if (character->asset.model.deforming)
        character->posed.position_interpolation = std::make_unique<PositionInterpolation>(character->asset);
    else
        character->posed.interpolation = std::make_unique<PoseInterpolation>(character->asset);
    if (!character->asset.materials.empty() && !character->asset.lights.empty())
        character->shown.shading = makeShading(scene, character->asset, {});
    return character;
}

SceneFile openFile(const std::filesystem::path& path, int threads, const OpenChoice& choice) {
    SceneFile file;
    if (path.extension() != ".exr" && path.extension() != ".hdr") {
        file.asset = std::make_unique<OpenAsset>(path);
        return file;
    }
    PictureLightChoice of_light{std::max(kPictureLightOrder, kFactorOrder), 1, {}, {}};
    if (choice.progress) of_light.progress = [&](double share) { choice.progress(path, share); };
    const PictureLight picture = readPictureLight({&path, 1}, choice.reading, of_light);
    for (const std::string& warning : picture.map.notes.warnings)
        reportWarning("penumbra-player", path.string() + ": " + warning);
    const MapProjection projection = picture.project(kPictureLightOrder, threads);
    file.light_name = path.filename();
    file.light_sh.assign(projection.sh.begin(), projection.sh.end());
    const LightSuns factored = factorLight(picture.map, picture.project(kFactorOrder, threads).sh, {});
    for (const SunD& sun : factored.suns) file.light_suns.push_back(floatSun(sun));
    file.picture_width = factored.picture.width;
    file.picture.resize(factored.picture.pixels.size());
    floatToHalf(factored.picture.pixels, file.picture);
    file.backdrop = skyPicture(picture.map);
    return file;
}

// Opens each file once, however often it is named. Returns for every path which of scene.files it is.
std::vector<std::size_t> openFiles(std::span<const std::filesystem::path> paths, int threads, const OpenChoice& choice,
                                   Scene& scene) {
    std::vector<std::size_t> file_of_path;
    for (std::size_t i = 0; i < paths.size(); ++i) {
        std::error_code unreadable;  // then it is opened, and the reason said
        std::size_t same = 0;
        while (same < i && !std::filesystem::equivalent(paths[same], paths[i], unreadable)) ++same;
        file_of_path.push_back(same < i ? file_of_path[same] : scene.files.size());
        if (same == i) scene.files.push_back(openFile(paths[i], threads, choice));
    }
    return file_of_path;
}

}  // namespace

Scene openScene(std::span<const std::filesystem::path> given, int threads, const OpenChoice& choice) {
    Scene scene;
    scene.textures = choice.textures;
    scene.dark_light.resize(std::size_t(3 * coefficientCount(kMaxOrder)));
    const std::vector<std::filesystem::path> paths = filesOf(given, scene);
    const std::vector<std::size_t> file_of_path = openFiles(paths, threads, choice, scene);
    const std::size_t members = scene.file ? scene.file->characters.size() + scene.file->props.size() : 0;
    std::vector<const Character*> first_of_file(scene.files.size());
    for (std::size_t i = 0; i < paths.size(); ++i) {
        const std::size_t index = file_of_path[i];
        const SceneFile& file = scene.files[index];
        const bool is_character = file.asset && isCharacter(file.asset->view);
        if (i < members && !is_character) throw InvalidInput(paths[i].string() + ": holds no model");
        if (i == members && scene.file && !scene.file->light.asset.empty()) continue;  // it is there for its light
        if (!is_character) continue;
        scene.characters.push_back(makeCharacter(scene, file, first_of_file[index]));
        if (!first_of_file[index]) first_of_file[index] = scene.characters.back().get();
    }
    if (scene.characters.empty())
        throw InvalidInput(paths.front().string() + ": holds no model; make one with penumbra-pack asset");
    for (const SceneFile& file : scene.files)
        if (file.asset && file.asset->view.has_truth) attachTruth(scene, file.asset->view);
    const AssetView& first = scene.characters.front()->asset;
    for (const MaterialView& material : first.materials) scene.material_names.push_back(material.name);
    for (const LightView& light : lightsOf(first)) scene.light_names.push_back(light.name);
    for (const SceneFile& file : scene.files)
        scene.backdrops.insert(scene.backdrops.end(), file.asset ? file.asset->view.lights.size() : 1,
                               file.asset ? nullptr : &file.backdrop);
    std::optional<GroundHeights> heights;
    if (scene.file) heights = openGround(*scene.file);
    scene.file ? placeMembers(scene) : placeCharacters(scene);
    if (scene.file) {
        scene.ground_file = scene.file->ground;
    } else {
        scene.ground_file = groundUnder(restBounds(scene));
        scene.ground_file->casts = false;  // nobody asked for it: files alone look as `render` draws them
    }
    if (heights) scene.field = std::make_unique<SceneField>(*scene.ground_file, std::move(*heights));
    makeCasters(scene);
    return scene;
}

}  // namespace penumbra
