"""One file through penumbra-bake, with few rays: what it said, and where it put the vertices."""
import os
import pathlib
import resource
import subprocess

import h5py
import numpy as np

BYTES = 12 << 30  # memory for one bake


def limited():
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Bake:
    """`code`: the exit code, negative for a signal, None where it ran past `seconds`. `notes`: its lines of stderr.
    With code 0: `clips` (names), `clip`, `time` [F], `positions` [F, R, 3] of the source vertices."""

    def __init__(self, program, files, work, words, seconds):
        self.output = pathlib.Path(work) / "bake.vis.h5"
        self.output.unlink(missing_ok=True)
        command = [program, "visibility", *files, "--rays", "16", "--threads", "1", "--progress", "none", "-o",
                   self.output, *words]
        process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   text=True, errors="replace", preexec_fn=limited, cwd=work, start_new_session=True)
        try:
            _, text = process.communicate(timeout=seconds)
            self.code = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            _, text = process.communicate()
            self.code = None
        self.notes = [line.strip() for line in text.splitlines() if line.strip()]
        if self.code == 0:
            self.read()

    def read(self):
        with h5py.File(self.output) as file:
            self.clips = [name.decode() for name in file["clips/names"][:]]
            self.clip, self.time = file["frames/clip"][:].astype(int), file["frames/time"][:]
            self.source = file["mesh/source_vertex"][:]
            self.points = file["frames/positions"][:]
            self.triangles = file["mesh/triangles"][:]

    @property
    def positions(self):
        return self.points[:, self.source]

    def chosen(self, of_clip):
        """At most `of_clip` frames of each clip, the first and the last among them."""
        kept = []
        for clip in np.unique(self.clip):
            frames = np.flatnonzero(self.clip == clip)
            kept += list(frames[np.unique(np.linspace(0, len(frames) - 1, of_clip).astype(int))])
        return np.array(kept)
