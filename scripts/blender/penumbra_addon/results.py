"""Steps after a result: the model beside the bake, and exports."""
import pathlib
from dataclasses import dataclass

import bpy
import numpy as np

from . import glb, play
from .members import members
from .preferences import programs
from .programs import Failed
from .routes import MODEL, TELL, attach_sources, attribute_of, check_counts, file_rows, frame_rate, occlusion, part


def compare(context, settings, report):
    """The model beside the bake: the attribute of the bake, and one of the model, in all frames of the bake."""
    tools, who, _ = programs(context), members(context.scene, settings.id_data), attribute_of(settings)
    if not settings.asset:
        raise Failed("make a run-time asset first")
    if settings.attached != settings.attribute:
        raise Failed(f"the run-time asset is shown in {settings.attached}: make it again for another attribute")
    for source in (settings.asset, settings.bake):
        yield from part(check_counts(tools, settings, pathlib.Path(source)), 0, 0.02)
    rig, rate = pathlib.Path(settings.rig), frame_rate(context.scene, settings.played[0].step)
    # Lengths of clips are floats: a millionth more keeps the last frame, which else lies behind the end.
    words = [rig, "--rate", f"{rate * (1 + 1e-6):.9g}"]
    model = yield from part(occlusion(tools, settings, pathlib.Path(settings.asset), *words), 0, 0.6)
    truth = yield from part(occlusion(tools, settings, pathlib.Path(settings.bake)), 0.6, 1.0)
    if model.shape != truth.shape:
        raise Failed(f"the model gives {model.shape[0]} frames of {model.shape[1]} vertices, the bake {truth.shape}")
    show_model(who, settings, rig, model)
    error = float(np.sqrt(np.mean((model.astype(np.float64) - truth) ** 2)))
    report(f"{settings.attribute + MODEL} shows the model; rms {error:.4f} from the bake")
    yield 1.0, "done"


def show_model(who, settings, rig, model):
    things = sorted(who.meshes + who.without, key=lambda thing: thing.name)
    trees = [thing.modifiers.get(play.modifier_name(settings.attribute)) for thing in things]
    if not all(trees):
        raise Failed("the meshes have changed since the run-time asset was made: make it again")
    counts = [modifier[play.input_names(modifier.node_group)["Vertices"]] for modifier in trees]
    of_source = glb.vertex_numbers(rig, [thing.name for thing in who.without])
    record = Played(settings.played, [thing.name for thing in things], np.array(counts))
    attach_sources(record, file_rows(record, rig, model), of_source, settings.attribute + MODEL)


class Played:
    """The part of a record that the .blend keeps: its clips, meshes and counts."""

    def __init__(self, clips, names, counts):
        self.spans = [PlayedSpan(c.name, c.first_frame, c.rows, c.step, c.first_row) for c in clips]
        self.names, self.counts = names, counts

    def rows_of(self, span):
        return span.first_row, span.first_row + span.count


class PlayedSpan:
    def __init__(self, name, first, count, step, first_row):
        self.name, self.first, self.count, self.step, self.first_row = name, first, count, step, first_row


def export(context, settings, output, kind, of):
    """`penumbra-pack export` of the last bake, or of the last model. `of`: an Of."""
    source = settings.asset if of.model else settings.bake
    if not source:
        raise Failed("make a run-time asset first" if of.model else "bake first")
    if kind in ("static", "play") and not settings.rig:
        raise Failed(f"{kind} goes into the .glb of a run-time asset: make one first, or export table or npy")
    tools, source = programs(context), pathlib.Path(source)
    yield from part(check_counts(tools, settings, source), 0, 0.05)
    words = [pathlib.Path(settings.rig)] if settings.rig else []
    words += [*of.words(kind), "-o", pathlib.Path(output), "--as", kind, *TELL]
    yield from part(tools.run("pack", "export", source, *words), 0.05, 1)


@dataclass
class Of:
    """Options of an export. Values that equal the program's defaults are not passed on."""

    model: bool = False  # the model and not the bake
    components: int = 16
    max_error: float = 0
    rate: float = 0
    clips: str = ""
    bounced: bool = False
    bent: bool = False

    def words(self, kind):
        found = []
        if kind == "play":
            exact = self.max_error > 0
            found += ["--max-error", f"{self.max_error:.9g}"] if exact else ["--components", self.components]
        if self.rate > 0:
            found += ["--rate", f"{self.rate:.9g}"]
        if self.clips.strip():
            found += ["--clips", ",".join(word.strip() for word in self.clips.split(",") if word.strip())]
        return found + ["--bounced"] * self.bounced + ["--bent"] * self.bent
