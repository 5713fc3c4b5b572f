"""Settings and results, which Blender saves in the .blend: one group on every object and on every collection."""
import bpy

ROLES = (
    ("AUTO", "By itself", "Belongs to the character that moves it: through an armature modifier or as a child"),
    ("CHARACTER", "Part", "Belongs to the character"),
    ("OCCLUDER", "Occluder", "Casts on the character, and gets no occlusion itself"),
    ("WITHOUT", "Left out", "Neither casts nor gets any. The file for engines still shows it"),
)
RAYS = {"DRAFT": 64, "GOOD": 256, "FINE": 1024}


class PenumbraLine(bpy.types.PropertyGroup):
    """One line of the last run, shown in the panel."""

    text: bpy.props.StringProperty()
    problem: bpy.props.BoolProperty()


class PenumbraClip(bpy.types.PropertyGroup):
    """Rows of the result that belong to a clip, and the frame at which it begins. Its name is that of the clip."""

    first_row: bpy.props.IntProperty()
    rows: bpy.props.IntProperty()
    first_frame: bpy.props.IntProperty()
    step: bpy.props.IntProperty()


class PenumbraCollection(bpy.types.PropertyGroup):
    role: bpy.props.EnumProperty(name="Role", items=ROLES, description="Of all objects in this collection")


class PenumbraSettings(bpy.types.PropertyGroup):
    role: bpy.props.EnumProperty(name="Role", items=ROLES)
    frames: bpy.props.EnumProperty(
        name="Frames",
        items=(
            ("SCENE", "Scene", "The frame range of the scene"),
            ("OWN", "Range", "A range of its own"),
            ("CLIPS", "Clips", "Actions by name, one after the other"),
        ),
    )
    first: bpy.props.IntProperty(name="First", default=1)
    last: bpy.props.IntProperty(name="Last", default=250)
    step: bpy.props.IntProperty(name="Step", default=1, min=1, description="Frames between, which are interpolated")
    clips: bpy.props.StringProperty(name="Clips", description="Names of actions with commas between; empty: all of them")
    quality: bpy.props.EnumProperty(
        name="Quality",
        default="GOOD",
        items=(
            ("DRAFT", "Draft", "64 rays a vertex"),
            ("GOOD", "Good", "256 rays a vertex"),
            ("FINE", "Fine", "1024 rays a vertex"),
            ("OWN", "Rays", "As many as you say"),
        ),
    )
    rays: bpy.props.IntProperty(name="Rays", default=256, min=16, max=65536)
    ground: bpy.props.BoolProperty(name="Ground", description="An endless floor blocks every direction that points down")
    ground_height: bpy.props.FloatProperty(name="Height", unit="LENGTH")
    distance: bpy.props.FloatProperty(
        name="Distance", min=0, unit="LENGTH", description="How far occluders count; 0: all count"
    )
    attribute: bpy.props.StringProperty(name="Attribute", default="penumbra_ao", maxlen=40, description="Where the result is")
    attached: bpy.props.StringProperty(description="Attribute of the last run")
    frame_count: bpy.props.IntProperty(description="Frames of the last run's file")
    vertex_count: bpy.props.IntProperty(description="Vertices of the last run's file")
    folder: bpy.props.StringProperty(name="Folder", default="//penumbra", subtype="DIR_PATH", description="Of the files")
    light: bpy.props.StringProperty(
        name="Light", subtype="FILE_PATH", description="Picture of the asset's light; empty: a plain sky"
    )
    source: bpy.props.EnumProperty(
        name="Show, export",
        items=(("BAKE", "Bake", "Show and export the bake"), ("MODEL", "Model", "Show and export what the model says")),
    )
    lines: bpy.props.CollectionProperty(type=PenumbraLine)
    played: bpy.props.CollectionProperty(type=PenumbraClip)
    pose_error: bpy.props.FloatProperty(description="Of the exported file's vertices, in diagonals")
    bake: bpy.props.StringProperty(description="Bake of the last run, X.vis.h5")
    asset: bpy.props.StringProperty(description="Run-time asset of the last run, X.pnb")
    rig: bpy.props.StringProperty(description="Exported character of the last run, X.glb")


def ray_count(settings):
    return RAYS.get(settings.quality, settings.rays)


class PenumbraJob(bpy.types.PropertyGroup):
    """The running job. It stands in the window manager, which no file saves."""

    running: bpy.props.BoolProperty()
    cancel: bpy.props.BoolProperty()
    share: bpy.props.FloatProperty(min=0, max=1, subtype="FACTOR", name="Done")
    status: bpy.props.StringProperty()


CLASSES = (PenumbraLine, PenumbraClip, PenumbraCollection, PenumbraSettings, PenumbraJob)


def may_be_character(_scene, thing):
    return thing.type in ("ARMATURE", "MESH")


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.penumbra = bpy.props.PointerProperty(type=PenumbraSettings)
    bpy.types.Collection.penumbra = bpy.props.PointerProperty(type=PenumbraCollection)
    bpy.types.WindowManager.penumbra = bpy.props.PointerProperty(type=PenumbraJob)
    bpy.types.Scene.penumbra_character = bpy.props.PointerProperty(
        type=bpy.types.Object, poll=may_be_character, name="Character", description="Armature, or mesh without one"
    )


def unregister():
    del bpy.types.Scene.penumbra_character, bpy.types.WindowManager.penumbra
    del bpy.types.Collection.penumbra, bpy.types.Object.penumbra
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
