"""The two ways from Blender to occlusion, and what follows them. Each is a generator of (share done, text).

Route A bakes what Blender shows, frame by frame. Route B exports the character, bakes the exported file and fits a
model of the pose, for engines.
"""
import json
import pathlib

import bpy
import numpy as np

from . import causes, glb, play, standins
from .files import file_of, scratch
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


def bake_words(settings):
    """Returns the options of `penumbra-bake visibility` for the settings. Heights are z in Blender and y in the
    files."""
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
    tools, scene, _ = programs(context), context.scene, attribute_of(settings)
    who = members(scene, settings.id_data)
    spans = spans_of(scene, who.character, settings)
    things = who.meshes + who.occluders
    record = yield from part(record_frames(context, who, things, spans), 0, 0.3)
    bake, rate = file_of(settings, ".frames.vis.h5"), frame_rate(scene, spans[0].step)
    with scratch(settings, ".cache.npz") as cache, scratch(settings, ".occluders.npz") as others:
        own = write_cache(cache, record, who.meshes, rate)
        words = bake_words(settings)
        if who.occluders:
            write_cache(others, record, who.occluders, rate)
            words += ["--occluder", others]
        yield from part(tools.run("bake", "visibility", cache, "-o", bake, *words), 0.3, 0.95)
    table = yield from part(occlusion(tools, settings, bake), 0.95, 0.98)
    if table.shape != (len(record.points), own.sum()):
        raise Failed(f"{bake} has {table.shape} values, not {len(record.points)} frames of {own.sum()} vertices")
    counts = record.counts[: len(who.meshes)]
    clips = clip_rows(record)
    forget(who.meshes, settings)
    play.attach(who.meshes, counts, table, clips, settings.attribute)
    settings.bake, settings.rig, settings.asset = str(bake), "", ""
    keep(settings, clips, table)
    report(f"{len(table)} frames of {own.sum()} vertices are in the attribute {settings.attribute}")
    for line in level_warnings(who.meshes):
        report(line)
    yield 1.0, "done"


def occlusion(tools, settings, source, *words):
    """The table [F,R] of ambient visibility of a bake or an asset."""
    with scratch(settings, ".values.npy") as path:
        yield from tools.run("pack", "export", source, *words, "-o", path, "--as", "npy", *TELL)
        return np.load(path)


def check_counts(tools, settings, source):
    """Refuses a file that is not what the .blend remembers: another .blend or another character may have written it."""
    with scratch(settings, ".info.json") as path:
        yield from tools.run("bake", "info", source, "--report", path, *TELL)
        figures = json.loads(path.read_text(encoding="utf-8"))["figures"]
    found = figures["frames"], figures["mesh"]["source_vertices"]
    wanted = settings.frame_count, settings.vertex_count
    if found != wanted:
        text = "{} frames of {} vertices"
        raise Failed(f"{source} has {text.format(*found)}, not the {text.format(*wanted)} of the last run: bake again")


def attribute_of(settings):
    """The name of the attribute. Without one there is nothing to attach."""
    if not settings.attribute.strip():
        raise Failed("the attribute has no name: give it one, such as penumbra_ao")
    return settings.attribute


def forget(things, settings):
    """Takes the modifiers of the last result away, also when the attribute has another name by now."""
    before, now = settings.attached or settings.attribute, settings.attribute
    for ending in ("", MODEL):
        play.detach(things, before + ending)
        play.show_other(things, before + ending, now + ending)
    settings.attached = now


def clip_rows(record):
    return [(s.name, record.rows_of(s)[0], s.count, s.first, s.step) for s in record.spans]


def keep(settings, clips, table):
    """The part of a result that the .blend keeps: its clips, and the numbers of frames and of vertices in the files."""
    settings.frame_count, settings.vertex_count = table.shape
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
    glb.rename(path, copies.names, copies.of_data, copies.clips)


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
    tools, scene, _ = programs(context), context.scene, attribute_of(settings)
    who = members(scene, settings.id_data)
    if not who.armature:
        raise Failed(f"{who.character.name} has no armature: a run-time asset is a function of the bones' pose")
    spans = spans_of(scene, who.character, settings)
    if min(span.count for span in spans) < 2:
        raise Failed("a clip needs two frames or more")
    things = sorted(who.meshes + who.without, key=lambda thing: thing.name)
    record = yield from part(record_frames(context, who, things + who.occluders, spans), 0, 0.2)
    rig, bake = file_of(settings, ".glb"), file_of(settings, ".vis.h5")
    own = slice_of(record, len(things))
    yield 0.2, "exporting glTF"
    export_character(context, who, things, own, rig)
    words = bake_words(settings) + without_words(who) + (["--local"] if is_composed(settings) else [])
    with scratch(settings, ".occluders.npz") as others:
        if who.occluders:
            write_cache(others, still(record, report), who.occluders, frame_rate(scene, spans[0].step))
            words += ["--occluder", others]
        yield from part(tools.run("bake", "visibility", rig, "-o", bake, *words), 0.25, 0.6)
    of_source = glb.vertex_numbers(rig, [thing.name for thing in who.without])
    yield from part(check_pose(tools, settings, who, own, bake, of_source), 0.6, 0.65)
    asset = yield from part(fit_and_pack(tools, settings, who, rig, bake), 0.65, 0.95)
    settings.bake, settings.rig, settings.asset = str(bake), str(rig), str(asset)
    table = yield from part(occlusion(tools, settings, bake), 0.95, 1.0)
    forget(things, settings)
    attach_sources(own, file_rows(own, rig, table), of_source, settings.attribute)
    keep(settings, clip_rows(own), table)
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
    with scratch(settings, ".positions.npy") as path:
        yield from tools.run("pack", "export", bake, "-o", path, "--as", "npy", "--positions", *TELL)
        posed = file_rows(record, file_of(settings, ".glb"), np.load(path))
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
    model, fields, light, asset = (file_of(settings, e) for e in (".model.h5", ".fields.h5", ".light.h5", ".pnb"))
    words = []
    if is_composed(settings):
        yield from part(tools.run("bake", "fields", rig, "-o", fields, *without_words(who), *TELL), 0, 0.3)
        words = ["--fields", fields]
    yield from part(tools.run("fit", "visibility", bake, *words, "-o", model, *TELL), 0.3, 0.8)
    picture = pathlib.Path(bpy.path.abspath(settings.light)) if settings.light else None
    source = [picture] if picture else ["--analytic", "overcast"]
    yield from part(tools.run("fit", "light", *source, "-o", light, *TELL), 0.8, 0.85)
    words = ["--materials-of", rig, "--textures", "embed", "--light", light, "-o", asset, *TELL]
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
