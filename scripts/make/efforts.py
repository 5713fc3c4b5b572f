"""The efforts of `--effort`: how much is baked, whether poses are chosen and how the pictures are drawn."""
from dataclasses import dataclass


@dataclass(frozen=True)
class Effort:
    fps: int             # samples a second of a clip, at most
    frames: int          # in the whole bake, about; longer files are sampled less often
    clips: int           # baked at most
    rays: int            # above the horizon of every vertex
    chooses_poses: bool  # whether trial fits choose poses beside the clips
    pictures: int        # held-out frames that the page shows
    size: int            # pixels a side
    samples: int         # shadow rays a pixel of the ray-traced pictures


PRECISION = "i8"
# docs/accuracy.md measures all composed models at these bytes. Meshes of fewer vertices are small anyway, and a bound
# would leave too little beside what does not depend on their number.
BYTES_PER_VERTEX, FEWEST_VERTICES = 260, 2000
EFFORTS = {
    "draft": Effort(fps=10, frames=48, clips=6, rays=128, chooses_poses=False, pictures=1, size=384, samples=64),
    "good": Effort(fps=15, frames=600, clips=1000, rays=256, chooses_poses=False, pictures=3, size=480, samples=256),
    "best": Effort(fps=15, frames=1500, clips=1000, rays=512, chooses_poses=True, pictures=3, size=600, samples=1024)}
