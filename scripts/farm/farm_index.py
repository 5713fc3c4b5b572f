#!/usr/bin/python3
"""Makes one page of a farm's results: every rig with its figures and pictures, every job with its time.

The page needs no network and no scripts.

farm_index.py PENUMBRA-FIT FARM.yaml -o index.html        run in the farm's output folder

`penumbra-fit page` writes the HTML; this script says what stands on the page."""
import glob
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time
from urllib.parse import quote

sys.path.insert(0, os.path.dirname(os.path.dirname(os.path.realpath(__file__))))
from farm.config import read_config
from farm.ending import end_with
from farm.plan import make_plan, report_of
from farm.stamps import remove, write_whole
from usage import ArgumentParser


def read_report(output):
    """Returns the report of the job that made `output`, or nothing."""
    try:
        return json.loads(pathlib.Path(report_of(output)).read_text())
    except (OSError, ValueError):
        return {}


def link(path, text=None):
    return {"text": text or path, "link": quote(path)}


def number(value, digits=3):
    return "-" if value is None else f"{value:.{digits}f}"


def size(path):
    return f"{os.path.getsize(path) / 1e6:.2f}" if os.path.exists(path) else "-"


def table(caption, columns, rows):
    cells = [[cell if isinstance(cell, dict) else str(cell) for cell in row] for row in rows]
    return {"table": {"caption": caption, "columns": columns, "rows": cells}}


class Page:
    def __init__(self, farm):
        self.farm, self.plan = farm, make_plan(farm)
        self.reports = {output: read_report(output) for output, job in self.plan.items() if job.rule != "index"}

    def figures(self, output):
        return self.reports[output].get("figures", {})

    def jobs_of(self, rig):
        return [output for output, job in self.plan.items() if job.names.get("rig") == rig]

    def seconds(self, outputs):
        return sum(self.reports[o].get("seconds", 0) for o in outputs)

    def rigs_table(self):
        rows = []
        for rig in self.farm.rigs:
            fit, check, pack = (self.figures(f"{rig}/{name}") for name in (f"{rig}.model.h5", "check.json", f"{rig}.pnb"))
            held_out = check.get("held_out", {})
            pictures = [f["image_rmse"] for f in self.figures(f"{rig}/sheet.png").get("frames", []) if f["image_rmse"] is not None]
            rows.append([{"text": rig, "link": f"#{rig}"}, fit.get("train_frames", "-"), fit.get("held_out_frames", "-"),
                         fit.get("clusters", "-"), number(fit.get("train", {}).get("relative_error")),
                         number(held_out.get("relative_error")), number(held_out.get("ambient_error"), 4),
                         number(sum(pictures) / len(pictures), 1) if pictures else "-",
                         number(pack.get("model_bytes_per_vertex"), 0), size(f"{rig}/{rig}.pnb"),
                         number(self.seconds(self.jobs_of(rig)), 1)])
        return table("Errors of the packed asset; 1 is no better than a static bake. Pictures: against baked truth, in 8-bit steps.",
                     ["rig", "train frames", "held out", "clusters", "train error", "held-out error", "ambient error", "pictures",
                      "bytes a vertex", "asset MB", "job seconds"], rows)

    def clips_table(self, rig):
        rows = [[clip["name"], "held out" if clip["held_out"] else "training", clip["frames"],
                 number(clip["relative_error"]), number(clip["rms_v"], 4), number(clip["ambient_error"], 4)]
                for clip in self.figures(f"{rig}/check.json").get("clips", [])]
        return table("Clips", ["clip", "part", "frames", "relative error", "rms V", "ambient error"], rows)

    def jobs_table(self, caption, outputs):
        rows = []
        for output in outputs:
            report = self.reports[output]
            name = link(output) if os.path.exists(output) else output + " (not kept)"
            code = report.get("exit_code")
            state = "no report" if code is None else "done" if code == 0 else {"text": f"failed, {code}", "bad": True}
            rows.append([name, self.plan[output].rule, state, number(report.get("seconds"), 2),
                         number(report["peak_memory_bytes"] / 1e6, 0) if "peak_memory_bytes" in report else "-",
                         size(output), link(report_of(output), "report") if report else "-"])
        return table(caption, ["file", "job", "state", "seconds", "memory MB", "file MB", ""], rows)

    def rig_section(self, rig):
        sheet = f"{rig}/sheet.png"
        names = ", ".join(os.path.basename(file) for file in self.farm.rigs[rig]["files"])
        blocks = [{"paragraph": f"Source: {names}"}, self.clips_table(rig)]
        if os.path.exists(sheet):
            alt = f"{rig}: truth, model and error of held-out frames; materials under lights"
            blocks.append({"picture": {"file": quote(sheet), "alt": alt}})
        return {"id": rig, "title": rig, "blocks": [*blocks, self.jobs_table("Jobs", self.jobs_of(rig))]}

    def looks_section(self):
        shared = [output for output, job in self.plan.items() if job.rule in ("brdf", "light")]
        return {"id": "farm.looks", "title": "Materials and lights", "blocks": [self.jobs_table("Jobs", shared), self.looks_errors()]}

    def looks_errors(self):
        rows = [[name, number(self.figures(f"materials/{name}.brdf.h5").get("shading_d5"), 4),
                 number(self.figures(f"materials/{name}.brdf.h5").get("albedo_max"))] for name in self.farm.materials]
        return table("Materials: shading error against brute force (convention D5), largest albedo",
                     ["material", "shading error", "albedo"], rows)

    def description(self):
        """The page as penumbra.page JSON (formats/README.md). No rig's name has a dot, so no anchor stands twice."""
        facts = f"{len(self.farm.rigs)} rigs, {len(self.farm.materials)} materials, {len(self.farm.lights)} lights; " \
                f"{len(self.reports)} jobs, {self.seconds(self.reports):.1f} seconds in all"
        return {"schema": "penumbra.page", "schema_version": 1, "title": f"Penumbra farm: {os.path.basename(self.farm.file)}",
                "facts": [facts],
                "sections": [{"id": "farm.rigs", "title": "Rigs", "blocks": [self.rigs_table()]},
                             *(self.rig_section(rig) for rig in self.farm.rigs), self.looks_section()]}


def write_page(program, description, output):
    """The page whole, or none: penumbra-fit renames it into place. Its complaint and exit code become ours."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "page.json")
        with open(path, "w") as file:
            json.dump(description, file)
        done = subprocess.run([program, "page", path, "-q", "-o", output])
    if done.returncode != 0:
        sys.exit(done.returncode)


def remove_vanished(plan):
    """Deletes reports and stamps of shards that no plan knows any more, and the shards of clips that have changed."""
    kept = {os.path.normpath(path) for output in plan for path in (output, report_of(output), output + ".stamp", output + ".d")}
    gone = ["reports/*.shards.*.vis.h5.json", "reports/*.clips.*.vis.h5.json", "*/shards/*.vis.h5.stamp", "*/shards/*.vis.h5.d",
            "*/clips/*.vis.h5", "*/clips/*.vis.h5.stamp", "*/clips/*.vis.h5.d"]
    # A bake without a stamp is somebody else's.
    vanished = [path for pattern in gone for path in glob.glob(pattern)
                if path not in kept and (not path.endswith(".vis.h5") or os.path.exists(path + ".stamp"))]
    for path in vanished:
        remove(path)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("program")
    parser.add_argument("farm")
    parser.add_argument("--report")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    start = time.monotonic()
    page = Page(read_config(arguments.farm))
    remove_vanished(page.plan)
    write_page(arguments.program, page.description(), arguments.output)
    if arguments.report:
        write_whole(arguments.report, json.dumps({"schema": "penumbra.report", "schema_version": 1, "tool": "farm_index.py",
                    "verb": "index", "exit_code": 0, "output": arguments.output, "seconds": time.monotonic() - start}))


if __name__ == "__main__":
    end_with(main)
