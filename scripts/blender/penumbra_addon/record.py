"""Records a character as Blender shows it in every frame: its vertices after all modifiers, its bones and its shape
keys."""
import contextlib
from dataclasses import dataclass, field

import bpy
import numpy as np

from .programs import Failed


@dataclass
class Span:
    """Frames that belong together: a piece of the timeline, or a clip."""

    name: str
    first: int
    count: int
    step: int = 1
    action: object = None  # None: what the timeline plays

    @property
    def frames(self):
        return range(self.first, self.first + self.count * self.step, self.step)


@dataclass
class Record:
    spans: list
    names: list  # names of the meshes
    counts: np.ndarray  # vertices of each mesh
    faces: np.ndarray  # int32 [T,3]
    points: np.ndarray  # f32 [F,V,3], y up, as glTF has it
    used: np.ndarray  # bool [V]: vertices that a face uses
    meshes: np.ndarray = None  # f64 [F,M,4,4]: world matrices of the meshes
    armature: np.ndarray = None  # f64 [F,4,4]
    bones: np.ndarray = None  # f64 [F,B,4,4]: in the armature's space, in the order of its data
    keys: list = field(default_factory=list)  # a dictionary for each mesh: f64 [F] of every shape key

    def rows_of(self, span):
        """Rows [first, end) of a span."""
        first = sum(s.count for s in self.spans[: self.spans.index(span)])
        return first, first + span.count


def spans_of(scene, character, settings):
    """The frames that the settings ask for."""
    if settings.frames == "CLIPS":
        return [span_of(action, settings.step) for action in clips_of(character, settings.clips)]
    own = settings.frames == "OWN"
    first, last = (settings.first, settings.last) if own else (scene.frame_start, scene.frame_end)
    if last < first:
        raise Failed(f"the last frame, {last}, is before the first, {first}")
    return [Span(scene.name, first, 1 + (last - first) // settings.step, settings.step)]


def clips_of(character, text):
    """The actions of these names, or all that move bones of the armature."""
    words = [word.strip() for word in text.split(",") if word.strip()]
    missing = [word for word in words if word not in bpy.data.actions]
    if missing:
        known = ", ".join(action.name for action in bpy.data.actions) or "none"
        raise Failed(f"there is no action '{missing[0]}'; there are: {known}")
    bones = {bone.name for bone in character.pose.bones} if character.type == "ARMATURE" else set()
    found = [bpy.data.actions[word] for word in words] or [a for a in bpy.data.actions if moves(a, bones)]
    if not found:
        raise Failed(f"no action moves {character.name}")
    return found


def moves(action, bones):
    paths = [curve.data_path for curve in action.fcurves]
    return any(path.startswith('pose.bones["') and path.split('"')[1] in bones for path in paths)


def span_of(action, step):
    first, last = (int(np.floor(value + 1e-3)) for value in action.frame_range)
    return Span(action.name, first, 1 + (last - first) // step, step, action)


def y_up(points):
    return np.stack([points[:, 0], points[:, 2], -points[:, 1]], -1)


def read_mesh(thing, depsgraph, faces=None):
    """World positions [V,3] of a mesh after its modifiers, y up, and its numbers of vertices and corners.

    Appends its triangles to `faces` where that is a list.
    """
    evaluated = thing.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    matrix = np.array(evaluated.matrix_world)
    size = len(mesh.vertices), len(mesh.loops)
    if faces is not None:
        mesh.calc_loop_triangles()
        triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        if np.linalg.det(matrix[:3, :3]) < 0:  # a mirrored object keeps its outside
            triangles = triangles.reshape(-1, 3)[:, ::-1]
        faces.append(triangles.reshape(-1, 3))
    evaluated.to_mesh_clear()
    return y_up(points.reshape(-1, 3).astype(np.float64) @ matrix[:3, :3].T + matrix[:3, 3]), size


class Recorder:
    """Collects frames. All of them have the vertices of the first."""

    def __init__(self, things, armature):
        self.things, self.armature = things, armature
        self.sizes, self.faces, self.rows = None, [], []
        self.matrices, self.armatures, self.bones = [], [], []
        self.keys = [{} for _ in things]

    def take(self, depsgraph, frame):
        first = self.sizes is None
        read = [read_mesh(thing, depsgraph, self.faces if first else None) for thing in self.things]
        sizes = [size for _, size in read]
        for thing, size, before in zip(self.things, sizes, self.sizes or sizes):
            if size != before:
                raise Failed(
                    f"{thing.name} has {size[0]} vertices in frame {frame}, and {before[0]} before: "
                    "a modifier changes the mesh"
                )
        self.sizes = self.sizes or sizes
        self.rows.append(np.concatenate([points for points, _ in read]).astype(np.float32))
        self.matrices.append([np.array(thing.evaluated_get(depsgraph).matrix_world) for thing in self.things])
        self.take_keys(depsgraph)
        if self.armature:
            pose = self.armature.evaluated_get(depsgraph)
            self.armatures.append(np.array(pose.matrix_world))
            self.bones.append([np.array(pose.pose.bones[bone.name].matrix) for bone in self.armature.data.bones])

    def take_keys(self, depsgraph):
        for thing, keys in zip(self.things, self.keys):
            shape = thing.evaluated_get(depsgraph).data.shape_keys or thing.data.shape_keys
            for block in shape.key_blocks[1:] if shape else ():
                keys.setdefault(block.name, []).append(block.value)

    def record(self, spans):
        counts = np.array([size[0] for size in self.sizes])
        firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        faces = np.concatenate([f + first for f, first in zip(self.faces, firsts)]) if self.faces else np.empty((0, 3))
        if not len(faces):
            raise Failed("there are no faces")
        used = np.zeros(counts.sum(), bool)
        used[faces] = True
        bones = np.array(self.bones) if self.armature else None
        return Record(
            spans, [t.name for t in self.things], counts, faces.astype(np.int32), np.array(self.rows), used,
            np.array(self.matrices), np.array(self.armatures) if self.armature else None, bones,
            [{name: np.array(values) for name, values in keys.items()} for keys in self.keys],
        )  # fmt: skip


def record_frames(context, who, things, spans):
    """Steps through the frames, giving (share, text) as it goes on; returns the Record. The scene is left as it was."""
    scene, recorder = context.scene, Recorder(things, who.armature)
    total, done, frame = sum(s.count for s in spans), 0, scene.frame_current
    before = Binding(who.armature, things)
    try:
        for span in spans:
            before.play(span.action)
            for number in span.frames:
                scene.frame_set(number)
                recorder.take(context.evaluated_depsgraph_get(), number)
                done += 1
                yield done / total, f"frame {number}"
    finally:
        with contextlib.suppress(ReferenceError):  # an object that was deleted meanwhile needs nothing back
            before.restore(lambda: scene.frame_set(frame))
    return recorder.record(spans)


CHANNELS = ("location", "rotation_quaternion", "rotation_euler", "rotation_axis_angle", "scale")


def values_of(holder):
    """The properties of an object or a posed bone that an action may write: its place, and its own numbers (switches of
    rigs)."""
    own = {key: value for key, value in holder.items() if isinstance(value, (int, float))}
    return {name: tuple(getattr(holder, name)) for name in CHANNELS}, own


def put_back(holder, values):
    places, own = values
    for name, value in places.items():
        if tuple(getattr(holder, name)) != value:
            setattr(holder, name, value)
    for key, value in own.items():
        if holder.get(key) != value:
            holder[key] = value


class Binding:
    """The action that an armature plays and the pose that it stands in, keyed or not, to be put back."""

    def __init__(self, armature, things=()):
        self.armature, self.changed = armature, False
        data = armature.animation_data if armature else None
        self.action, self.use_nla = (data.action, data.use_nla) if data else (None, None)
        self.slot = getattr(data, "action_slot", None)  # Blender 4.4 and later
        self.own = values_of(armature) if armature else None
        self.bones = {bone.name: values_of(bone) for bone in armature.pose.bones} if armature else {}
        shapes = [thing.data.shape_keys for thing in things if thing.data.shape_keys]
        self.shapes = [(shape, [block.value for block in shape.key_blocks]) for shape in shapes]

    def play(self, action):
        if action is None or self.armature is None:
            return
        data = self.armature.animation_data or self.armature.animation_data_create()
        self.changed, data.use_nla, data.action = True, False, action
        self.pose()  # resets bones that the last action moved and this one does not

    def pose(self):
        """Puts all bones and shape keys where they were."""
        if self.armature:
            put_back(self.armature, self.own)
        for name, values in self.bones.items():
            put_back(self.armature.pose.bones[name], values)
        for shape, values in self.shapes:
            for block, value in zip(shape.key_blocks, values):
                if block.value != value:
                    block.value = value

    def restore(self, go_back):
        """Puts everything back; `go_back` sets the frame, which poses what is keyed, and a pose without keys
        follows."""
        if self.changed:
            data = self.armature.animation_data
            data.action = self.action
            data.use_nla = True if self.use_nla is None else self.use_nla
            if self.slot:
                data.action_slot = self.slot
        go_back()
        self.pose()
