"""The buttons. A job is a generator of routes.py: with a window it runs between redraws, without one to its end."""
import contextlib
import time

import bpy
from bpy.app.handlers import persistent

from . import play, results, routes
from .files import file_of
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


class Kept:
    """The settings of a character by its name. They are looked up anew each time, because Blender's own are of no use
    when the character was deleted or an undo has made it anew; to read them would end Blender."""

    def __init__(self, character):
        library = character.library.filepath if character.library else None
        object.__setattr__(self, "key", (character.name, library))

    def now(self):
        try:
            return bpy.data.objects[self.key].penumbra
        except KeyError:
            raise Failed(f"{self.key[0]} is gone: it was deleted, renamed or undone") from None

    def __getattr__(self, name):
        return getattr(self.now(), name)

    def __setattr__(self, name, value):
        setattr(self.now(), name, value)


class Course:
    """A job under way. It is closed before an undo or another file takes its objects away."""

    now = None

    def __init__(self, steps):
        self.steps, self.lost = steps, False

    def close(self):
        self.steps.close()
        if Course.now is self:
            Course.now = None


@persistent
def stop_job(*_):
    if Course.now:
        Course.now.lost = True
        Course.now.close()
        bpy.context.window_manager.penumbra.running = False


def say(settings, text, problem=False):
    for line in text.splitlines():
        entry = settings.lines.add()
        entry.text, entry.problem = line, problem


def in_properties(window, event):
    """Whether the mouse is where the panel is. Buttons of other editors could change what is recorded."""
    x, y = event.mouse_x, event.mouse_y
    regions = [r for a in window.screen.areas if a.type == "PROPERTIES" for r in a.regions if r.type == "WINDOW"]
    return any(0 <= x - r.x < r.width and 0 <= y - r.y < r.height for r in regions)


class Job(OfCharacter):
    """Base class of all jobs. A class below says in `steps` which generator it runs."""

    bl_options = {"UNDO"}
    TICK = 0.1  # seconds between redraws
    MOUSE = ("LEFTMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE")
    timer = None

    @classmethod
    def poll(cls, context):
        return settings_of(context) is not None and not context.window_manager.penumbra.running

    def begin(self, context):
        self.settings, self.problem = Kept(self.chosen(context).id_data), False
        self.settings.lines.clear()
        self.course = Course.now = Course(self.steps(context, self.settings))
        job = context.window_manager.penumbra
        job.cancel, job.share, job.status = False, 0.0, self.bl_label

    def advance(self, context, seconds):
        """Goes on for so long, and says whether the job has ended."""
        job, end = context.window_manager.penumbra, time.monotonic() + seconds
        try:
            if job.cancel:
                return self.fail("stopped", "INFO")  # the user asked for it, so it is no error
            if self.course.lost:
                return self.fail("stopped by an undo", "WARNING")
            self.settings.now()
            while time.monotonic() < end:
                job.share, job.status = next(self.course.steps)
        except StopIteration:
            return True
        except Failed as failed:
            return self.fail(str(failed), "ERROR")
        except ReferenceError:
            return self.fail("stopped: an object of the character is gone", "ERROR")
        return False

    def fail(self, text, level):
        """Tells why the job ends; in the panel too, where the character is still there."""
        self.problem = True
        if level != "INFO":
            self.report({level}, text)
        with contextlib.suppress(Failed):
            say(self.settings, text, problem=True)
        return True

    def end(self, context):
        self.course.close()
        context.window_manager.penumbra.running = False
        return {"CANCELLED"} if self.problem else {"FINISHED"}

    def cancel(self, context):
        """Blender ends the job: it quits, or closes the window."""
        self.end(context)

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
            free = event.type == "MOUSEMOVE" or event.type in self.MOUSE and in_properties(context.window, event)
            return {"PASS_THROUGH"} if free else {"RUNNING_MODAL"}
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
        return results.compare(context, settings, lambda text: say(settings, text))


KINDS = (
    ("static", "Static (.glb)", "Mean occlusion in vertex attributes"),
    ("play", "Animated (.glb)", "Vertex colours that follow the clips in any player of glTF"),
    ("table", "Table (.png, .exr)", "A picture with a row of vertices for each frame"),
    ("npy", "Numbers (.npy)", "Frames and vertices for NumPy"),
)
ENDINGS = {"static": ".ao.glb", "play": ".play.glb", "table": ".table.exr", "npy": ".npy"}


class PENUMBRA_OT_export(Job, bpy.types.Operator):
    """Write the occlusion as a file that other programs take as it is"""

    bl_idname, bl_label = "penumbra.export", "Export"
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    check_existing: bpy.props.BoolProperty(default=True, options={"HIDDEN"})
    kind: bpy.props.EnumProperty(name="As", items=KINDS)
    use_model: bpy.props.BoolProperty(name="Of the model", description="What the model says, not the bake")
    components: bpy.props.IntProperty(name="Components", default=16, min=0, description="Morph targets; 0: all")
    max_error: bpy.props.FloatProperty(
        name="Max error", min=0, max=1, precision=4, description="As few morph targets as keep this rms; 0: Components"
    )
    rate: bpy.props.FloatProperty(name="Rate", min=0, max=1000, description="Frames a second; 0: of the bake")
    clips: bpy.props.StringProperty(name="Clips", description="Names with commas between; empty: all")
    bounced: bpy.props.BoolProperty(name="Bounced", description="Light that bounces, too")
    bent: bpy.props.BoolProperty(name="Bent", description="Tables of bent normals, with occlusion as alpha")
    picked: bpy.props.BoolProperty(options={"HIDDEN", "SKIP_SAVE"})  # a file was chosen in the selector
    OPTIONS = ("components", "max_error", "rate", "clips", "bounced", "bent")
    selecting = False

    def invoke(self, context, event):
        if bpy.app.background or self.picked:
            return super().invoke(context, event)
        settings = self.chosen(context)
        try:
            if settings is None:
                return {"CANCELLED"}
            self.filepath = str(file_of(settings, self.ending()))
        except Failed as failed:
            self.report({"ERROR"}, str(failed))
            return {"CANCELLED"}
        self.character, self.selecting = settings.id_data.name, True
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        """Behind the file selector a job of its own begins, which runs between redraws."""
        if not self.selecting:
            return super().execute(context)
        words = {name: getattr(self, name) for name in ("character", "filepath", "kind", "use_model", *self.OPTIONS)}
        bpy.ops.penumbra.export("INVOKE_DEFAULT", picked=True, **words)
        return {"FINISHED"}

    def cancel(self, context):
        if not self.selecting:
            super().cancel(context)

    def ending(self):
        return (".model" if self.use_model else "") + ENDINGS[self.kind]

    def check(self, _context):
        """The name follows what is exported while the user chooses."""
        for ending in ENDINGS.values():
            stem = self.filepath.removesuffix(ending).removesuffix(".model")
            if self.filepath.endswith(ending) and self.filepath != stem + self.ending():
                self.filepath = stem + self.ending()
                return True
        return False

    def draw(self, _context):
        self.layout.use_property_split = True
        for name in ("kind", "use_model", *self.OPTIONS):
            if name not in ("components", "max_error") or self.kind == "play":
                self.layout.prop(self, name)

    def steps(self, context, settings):
        self.filepath = self.filepath or str(file_of(settings, self.ending()))
        words = {name: getattr(self, name) for name in self.OPTIONS}
        return self.export(context, settings, self.filepath, results.Of(model=self.use_model, **words))

    def export(self, context, settings, path, of):
        yield from results.export(context, settings, path, self.kind, of)
        say(settings, f"{path} is written")


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
        if self.wanted and not any(play.modifier_name(attribute) in thing.modifiers for thing in things):
            self.report({"ERROR"}, "compare first" if self.model else "bake first")
            return {"CANCELLED"}
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


HANDLERS = (bpy.app.handlers.undo_pre, bpy.app.handlers.redo_pre, bpy.app.handlers.load_pre)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    for handlers in HANDLERS:
        handlers.append(stop_job)


def unregister():
    for handlers in HANDLERS:
        handlers.remove(stop_job)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
