"""The panel, in the properties of an object and in those of rendering, and the role of a collection."""
import textwrap

import bpy

from .members import character_of
from .operators import settings_of


def draw_job(layout, job):
    layout.label(text=job.status)
    row = layout.row(align=True)
    row.prop(job, "share", slider=True)
    row.operator("penumbra.cancel", icon="X")


def draw_frames(layout, settings):
    column = layout.column(align=True)
    column.prop(settings, "frames")
    if settings.frames == "OWN":
        row = column.row(align=True)
        row.prop(settings, "first")
        row.prop(settings, "last")
    if settings.frames == "CLIPS":
        column.prop(settings, "clips")
    column.prop(settings, "step")


def draw_quality(layout, settings):
    column = layout.column(align=True)
    column.prop(settings, "quality")
    if settings.quality == "OWN":
        column.prop(settings, "rays")
    column.prop(settings, "distance")
    row = column.row(align=True, heading="Ground")
    row.prop(settings, "ground", text="")
    sub = row.row()
    sub.active = settings.ground
    sub.prop(settings, "ground_height")


def button(layout, settings, name, **look):
    """A button of this character, whatever object is active."""
    result = layout.operator("penumbra." + name, **look)
    result.character = settings.id_data.name
    return result


def draw_buttons(layout, settings):
    column = layout.column(align=True)
    button(column, settings, "bake_frames", icon="RENDER_ANIMATION")
    button(column, settings, "make_asset", icon="PACKAGE")
    row = layout.row(align=True)
    row.enabled = bool(settings.asset)
    button(row, settings, "compare")
    of_model = bool(settings.asset) and settings.source == "MODEL"
    row = layout.row(align=True)
    row.enabled = bool(settings.asset)
    row.prop(settings, "source", expand=True)
    row = layout.row(align=True)
    row.enabled = bool(settings.bake)
    for text, wanted in (("Show", True), ("Hide", False)):
        show = button(row, settings, "show", text=text)
        show.wanted, show.model = wanted, of_model
    row = layout.row(align=True)
    row.enabled = bool(settings.bake)
    for kind, text in (("static", ".glb"), ("play", "Animated"), ("table", "Table"), ("npy", "Numbers")):
        export = button(row, settings, "export", text=text)
        export.kind, export.use_model = kind, of_model


def draw_result(layout, context, settings):
    """The lines of the last run, broken to the width of the panel, because labels do not break themselves."""
    letters = max(24, int(context.region.width / (7.5 * context.preferences.system.ui_scale)))
    for line in settings.lines:
        column = layout.column(align=True)
        for number, piece in enumerate(textwrap.wrap(line.text, letters)):
            icon = ("ERROR" if line.problem else "CHECKMARK") if number == 0 else "BLANK1"
            column.label(text=piece, icon=icon)
    if len(settings.played) > 1:
        for clip in settings.played:
            button(layout, settings, "play", text=clip.name, icon="PLAY").clip = clip.name


def draw_all(layout, context, settings):
    layout.use_property_split, layout.use_property_decorate = True, False
    job = context.window_manager.penumbra
    if job.running:
        draw_job(layout, job)
        return
    draw_frames(layout, settings)
    draw_quality(layout, settings)
    for name in ("attribute", "light", "folder"):
        layout.prop(settings, name)
    draw_buttons(layout, settings)
    draw_result(layout, context, settings)


class PenumbraPanel:
    bl_space_type, bl_region_type, bl_label = "PROPERTIES", "WINDOW", "Penumbra"


class PENUMBRA_PT_object(PenumbraPanel, bpy.types.Panel):
    bl_context = "object"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in ("ARMATURE", "MESH")

    def draw(self, context):
        layout, thing = self.layout, context.object
        if thing.type == "MESH" and not context.window_manager.penumbra.running:
            layout.prop(thing.penumbra, "role")
        character = character_of(thing)
        if character != thing:
            layout.label(text=f"Part of {character.name}", icon="OUTLINER_OB_ARMATURE")
        draw_all(layout, context, character.penumbra)


class PENUMBRA_PT_render(PenumbraPanel, bpy.types.Panel):
    bl_context = "render"

    def draw(self, context):
        self.layout.prop(context.scene, "penumbra_character")
        chosen = context.scene.penumbra_character
        settings = chosen.penumbra if chosen else settings_of(context)
        if settings:
            self.layout.label(text=settings.id_data.name, icon="ARMATURE_DATA")
            draw_all(self.layout, context, settings)


class PENUMBRA_PT_collection(PenumbraPanel, bpy.types.Panel):
    bl_context = "collection"

    def draw(self, context):
        self.layout.prop(context.collection.penumbra, "role")


CLASSES = (PENUMBRA_PT_object, PENUMBRA_PT_render, PENUMBRA_PT_collection)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister():
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
