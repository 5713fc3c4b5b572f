"""The two ways from Blender to occlusion, and what follows them. Each is a generator of (share done, text).

Route A bakes what Blender shows, frame by frame. Route B exports the character, bakes the exported file and fits a model
of the pose, for engines.
"""
import pathlib
import tempfile

import bpy
import numpy as np

from . import causes, glb, play, standins
from .members import members
from .preferences import programs
from .programs import Failed
from .properties import ray_count
from .record import record_frames, spans_of

TELL = ("--progress", "openjd")  # --quiet would silence it
MODEL = "_model"  # ends the name of the attribute that shows the model


def part(steps, first, end):
    """The progress of `steps` as the piece [first, end] of a whole; returns what they return."""
    try:
        while True:
            share, text = next(steps)
            yield first + (end - first) * share, text
    except StopIteration as stop:
        return stop.value
    finally:
        steps.close()


def folder_of(settings):
    """Where the files of a character go: beside the .blend, or in a temporary folder while that has no name."""
    if settings.folder.startswith("//") and not bpy.data.filepath:
        folder = pathlib.Path(tempfile.gettempdir()) / "penumbra"
    else:
        folder = pathlib.Path(bpy.path.abspath(settings.folder))
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise Failed(f"{folder} cannot be made: {error.strerror}") from error
    return folder


def file_of(settings, who, ending):
    return folder_of(settings) / (bpy.path.clean_name(who.character.name) + ending)


def bake_words(settings):
    """What the settings say to `penumbra-bake visibility`. Heights are z in Blender and y in the files."""
    words = ["--rays", ray_count(settings), *TELL]
    if settings.ground:
        words += ["--ground", f"{settings.ground_height:.9g}"]
    if settings.distance > 0:
        words += ["--distance", f"{settings.distance:.9g}"]
    return words


def write_cache(path, record, things, fps):
    """A point cache of some of the recorded meshes (formats/README.md): positions of all frames, and triangles."""
    chosen = np.isin(np.array(record.names), [thing.name for thing in things])
    of_vertex = np.repeat(chosen, record.counts)
    number = np.cumsum(of_vertex) - 1
    faces = number[record.faces[of_vertex[record.faces[:, 0]]]]
    try:
        np.savez(path, verts=record.points[:, of_vertex], faces=faces.astype(np.int32), fps=np.float32(fps))
    except OSError as error:
        raise Failed(f"{path} cannot be written: {error.strerror}") from error
    return of_vertex


def frame_rate(scene, step):
    return scene.render.fps / scene.render.fps_base / step


def bake_frames(context, settings, report):
    """Route A. The result is exact for everything that Blender has, and knows the baked frames alone."""
    tools, scene = programs(context), context.scene
    who = members(scene, settings.id_data)
    spans = spans_of(scene, who.character, settings)
    things = who.meshes + who.occluders
    record = yield from part(record_frames(context, who, things, spans), 0, 0.3)
    cache, bake = file_of(settings, who, ".cache.npz"), file_of(settings, who, ".frames.vis.h5")
    own = write_cache(cache, record, who.meshes, frame_rate(scene, spans[0].step))
    words = bake_words(settings)
    if who.occluders:
        others = file_of(settings, who, ".occluders.npz")
        write_cache(others, record, who.occluders, frame_rate(scene, spans[0].step))
        words += ["--occluder", others]
    yield from part(tools.run("bake", "visibility", cache, "-o", bake, *words), 0.3, 0.95)
    table = yield from part(occlusion(tools, settings, who, bake), 0.95, 0.98)
    if table.shape != (len(record.points), own.sum()):
        raise Failed(f"{bake} has {table.shape} values, not {len(record.points)} frames of {own.sum()} vertices")
    counts = record.counts[: len(who.meshes)]
    clips = clip_rows(record)
    play.attach(who.meshes, counts, table, clips, settings.attribute)
    settings.bake, settings.rig, settings.asset = str(bake), "", ""
    keep_clips(settings, clips)
    report(f"{len(table)} frames of {own.sum()} vertices are in the attribute {settings.attribute}")
    for line in level_warnings(who.meshes):
        report(line)
    yield 1.0, "done"


def occlusion(tools, settings, who, source, *words):
    """The table [F,R] of ambient visibility of a bake or an asset."""
    path = file_of(settings, who, ".npy")
    yield from tools.run("pack", "export", source, *words, "-o", path, "--as", "npy", *TELL)
    return np.load(path)


def clip_rows(record):
    return [(s.name, record.rows_of(s)[0], s.count, s.first, s.step) for s in record.spans]


def keep_clips(settings, clips):
    settings.played.clear()
    for name, first_row, rows, first_frame, step in clips:
        clip = settings.played.add()
        clip.name, clip.first_row, clip.rows, clip.first_frame, clip.step = name, first_row, rows, first_frame, step


def level_warnings(things):
    """Renders show another mesh where levels of subdivision differ; the modifier then shows no occlusion."""
    for thing in things:
        for modifier in thing.modifiers:
            levels = getattr(modifier, "levels", 0), getattr(modifier, "render_levels", 0)
            other_levels = modifier.type in ("SUBSURF", "MULTIRES") and levels[0] != levels[1]
            if other_levels or modifier.show_viewport != modifier.show_render:
                yield f"{thing.name}: renders show another {modifier.name} than the viewport, which was baked"


def export_character(context, who, things, record, path):
    """Writes the stand-ins as a .glb with the names of the originals."""
    if not hasattr(bpy.types, "EXPORT_SCENE_OT_gltf"):
        raise Failed("switch on Blender's own add-on for glTF 2.0")
    copies = standins.build(context, who, things, record)
    window, before = context.window, context.window.scene
    hooked = play.unhook_all()
    try:
        window.scene = copies.scene
        layer = copies.scene.view_layers[0]
        layer.update()
        with context.temp_override(scene=copies.scene, view_layer=layer):
            bpy.ops.export_scene.gltf(filepath=str(path), **export_words())
    except RuntimeError as error:
        raise Failed(f"the exporter of glTF: {str(error).strip().splitlines()[-1]}") from error
    finally:
        window.scene = before
        play.hook_again(hooked)
        copies.remove()
    glb.rename(path, copies.names, copies.clips)


def export_words():
    """Options of the exporter, those that this Blender's has: 4.0 and 4.2 renamed and dropped some."""
    wanted = dict(
        export_format="GLB", export_attributes=True, export_all_influences=True, export_apply=False, export_morph=True,
        export_morph_normal=True, export_skins=True, export_yup=True, export_animations=True, export_frame_range=False,
        export_force_sampling=True, export_nla_strips=True, export_animation_mode="NLA_TRACKS", use_active_scene=True,
        export_optimize_animation_size=False, export_optimize_animation_keep_anim_armature=True,
        export_anim_single_armature=False, export_reset_pose_bones=True, export_cameras=False, export_lights=False,
        export_rest_position_armature=True, export_negative_frame="SLIDE", export_influence_nb=8,
    )  # fmt: skip
    known = set(bpy.ops.export_scene.gltf.get_rna_type().properties.keys())
    return {name: value for name, value in wanted.items() if name in known}


def make_asset(context, settings, report):
    """Route B. What the exported file lost is found by its posed vertices, and refused with the cause."""
    tools, scene = programs(context), context.scene
    who = members(scene, settings.id_data)
    if not who.armature:
        raise Failed(f"{who.character.name} has no armature: a run-time asset is a function of the bones' pose")
    spans = spans_of(scene, who.character, settings)
    if min(span.count for span in spans) < 2:
        raise Failed("a clip needs two frames or more")
    things = sorted(who.meshes + who.without, key=lambda thing: thing.name)
    record = yield from part(record_frames(context, who, things + who.occluders, spans), 0, 0.2)
    rig, bake = file_of(settings, who, ".glb"), file_of(settings, who, ".vis.h5")
    own = slice_of(record, len(things))
    yield 0.2, "exporting glTF"
    export_character(context, who, things, own, rig)
    words = bake_words(settings) + without_words(who) + (["--local"] if is_composed(settings) else [])
    if who.occluders:
        others = file_of(settings, who, ".occluders.npz")
        write_cache(others, still(record, report), who.occluders, frame_rate(scene, spans[0].step))
        words += ["--occluder", others]
    yield from part(tools.run("bake", "visibility", rig, "-o", bake, *words), 0.25, 0.6)
    of_source = glb.vertex_numbers(rig, [thing.name for thing in who.without])
    yield from part(check_pose(tools, settings, who, own, bake, of_source), 0.6, 0.65)
    asset = yield from part(fit_and_pack(tools, settings, who, rig, bake), 0.65, 0.95)
    settings.bake, settings.rig, settings.asset = str(bake), str(rig), str(asset)
    table = yield from part(occlusion(tools, settings, who, bake), 0.95, 1.0)
    attach_sources(own, file_rows(own, rig, table), of_source, settings.attribute)
    keep_clips(settings, clip_rows(own))
    report(f"{asset} is {asset.stat().st_size / 1e6:.2f} MB; {settings.attribute} shows its bake")
    report(f"no vertex is missing in glTF, and none is off by more than {settings.pose_error:.0e} diagonals")
    yield 1.0, "done"


def slice_of(record, count):
    """The record of the first `count` meshes."""
    vertices = int(record.counts[:count].sum())
    faces = record.faces[record.faces[:, 0] < vertices]
    return type(record)(
        record.spans, record.names[:count], record.counts[:count], faces, record.points[:, :vertices],
        record.used[:vertices], record.meshes[:, :count], record.armature, record.bones, record.keys[:count],
    )  # fmt: skip


def still(record, report):
    """The first frame of the record. A model of the pose knows no occluder that moves by itself."""
    if not np.allclose(record.meshes, record.meshes[0], atol=1e-5):
        report("occluders that move are taken where they stand in the first frame")
    return type(record)(record.spans, record.names, record.counts, record.faces, record.points[:1], record.used)


def without_words(who):
    commas = [thing.name for thing in who.without if "," in thing.name]
    if commas:
        raise Failed(f"{commas[0]}: a name of what is left out may have no comma")
    return [word for thing in who.without for word in ("--without", thing.name)]


def file_rows(record, rig, table):
    """The rows of a bake of the file in the order of the record: exporters order clips in their own way."""
    order = [s for name in glb.clip_order(rig) for s in record.spans if s.name == name]
    if sum(s.count for s in order) != len(table) or len(order) != len(record.spans):
        raise Failed(f"{rig} has {len(table)} frames, not the {sum(s.count for s in record.spans)} that were recorded")
    rows, first = {}, 0
    for span in order:
        rows[span.name] = table[first : first + span.count]
        first += span.count
    return np.concatenate([rows[s.name] for s in record.spans])


def check_pose(tools, settings, who, record, bake, of_source):
    """Refuses a file whose posed vertices are not where Blender has them."""
    path = file_of(settings, who, ".positions.npy")
    yield from tools.run("pack", "export", bake, "-o", path, "--as", "npy", "--positions", *TELL)
    posed = file_rows(record, file_of(settings, who, ".glb"), np.load(path))
    missing = causes.unmatched(without(record, who.without), of_source)
    if missing:
        raise Failed(f"the exporter of glTF left out faces with {missing} vertices")
    worst = causes.errors(record, posed, of_source)
    meshes = [bpy.data.objects[name] for name in record.names]
    lines = causes.explain(meshes, who.armature, record, worst)
    if lines:
        raise Failed("glTF cannot say what Blender shows:\n" + "\n".join(lines))
    settings.pose_error = float(worst.max())


def without(record, things):
    """The record with no used vertices in these meshes."""
    left_out = np.isin(np.array(record.names), [thing.name for thing in things])
    used = record.used & ~np.repeat(left_out, record.counts)
    return type(record)(record.spans, record.names, record.counts, record.faces, record.points, used)


def is_composed(settings):
    """Whether the model has fields of the far parts. These know no distance from which on occluders do not count."""
    return settings.distance == 0


def fit_and_pack(tools, settings, who, rig, bake):
    model, fields, light, asset = (file_of(settings, who, e) for e in (".model.h5", ".fields.h5", ".light.h5", ".pnb"))
    words = []
    if is_composed(settings):
        yield from part(tools.run("bake", "fields", rig, "-o", fields, *without_words(who), *TELL), 0, 0.3)
        words = ["--fields", fields]
    yield from part(tools.run("fit", "visibility", bake, *words, "-o", model, *TELL), 0.3, 0.8)
    picture = pathlib.Path(bpy.path.abspath(settings.light)) if settings.light else None
    source = [picture] if picture else ["--analytic", "overcast"]
    yield from part(tools.run("fit", "light", *source, "-o", light, *TELL), 0.8, 0.85)
    words = ["--materials-of", rig, "--light", light, "-o", asset, *TELL]
    yield from part(tools.run("pack", "asset", model, *words), 0.85, 1.0)
    return asset


def attach_sources(record, table, of_source, attribute):
    """Plays a table of source vertices [F,R] on Blender's vertices. One that became several has their mean."""
    vertices = int(record.counts.sum())
    weight = np.bincount(of_source, minlength=vertices)
    values = np.stack([np.bincount(of_source, row, vertices) for row in table])
    values = np.where(weight > 0, values / np.maximum(weight, 1), 1.0).astype(np.float32)
    things = [bpy.data.objects[name] for name in record.names]
    play.attach(things, record.counts, values, clip_rows(record), attribute)


def compare(context, settings, report):
    """The model beside the bake: the attribute of the bake, and one of the model, in all frames of the bake."""
    tools, who = programs(context), members(context.scene, settings.id_data)
    if not settings.asset:
        raise Failed("make a run-time asset first")
    rig, rate = pathlib.Path(settings.rig), frame_rate(context.scene, settings.played[0].step)
    # Lengths of clips are floats: a millionth more keeps the last frame, which else lies behind the end.
    words = [rig, "--rate", f"{rate * (1 + 1e-6):.9g}"]
    model = yield from part(occlusion(tools, settings, who, pathlib.Path(settings.asset), *words), 0, 0.6)
    truth = yield from part(occlusion(tools, settings, who, pathlib.Path(settings.bake)), 0.6, 1.0)
    if model.shape != truth.shape:
        raise Failed(f"the model gives {model.shape[0]} frames of {model.shape[1]} vertices, the bake {truth.shape}")
    show_model(who, settings, rig, model)
    error = float(np.sqrt(np.mean((model.astype(np.float64) - truth) ** 2)))
    report(f"{settings.attribute + MODEL} shows the model; rms {error:.4f} from the bake")
    yield 1.0, "done"


def show_model(who, settings, rig, model):
    things = sorted(who.meshes + who.without, key=lambda thing: thing.name)
    trees = [thing.modifiers.get(play.modifier_name(settings.attribute)) for thing in things]
    if not all(trees):
        raise Failed("the meshes have changed since the run-time asset was made: make it again")
    counts = [modifier[play.input_names(modifier.node_group)["Vertices"]] for modifier in trees]
    of_source = glb.vertex_numbers(rig, [thing.name for thing in who.without])
    record = Played(settings.played, [thing.name for thing in things], np.array(counts))
    attach_sources(record, file_rows(record, rig, model), of_source, settings.attribute + MODEL)


class Played:
    """What the .blend remembers of a record: its clips, meshes and counts."""

    def __init__(self, clips, names, counts):
        self.spans = [PlayedSpan(c.name, c.first_frame, c.rows, c.step, c.first_row) for c in clips]
        self.names, self.counts = names, counts

    def rows_of(self, span):
        return span.first_row, span.first_row + span.count


class PlayedSpan:
    def __init__(self, name, first, count, step, first_row):
        self.name, self.first, self.count, self.step, self.first_row = name, first, count, step, first_row


def export(context, settings, output, kind, use_model):
    """`penumbra-pack export` of the last bake, or of the last model."""
    source = settings.asset if use_model else settings.bake
    if not source:
        raise Failed("make a run-time asset first" if use_model else "bake first")
    if kind in ("static", "play") and not settings.rig:
        raise Failed(f"{kind} goes into the .glb of a run-time asset: make one first, or export table or npy")
    words = [pathlib.Path(settings.rig)] if settings.rig else []
    words += ["-o", pathlib.Path(output), "--as", kind, *TELL]
    yield from programs(context).run("pack", "export", pathlib.Path(source), *words)

