"""Where the programs are, in the preferences of the add-on."""
import sys

import bpy

from .programs import Programs, words_of


class PenumbraPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    prefix: bpy.props.StringProperty(
        name="Command before",
        description="Starts the programs somewhere else: wsl, or docker run --rm -v C:/art:/art penumbra",
    )
    folder: bpy.props.StringProperty(
        name="Folder of the programs", description="Holds penumbra-bake and its sisters; empty: they are found by PATH"
    )
    path_from: bpy.props.StringProperty(name="Files here", description="How the names of files begin in Blender: C:\\art")
    path_to: bpy.props.StringProperty(
        name="Files there", description="How they begin where the programs run: /art. With wsl, drives need no help"
    )

    def draw(self, _context):
        for name in ("folder", "prefix", "path_from", "path_to"):
            self.layout.prop(self, name)


def programs(context):
    """The programs as the preferences say. Without the add-on's preferences (a test) they come from PATH."""
    addon = context.preferences.addons.get(__package__)
    if not addon:
        return Programs()
    chosen = addon.preferences
    prefix = words_of(chosen.prefix, windows=sys.platform == "win32")
    return Programs(prefix, chosen.folder, chosen.path_from, chosen.path_to)


def register():
    bpy.utils.register_class(PenumbraPreferences)


def unregister():
    bpy.utils.unregister_class(PenumbraPreferences)
