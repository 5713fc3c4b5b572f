"""Steps of blender_steps.py that hold faults which were mended once."""
from types import SimpleNamespace as Some

import bpy
import numpy as np
from blender_common import check, said, values


def names_of_files(folder):
    """Characters whose names differ by odd letters alone, and two .blend files in a folder, have files of their own."""
    from penumbra_addon import files

    found = set()
    for name in ("Hero.001", "Hero_001", "Рыцарь", "Шахтёр"):
        thing = bpy.data.objects.new(name, None)
        thing.penumbra.folder = folder
        path = files.file_of(thing.penumbra, ".npy").name
        check(path.startswith("saved_with_blanks__."), path)
        found.add(path.lower())
        bpy.data.objects.remove(thing)
    check(len(found) == 4, found)


def mouse_of_a_job():
    """Buttons reach the panel alone while a job runs."""
    from penumbra_addon import operators

    regions = [Some(type="HEADER", x=100, y=50, width=50, height=10), Some(type="WINDOW", x=100, y=0, width=50, height=50)]
    areas = [Some(type="PROPERTIES", regions=regions), Some(type="VIEW_3D", regions=[Some(type="WINDOW", x=0)])]
    inside = [
        operators.in_properties(Some(screen=Some(areas=areas)), Some(mouse_x=x, mouse_y=y))
        for x, y in ((100, 0), (149, 49), (150, 20), (120, 55), (20, 20))
    ]
    check(inside == [True, True, False, False, False], inside)


def other_versions():
    import penumbra_addon

    penumbra_addon.refuse_later((4, 5, 9))
    try:
        penumbra_addon.refuse_later((5, 0, 0))
    except RuntimeError as error:
        check("3.4 to 4.5" in str(error), error)
    else:
        check(False, "Blender 5.0 is not refused")


def show(body):
    """A plate that shares a material with the body stays as bright as it was, and Hide takes every node away."""
    material = body.material_slots[0].material
    before = [node.name for node in material.node_tree.nodes], len(material.node_tree.links)
    check(bpy.ops.penumbra.show(wanted=True) == {"FINISHED"}, "show")
    source = material.node_tree.nodes["Penumbra multiply by"]
    graph = bpy.context.evaluated_depsgraph_get()
    dark = body.evaluated_get(graph).to_mesh().attributes[source.attribute_name].data
    value = np.array([entry.value for entry in dark])
    check(abs(1 - value - values(body, "penumbra_ao")).max() <= 1e-6, "materials multiply by 1 - this attribute")
    check(material.node_tree.nodes["Penumbra multiply open"].operation == "SUBTRACT", "a missing attribute is 0")
    check(bpy.ops.penumbra.show(wanted=False) == {"FINISHED"}, "hide")
    check(before == ([node.name for node in material.node_tree.nodes], len(material.node_tree.links)), "all is back")


def twins(rig, box):
    """A linked duplicate is left out by its own name, though its mesh has the other's."""
    settings = rig.penumbra
    twin = box.copy()
    twin.name, box.data.name = "Twin", "Twin.001"
    bpy.context.scene.collection.objects.link(twin)
    twin.matrix_parent_inverse.translation.x += 0.3
    twin.penumbra.role = "WITHOUT"
    settings.frames, settings.first, settings.last = "OWN", 1, 3
    check(bpy.ops.penumbra.make_asset() == {"FINISHED"}, said(settings))
    bpy.data.objects.remove(twin)


def deleted_under_a_job(rig):
    """The character goes while the program runs: the job ends with a reason, and so does the program."""
    from penumbra_addon import operators, programs

    started, real = [], programs.start

    def delete_after_start(command):
        started.append(real(command))
        bpy.data.objects.remove(bpy.data.objects[rig])
        return started[-1]

    programs.start = delete_after_start
    try:
        bpy.ops.penumbra.bake_frames(character=rig)
    except RuntimeError as error:
        check("is gone" in str(error), error)
    else:
        check(False, "a job without its character goes on")
    programs.start = real
    check(started[0].poll() is not None and operators.Course.now is None, "the program ends with the job")
    check(not bpy.context.window_manager.penumbra.running, "nothing runs")
