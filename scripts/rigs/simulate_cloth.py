"""Simulates a cloth in Blender and writes it as a point cache: blender -b --python simulate_cloth.py -- ARGUMENTS

usage: blender -b --factory-startup --python scripts/rigs/simulate_cloth.py -- flag    -o FLAG.npz    [--take N] [--frames N]
       blender -b --factory-startup --python scripts/rigs/simulate_cloth.py -- curtain -o CURTAIN.npz [--take N] [--frames N]

Runs inside of Blender (3.4 or later; `scripts/setup --blender` installs it), about half a second a frame on one core.
`flag` is pinned at one edge in a wind that turns and swells. `curtain` hangs by its gathered upper edge, and a ball
goes through it. --take seeds the wind or the path of the ball, so that every take is another motion of the same cloth.
The files have the keys of formats/README.md, "Point caches that bakes read", with z up; scripts/rigs/cloth_ball makes the
curtain's occluder and inputs.
"""
import math
import pathlib
import random
import sys

import numpy as np

try:
    import bpy
except ModuleNotFoundError:  # outside of Blender
    bpy = None

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
from usage import ArgumentParser  # noqa: E402

FPS = 30
WARM_UP = 15  # frames before the first that is written: the cloth falls from where it was made
VERTEX_MASS = 0.15  # kg. A wind pushes faces and not vertices, so its strength must be as large as flag() has it.


def sheet(name, columns, rows, place):
    """Adds a grid of quads; place(u, v) with u and v in 0..1 gives its points."""
    points = [place(u / (columns - 1), v / (rows - 1)) for v in range(rows) for u in range(columns)]
    corner = [v * columns + u for v in range(rows - 1) for u in range(columns - 1)]
    quads = [(a, a + 1, a + 1 + columns, a + columns) for a in corner]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], quads)
    thing = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def make_cloth(thing, pinned, bending, collides):
    group = thing.vertex_groups.new(name="pinned")
    group.add(pinned, 1.0, "REPLACE")
    cloth = thing.modifiers.new("cloth", "CLOTH")
    settings = cloth.settings
    settings.quality, settings.mass, settings.air_damping = 5, VERTEX_MASS, 1.0
    settings.tension_stiffness = settings.compression_stiffness = 20
    settings.shear_stiffness, settings.bending_stiffness = 10, bending
    settings.vertex_group_mass = group.name
    collisions = cloth.collision_settings
    collisions.use_self_collision, collisions.self_distance_min = collides, 0.008
    collisions.collision_quality, collisions.distance_min = 2, 0.012
    return cloth


def key(thing, frame, **values):
    for name, value in values.items():
        setattr(thing, name, value)
        thing.keyframe_insert(name, frame=frame)


def flag(chance, last):
    """A flag of 1.5 x 1 m that is pinned at its left edge. It may pass through itself."""
    columns, rows = 57, 37
    thing = sheet("flag", columns, rows, lambda u, v: (1.5 * u, 0.02 * math.sin(9 * u), v))
    cloth = make_cloth(thing, [v * columns for v in range(rows)], 0.3, False)
    bpy.ops.object.effector_add(type="WIND", location=(-1, 0, 0.5))
    wind = bpy.context.object
    bpy.ops.object.effector_add(type="TURBULENCE", location=(0, 0, 0))
    gusts = bpy.context.object
    gusts.field.size, gusts.field.strength, gusts.field.seed = 0.6, 4e4, chance.randrange(100)
    wind.field.noise, wind.field.seed = 2, chance.randrange(100)
    for frame in range(1, last + 40, 40):
        # The wind blows along z of its object: +x, turned by up to 40 degrees about z.
        key(wind, frame, rotation_euler=(0, math.pi / 2, math.radians(chance.uniform(-40, 40))))
        wind.field.strength = chance.uniform(6e4, 2e5)
        wind.field.keyframe_insert("strength", frame=frame)
    return thing, cloth, None


def curtain(chance, last):
    """A curtain of 1.6 x 1.6 m, gathered along its upper edge, and a ball that goes through it."""
    columns = rows = 43
    thing = sheet("curtain", columns, rows,
                  lambda u, v: (1.6 * u - 0.8, 0.06 * math.sin(10 * math.pi * u) * (0.3 + 0.7 * v), 1.6 * v))
    cloth = make_cloth(thing, [(rows - 1) * columns + u for u in range(0, columns, 3)], 0.5, True)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=36, ring_count=20, radius=0.22)
    ball = bpy.context.object
    ball.modifiers.new("collision", "COLLISION")
    ball.collision.thickness_outer, ball.collision.cloth_friction = 0.012, 3
    key(ball, 1, location=(0, 0.6, 0.6))
    key(ball, WARM_UP, location=(0, 0.6, 0.6))
    side = 1
    for frame in range(WARM_UP + 30, last + 30, 30):
        side = side if chance.random() < 0.25 else -side
        along, away, height = chance.uniform(-0.6, 0.6), chance.uniform(0.15, 0.5), chance.uniform(0.2, 1.1)
        key(ball, frame, location=(along, side * away, height))
    return thing, cloth, ball


def positions(thing):
    """The points of an object in the world, with its modifiers."""
    graph = bpy.context.evaluated_depsgraph_get()
    shown = thing.evaluated_get(graph)
    mesh = shown.to_mesh()
    points = np.empty(3 * len(mesh.vertices))
    mesh.vertices.foreach_get("co", points)
    shown.to_mesh_clear()
    world = np.array(shown.matrix_world)
    return points.reshape(-1, 3) @ world[:3, :3].T + world[:3, 3]


def triangles(mesh):
    return [(p[0], p[i], p[i + 1]) for p in (tuple(q.vertices) for q in mesh.polygons) for i in range(1, len(p) - 1)]


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("cloth", choices=["flag", "curtain"])
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--take", type=int, default=1)
    parser.add_argument("--frames", type=int, default=100)
    words = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:])
    if bpy is None:
        parser.error("runs inside of Blender: blender -b --factory-startup --python simulate_cloth.py -- ...")
    scene = bpy.context.scene
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene.render.fps, last = FPS, WARM_UP + words.frames
    make = {"flag": flag, "curtain": curtain}[words.cloth]
    thing, cloth, ball = make(random.Random(words.take), last)
    scene.frame_end = cloth.point_cache.frame_end = last
    rest = positions(thing)
    frames, centers = [], []
    for frame in range(1, last + 1):
        scene.frame_set(frame)
        if frame > WARM_UP:
            frames.append(positions(thing))
            centers.append(np.array(ball.matrix_world.translation) if ball else np.zeros(3))
    arrays = dict(verts=np.array(frames, "f4"), faces=np.array(triangles(thing.data), "i4"), rest=rest.astype("f4"),
                  fps=np.float32(FPS))
    if ball:
        scene.frame_set(1)
        arrays.update(ball_verts=(positions(ball) - np.array(ball.matrix_world.translation)).astype("f4"),
                      ball_faces=np.array(triangles(ball.data), "i4"), ball_center=np.array(centers, "f4"))
    np.savez(words.output, **arrays)


main()
