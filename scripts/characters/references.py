"""Readers that are not Penumbra's: where three.js, ufbx and Blender put the vertices of a file."""
import json
import pathlib
import subprocess

import numpy as np

import gltf_features

HERE = pathlib.Path(__file__).resolve().parent
BAD_FILE = (ValueError, KeyError, TypeError, AttributeError, IndexError, OSError, RuntimeError,
            subprocess.SubprocessError)


def run(command, seconds=300):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, errors="replace",
                          timeout=seconds)
    if done.returncode:
        lines = [line.strip() for line in (done.stderr + done.stdout).splitlines()]
        lines = [line for line in lines if "Error: " in line and "script failed" not in line] or lines[-1:] or [""]
        raise RuntimeError(lines[0][-200:])
    return done.stdout


def diagonal(points):
    return float(np.linalg.norm(np.nanmax(points, 0) - np.nanmin(points, 0)))


class Three:
    """glTF by three.js: vertex by vertex."""
    name, bound, rate = "three.js", 1e-5, None

    def __init__(self, file, modules, work):
        if not (modules / "three").is_dir():
            raise SystemExit(f"check_characters: {modules}: has no package three (scripts/characters/get_characters)")
        self.file, self.modules, self.work = file, modules, work

    def call(self, asked):
        request, self.out = self.work / "request.json", self.work / "three.bin"
        request.write_text(json.dumps(asked))
        text = run(["node", HERE / "three_positions.mjs", self.modules, self.file, request, self.out])
        return json.loads(text.splitlines()[-1])

    def clips(self):
        seconds = [length for _, length in self.call([])["clips"]]
        return list(zip(gltf_features.clip_names(gltf_features.read_json(self.file)), seconds))

    def places(self, asked):
        """Returns for each asked (clip, seconds) the positions [vertices, 3], NaN where glTF does not say or nothing is
        drawn."""
        header = self.call(asked)
        theirs = np.fromfile(self.out, "<f8").reshape(len(asked), header["vertices"], 3)
        size = max(map(diagonal, theirs))
        if not header["three_apart"] <= 1e-6 * size:
            raise RuntimeError(f"its own sums differ by {header['three_apart'] / size:.1e} of the diagonal")
        return theirs

    def apart(self, asked, bake, frames):
        """(distance in diagonals, text): the worst vertex of all asked frames."""
        theirs = self.places(asked)
        count, size = theirs.shape[1], max(map(diagonal, theirs))
        if count != len(bake.source):
            return np.inf, f"{len(bake.source)} vertices, {self.name} has {count}"
        worst = (0.0, "")
        for (clip, seconds), frame, points in zip(asked, bake.points[frames], theirs):
            stated = ~np.isnan(points[:, 0])
            apart = np.linalg.norm(frame[bake.source[stated]] - points[stated], axis=1) / size
            if not apart.max() <= worst[0]:
                at = np.flatnonzero(stated)[apart.argmax()]
                worst = (float(apart.max()), f"vertex {at} of clip {clip} at {seconds:.3f} s, "
                         f"{100 * np.mean(~(apart <= self.bound)):.0f}% of the vertices")
        return worst


def farthest(points, others):
    """The largest distance of a point to the nearest of the others; of many points, 3,000 are looked at."""
    points = points[np.unique(np.linspace(0, len(points) - 1, 3000).astype(int))]
    middle = others.mean(0)
    points, others = points - middle, others - middle
    squares, most = (others**2).sum(1), 0.0
    for part in np.array_split(points, max(1, len(points) * len(others) // 10_000_000)):
        most = max(most, ((squares - 2 * part @ others.T).min(1) + (part**2).sum(1)).max())
    return float(np.sqrt(max(most, 0)))


class Cloud:
    """A reader with vertices of its own order: the distance of two sets of points, both ways. `rate`: of the frames at
    which the file was made; between them, curves that were baked are not those of the file."""
    bound, rate = 1e-3, None

    def apart(self, asked, bake, frames):
        theirs = self.places(asked)
        used = np.unique(bake.triangles)
        size = max(diagonal(points) for points in theirs)
        worst = (0.0, "")
        for (clip, seconds), frame, points in zip(asked, bake.points[frames], theirs):
            ours = frame[used].astype(float)
            apart = max(farthest(points, ours), farthest(ours, points)) / size
            if not apart <= worst[0]:
                worst = (apart, f"clip {clip} at {seconds:.3f} s")
        return worst


class Ufbx(Cloud):
    name = "ufbx"

    def __init__(self, file, source, work):
        self.file, self.work, self.program = file, work, work / "ufbx_positions"
        if not self.program.exists():
            run(["cc", "-O1", "-w", f"-I{source}", HERE / "ufbx_positions.c", source / "ufbx.c", "-lm", "-o",
                 self.program])

    def call(self, asked):
        request, out = self.work / "request.txt", self.work / "ufbx.bin"
        request.write_text("".join(f"{clip} {seconds!r}\n" for clip, seconds in asked))
        return json.loads(run([self.program, self.file, request, out])), out

    def clips(self):
        header = self.call([])[0]
        self.rate = header["rate"]
        return [tuple(clip) for clip in header["clips"]]

    def places(self, asked):
        header, out = self.call(asked)
        return np.fromfile(out, "<f8").reshape(len(asked), header["points"], 3)


class Blender(Cloud):
    name = "Blender"

    def __init__(self, file, program, work):
        self.file, self.work, self.program = file, work, program

    def call(self, asked):
        request, out = self.work / "request.json", self.work / "blender.npz"
        request.write_text(json.dumps(asked))
        run([self.program, "-b", "--factory-startup", "--python-exit-code", "9", "-P", HERE / "blender_positions.py",
             "--", self.file, request, out])
        return np.load(out)

    def clips(self):
        if b"<animation_clip" in pathlib.Path(self.file).read_bytes():
            raise BAD_FILE[0]("it joins the clips of a file")
        found = self.call([])
        return [("clip0", float(found["seconds"]))] if found["seconds"] > 0 else []

    def places(self, asked):
        found = self.call(asked)
        return [found[f"frame{k}"] for k in range(len(asked))]


def moves(reader, clip, seconds):
    """Does a clip of a reader move any vertex?"""
    still, *posed = reader.places([[clip, seconds * k / 4] for k in range(5)])
    rest = reader.places([[-1, 0.0]])[0]
    return any(np.nanmax(np.abs(points - rest)) > 1e-6 * diagonal(rest) for points in (still, *posed))


def reader_of(file, arguments, work):
    """The reader of a file's kind, or None where there is none here."""
    kind = file.suffix.lower()
    if kind in (".glb", ".gltf", ".vrm"):
        return Three(file, arguments.three, work)
    if kind == ".fbx" and arguments.ufbx:
        return Ufbx(file, arguments.ufbx.resolve(), work)
    if kind == ".dae" and arguments.blender:
        return Blender(file, arguments.blender, work)
    return None
