"""The buttons. A job is a generator of routes.py: with a window it runs between redraws, without one to its end."""
import time

import bpy

from . import play, routes
from .members import character_of, members
from .programs import Failed


def settings_of(context, name=""):
    """The settings of the character of that name. Without one: of the character that the active object belongs to, else
    of the one that the scene has chosen, else of the active mesh itself."""
    if name:
        return context.scene.objects[name].penumbra if name in context.scene.objects else None
    mine = character_of(context.object)
    own_mesh = mine is not None and mine.type == "MESH"
    character = context.scene.penumbra_character if mine is None or own_mesh else None
    character = character or mine
    return character.penumbra if character else None


class OfCharacter:
    """An operator of one character."""

    character: bpy.props.StringProperty(options={"HIDDEN", "SKIP_SAVE"})

    def chosen(self, context):
        settings = settings_of(context, self.character)
        if settings is None:
            self.report({"ERROR"}, f"there is no object '{self.character}'")
        return settings


def say(settings, text, problem=False):
    for line in text.splitlines():
        entry = settings.lines.add()
        entry.text, entry.problem = line, problem


class Job(OfCharacter):
    """What all jobs share. A class below says in `steps` which generator it runs."""

    bl_options = {"UNDO"}
    TICK = 0.1  # seconds between redraws
    MOUSE = ("MOUSEMOVE", "LEFTMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE")
    timer = None

    @classmethod
    def poll(cls, context):
        return settings_of(context) is not None and not context.window_manager.penumbra.running

    def begin(self, context):
        self.settings, self.problem = self.chosen(context), False
        self.settings.lines.clear()
        self.running = self.steps(context, self.settings)
        job = context.window_manager.penumbra
        job.cancel, job.share, job.status = False, 0.0, self.bl_label

    def advance(self, context, seconds):
        """Goes on for so long, and says whether the job has ended."""
        job, end = context.window_manager.penumbra, time.monotonic() + seconds
        try:
            if job.cancel:  # what the user asked for is no error
                say(self.settings, "stopped", problem=True)
                self.problem = True
                return True
            while time.monotonic() < end:
                job.share, job.status = next(self.running)
        except StopIteration:
            return True
        except Failed as failed:
            say(self.settings, str(failed), problem=True)
            self.report({"ERROR"}, str(failed))
            self.problem = True
            return True
        return False

    def end(self, context):
        self.running.close()
        context.window_manager.penumbra.running = False
        return {"CANCELLED"} if self.problem else {"FINISHED"}

    def execute(self, context):
        if self.chosen(context) is None:
            return {"CANCELLED"}
        self.begin(context)
        try:
            while not self.advance(context, 60):
                pass
        finally:
            result = self.end(context)
        return result

    def invoke(self, context, _event):
        if bpy.app.background or self.chosen(context) is None:
            return self.execute(context)
        self.begin(context)
        manager = context.window_manager
        manager.penumbra.running = True
        self.timer = manager.event_timer_add(self.TICK, window=context.window)
        manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Other events wait, so that nobody changes what is recorded; the mouse can reach the Cancel button."""
        if event.type == "ESC":
            context.window_manager.penumbra.cancel = True
        if event.type != "TIMER":
            return {"PASS_THROUGH"} if event.type in self.MOUSE else {"RUNNING_MODAL"}
        try:
            ended = self.advance(context, self.TICK / 2)
        except BaseException:
            self.stop_timer(context)
            self.end(context)
            raise
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                area.tag_redraw()
        if not ended:
            return {"RUNNING_MODAL"}
        self.stop_timer(context)
        return self.end(context)

    def stop_timer(self, context):
        context.window_manager.event_timer_remove(self.timer)


class PENUMBRA_OT_bake_frames(Job, bpy.types.Operator):
    """Bake the occlusion of these frames into a colour attribute that plays with the timeline"""

    bl_idname, bl_label = "penumbra.bake_frames", "Bake these frames"

    def steps(self, context, settings):
        return routes.bake_frames(context, settings, lambda text: say(settings, text))


class PENUMBRA_OT_make_asset(Job, bpy.types.Operator):
    """Export the character, bake it, and fit a model of the pose that engines evaluate"""

    bl_idname, bl_label = "penumbra.make_asset", "Make run-time asset"

    def steps(self, context, settings):
        return routes.make_asset(context, settings, lambda text: say(settings, text))


class PENUMBRA_OT_compare(Job, bpy.types.Operator):
    """Show the model of the run-time asset beside the bake, in a second attribute"""

    bl_idname, bl_label = "penumbra.compare", "Compare"

    def steps(self, context, settings):
        return routes.compare(context, settings, lambda text: say(settings, text))


KINDS = (
    ("static", "Static (.glb)", "Mean occlusion in vertex attributes"),
    ("play", "Animated (.glb)", "Vertex colours that follow the clips in any player of glTF"),
    ("table", "Table (.png, .exr)", "A picture with a row of vertices for each frame"),
    ("npy", "Numbers (.npy)", "Frames and vertices for NumPy"),
)
ENDINGS = {"static": ".ao.glb", "play": ".ao.glb", "table": ".ao.exr", "npy": ".ao.npy"}


class PENUMBRA_OT_export(Job, bpy.types.Operator):
    """Write the occlusion as a file that other programs take as it is"""

    bl_idname, bl_label = "penumbra.export", "Export"
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    kind: bpy.props.EnumProperty(name="As", items=KINDS)
    use_model: bpy.props.BoolProperty(name="Of the model", description="What the model says, not the bake")

    def steps(self, context, settings):
        who = members(context.scene, settings.id_data)
        self.filepath = self.filepath or str(routes.file_of(settings, who, ENDINGS[self.kind]))
        yield from routes.export(context, settings, self.filepath, self.kind, self.use_model)
        say(settings, f"{self.filepath} is written")


class PENUMBRA_OT_show(OfCharacter, bpy.types.Operator):
    """Multiply the occlusion into the base colour of the character's materials, or take it away again"""

    bl_idname, bl_label, bl_options = "penumbra.show", "Show in materials", {"REGISTER", "UNDO"}
    wanted: bpy.props.BoolProperty(default=True)
    model: bpy.props.BoolProperty(name="Of the model")

    @classmethod
    def poll(cls, context):
        return settings_of(context) is not None

    def execute(self, context):
        settings = self.chosen(context)
        if settings is None:
            return {"CANCELLED"}
        try:
            things = members(context.scene, settings.id_data).meshes
        except Failed as failed:
            self.report({"ERROR"}, str(failed))
            return {"CANCELLED"}
        attribute = settings.attribute + (routes.MODEL if self.model else "")
        changed = play.show(things, attribute, self.wanted)
        self.report({"INFO"}, f"{changed} materials changed")
        return {"FINISHED"}


class PENUMBRA_OT_play(OfCharacter, bpy.types.Operator):
    """Play this clip with its occlusion"""

    bl_idname, bl_label, bl_options = "penumbra.play", "Play", {"REGISTER", "UNDO"}
    clip: bpy.props.StringProperty()

    def execute(self, context):
        settings = self.chosen(context)
        clip = settings.played.get(self.clip) if settings else None
        if not clip:
            return {"CANCELLED"}
        character = settings.id_data
        if self.clip in bpy.data.actions and character.type == "ARMATURE":
            data = character.animation_data or character.animation_data_create()
            data.use_nla, data.action = False, bpy.data.actions[self.clip]
        row = clip.name, clip.first_row, clip.rows, clip.first_frame, clip.step
        things = members(context.scene, character).meshes
        for ending in ("", routes.MODEL):
            play.play(things, settings.attribute + ending, row)
        return {"FINISHED"}


class PENUMBRA_OT_cancel(bpy.types.Operator):
    """Stop; nothing that was there before changes"""

    bl_idname, bl_label = "penumbra.cancel", "Cancel"

    def execute(self, context):
        context.window_manager.penumbra.cancel = True
        return {"FINISHED"}


CLASSES = (
    PENUMBRA_OT_bake_frames, PENUMBRA_OT_make_asset, PENUMBRA_OT_compare, PENUMBRA_OT_export, PENUMBRA_OT_show,
    PENUMBRA_OT_play, PENUMBRA_OT_cancel,
)  # fmt: skip


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)


def unregister():
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
