"""Runs in Blender's window for make_pictures: presses the buttons of the add-on, and draws the result.

usage: blender --python draw_pictures.py -- ZIP BIN FOLDER
"""
import os
import sys
import traceback

import bpy
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import character  # noqa: E402

ARCHIVE, BIN, FOLDER = sys.argv[sys.argv.index("--") + 1 :]
FRAME, PIXELS = 12, (340, 480)


def prepare():
    rig, body, box = character.make()
    bpy.ops.preferences.addon_install(filepath=ARCHIVE, overwrite=True)
    bpy.ops.preferences.addon_enable(module="penumbra_addon")
    bpy.context.preferences.addons["penumbra_addon"].preferences.folder = BIN
    rig.penumbra.folder = FOLDER
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    rig.select_set(True)
    bpy.context.view_layer.objects.active = rig
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    scene.collection.objects.link(camera)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2.25
    camera.location = (-2.4, 3.6, 1.8)
    camera.rotation_euler = (Vector((0, 0, 1.0)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.8, 0.8, 0.8, 1)
    scene.render.resolution_x, scene.render.resolution_y = PIXELS
    scene.view_settings.view_transform = "Standard"


def render(name, engine):
    scene = bpy.context.scene
    engines = scene.render.bl_rna.properties["engine"].enum_items.keys() + ["CYCLES"]
    scene.render.engine = next(e for e in engines if e.startswith(engine))
    scene.cycles.samples, scene.cycles.use_denoising = 32, False  # not every build can denoise
    scene.render.filepath = os.path.join(FOLDER, name + ".png")
    scene.frame_set(FRAME)
    bpy.ops.render.render(write_still=True)


def show_attribute():
    """A material that glows by the attribute alone, as a user would make it."""
    material = bpy.data.materials.new("Occlusion")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    attribute, glow = nodes.new("ShaderNodeAttribute"), nodes.new("ShaderNodeEmission")
    attribute.attribute_name = "penumbra_ao"
    links.new(attribute.outputs["Color"], glow.inputs["Color"])
    links.new(glow.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs[0])
    for name in ("Body", "Box"):
        for slot in bpy.data.objects[name].material_slots:
            slot.material = material


def window_of():
    window = bpy.context.window_manager.windows[0]
    return window, max(window.screen.areas, key=lambda area: area.width * area.height)


def settings():
    return bpy.data.objects["Hero"].penumbra


def press(name, **words):
    window, area = window_of()
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        return getattr(bpy.ops.penumbra, name)("INVOKE_DEFAULT", **words)


def said():
    return " | ".join(line.text for line in settings().lines)


def steps():
    """The course of the window. Each yield lets it draw and go on with its jobs."""
    window, view = window_of()
    view.spaces.active.shading.type = "MATERIAL"
    view.spaces.active.overlay.show_overlays = False
    properties = next(area for area in window.screen.areas if area.type == "PROPERTIES")
    yield
    properties.spaces.active.context = "OBJECT"
    job = bpy.context.window_manager.penumbra
    settings().quality, settings().rays = "OWN", 65536
    press("bake_frames", character="Hero")
    while job.running and not (job.share > 0.35 and "tracing" in job.status):
        yield
    print("progress at", job.share, job.status)
    press("cancel")
    while job.running:
        yield
    assert said() == "stopped" and "Penumbra penumbra_ao" not in bpy.data.objects["Body"].modifiers, said()
    settings().quality = "FINE"
    press("bake_frames", character="Hero")
    while job.running:
        yield
    print("said", said())
    assert "24 frames" in said(), said()
    press("show", wanted=True, character="Hero")
    with bpy.context.temp_override(window=window, area=view, region=view.regions[-1]):
        bpy.ops.view3d.view_camera()
    bpy.context.scene.frame_set(FRAME)
    for _ in range(30):
        yield
    with bpy.context.temp_override(window=window):
        bpy.ops.screen.screenshot(filepath=os.path.join(FOLDER, "panel.png"))
    press("show", wanted=False, character="Hero")
    render("plain", "BLENDER_EEVEE")
    press("show", wanted=True, character="Hero")
    render("shown", "BLENDER_EEVEE")
    show_attribute()
    render("cycles", "CYCLES")
    print("DRAWN")


def run(course):
    def tick():
        try:
            next(course)
            return 0.1
        except StopIteration:
            pass
        except BaseException:
            traceback.print_exc()
        sys.stdout.flush()
        os._exit(0)

    return tick


try:
    prepare()
except BaseException:
    traceback.print_exc()
    sys.stdout.flush()
    os._exit(1)
bpy.app.timers.register(run(steps()), first_interval=1.0)
