"""Penumbra in Blender: ambient occlusion of animated characters, as a colour attribute that plays with the timeline,
and as a file for engines. docs/blender.md is the manual."""
bl_info = {
    "name": "Penumbra",
    "author": "Penumbra",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Object > Penumbra, Properties > Render > Penumbra",
    "description": "Occlusion of animated characters: bakes, models for run time, exports",
    "category": "Render",
}

import bpy  # noqa: E402  (Blender reads bl_info first)

from . import operators, panels, preferences, properties  # noqa: E402

MODULES = (preferences, properties, operators, panels)


def refuse_later(version):
    if version >= (5, 0, 0):
        raise RuntimeError("Penumbra's add-on works with Blender 3.4 to 4.5; Blender 5.0 keeps actions in another way")


def register():
    refuse_later(bpy.app.version)
    for module in MODULES:
        module.register()


def unregister():
    for module in reversed(MODULES):
        module.unregister()
