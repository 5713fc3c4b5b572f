#!/usr/bin/python3
"""One page of a farm's results: every rig with its figures and pictures, every job with its time (no network, no scripts).

farm_index.py FARM.yaml -o index.html        run in the farm's output folder"""
import glob
import json
import os
import pathlib
import sys
import time
from html import escape
from urllib.parse import quote

sys.path.insert(0, os.path.dirname(os.path.realpath(__file__)))
from farm.config import ConfigError, exit_code, read_config
from farm.plan import make_plan, report_of
from farm.stamps import remove, write_whole
from usage import ArgumentParser

STYLE = """
:root { color-scheme: light dark; --paper: #fff; --ink: #1d2430; --soft: #5c6675; --line: #d9dee6; --link: #0b5cad; }
@media (prefers-color-scheme: dark) { :root { --paper: #12161c; --ink: #e4e9f0; --soft: #9aa6b6; --line: #2d3643; --link: #7db8f0; } }
body { margin: 0 auto; max-width: 1180px; padding: 24px; background: var(--paper); color: var(--ink);
  font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
a { color: var(--link); } h2 { margin-top: 2em; } p, caption { color: var(--soft); }
.scroll { overflow: auto; } img { max-width: 100%; height: auto; display: block; margin: 12px 0; }
table { border-collapse: collapse; font-size: .9rem; font-variant-numeric: tabular-nums; }
caption { text-align: left; padding: 8px 0; } th { color: var(--soft); }
th, td { padding: 4px 14px 4px 0; text-align: right; border-bottom: 1px solid var(--line); white-space: nowrap; }
th:first-child, td:first-child { text-align: left; } .bad { color: #c03a5b; }
"""
HEAD = """<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; style-src 'unsafe-inline'; img-src 'self' data: file:">
<link rel="icon" href="data:,">
"""


def read_report(output):
    """Returns the report of the job that made `output`, or nothing."""
    try:
        return json.loads(pathlib.Path(report_of(output)).read_text())
    except (OSError, ValueError):
        return {}


def link(path, text=None):
    return f'<a href="{quote(path)}">{escape(text or path)}</a>'


def number(value, digits=3):
    return "-" if value is None else f"{value:.{digits}f}"


def size(path):
    return f"{os.path.getsize(path) / 1e6:.2f}" if os.path.exists(path) else "-"


def table(caption, head, rows):
    cells = lambda tag, row: "".join(f"<{tag}>{cell}</{tag}>" for cell in row)
    body = "\n".join(f"<tr>{cells('td', row)}</tr>" for row in rows)
    return f'<div class="scroll"><table><caption>{caption}</caption>\n<thead><tr>{cells("th", head)}</tr></thead>\n' \
           f"<tbody>{body}</tbody></table></div>\n"


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
            rows.append([f'<a href="#{rig}">{rig}</a>', fit.get("train_frames", "-"), fit.get("held_out_frames", "-"),
                         fit.get("clusters", "-"), number(fit.get("train", {}).get("relative_error")),
                         number(held_out.get("relative_error")), number(held_out.get("ambient_error"), 4),
                         number(sum(pictures) / len(pictures), 1) if pictures else "-",
                         number(pack.get("model_bytes_per_vertex"), 0), size(f"{rig}/{rig}.pnb"),
                         number(self.seconds(self.jobs_of(rig)), 1)])
        return table("Errors of the packed asset; 1 is no better than a static bake. Pictures: against baked truth, in 8-bit steps.",
                     ["rig", "train frames", "held out", "clusters", "train error", "held-out error", "ambient error", "pictures",
                      "bytes a vertex", "asset MB", "job seconds"], rows)

    def clips_table(self, rig):
        rows = [[escape(clip["name"]), "held out" if clip["held_out"] else "training", clip["frames"],
                 number(clip["relative_error"]), number(clip["rms_v"], 4), number(clip["ambient_error"], 4)]
                for clip in self.figures(f"{rig}/check.json").get("clips", [])]
        return table("Clips", ["clip", "part", "frames", "relative error", "rms V", "ambient error"], rows)

    def jobs_table(self, caption, outputs):
        rows = []
        for output in outputs:
            report = self.reports[output]
            name = link(output) if os.path.exists(output) else escape(output) + " (not kept)"
            code = report.get("exit_code")
            state = "no report" if code is None else "done" if code == 0 else f'<span class="bad">failed, {code}</span>'
            rows.append([name, self.plan[output].rule, state, number(report.get("seconds"), 2),
                         number(report["peak_memory_bytes"] / 1e6, 0) if "peak_memory_bytes" in report else "-",
                         size(output), link(report_of(output), "report") if report else "-"])
        return table(caption, ["file", "job", "state", "seconds", "memory MB", "file MB", ""], rows)

    def rig_section(self, rig):
        sheet = f"{rig}/sheet.png"
        content = f'<section id="{rig}"><h2>{rig}</h2>\n<p>Source: ' + \
            ", ".join(escape(os.path.basename(f)) for f in self.farm.rigs[rig]["files"]) + "</p>\n" + self.clips_table(rig)
        if os.path.exists(sheet):
            content += f'<a href="{quote(sheet)}"><img src="{quote(sheet)}" alt="{rig}: truth, model and error of held-out ' \
                       'frames; materials under lights"></a>\n'
        return content + self.jobs_table("Jobs", self.jobs_of(rig)) + "</section>\n"

    def looks_section(self):
        shared = [output for output, job in self.plan.items() if job.rule in ("brdf", "light")]
        return '<section id="looks"><h2>Materials and lights</h2>\n' + self.jobs_table("Jobs", shared) + self.looks_errors() + \
            "</section>\n"

    def looks_errors(self):
        rows = [[name, number(self.figures(f"materials/{name}.brdf.h5").get("shading_d5"), 4),
                 number(self.figures(f"materials/{name}.brdf.h5").get("albedo_max"))] for name in self.farm.materials]
        return table("Materials: shading error against brute force (convention D5), largest albedo",
                     ["material", "shading error", "albedo"], rows)

    def html(self):
        title = f"Penumbra farm: {os.path.basename(self.farm.file)}"
        links = " · ".join(f'<a href="#{rig}">{rig}</a>' for rig in [*self.farm.rigs, "looks"])
        facts = f"{len(self.farm.rigs)} rigs, {len(self.farm.materials)} materials, {len(self.farm.lights)} lights; " \
                f"{len(self.reports)} jobs, {self.seconds(self.reports):.1f} seconds in all"
        return f'<!doctype html>\n<html lang="en"><head>\n{HEAD}<title>{escape(title)}</title>\n<style>{STYLE}</style></head>\n' \
               f"<body><header><h1>{escape(title)}</h1>\n<p>{facts}</p><nav>{links}</nav></header>\n<main>{self.rigs_table()}" + \
               "".join(self.rig_section(rig) for rig in self.farm.rigs) + self.looks_section() + "</main></body></html>\n"


def remove_vanished(plan):
    """Deletes reports and stamps of shards that no plan knows any more."""
    kept = {os.path.normpath(path) for output in plan for path in (report_of(output), output + ".stamp", output + ".d")}
    for path in [*glob.glob("reports/*.shards.*.vis.h5.json"), *glob.glob("*/shards/*.vis.h5.stamp"), *glob.glob("*/shards/*.vis.h5.d")]:
        if path not in kept:
            remove(path)


def main():
    parser = ArgumentParser(__doc__)
    parser.add_argument("farm")
    parser.add_argument("--report")
    parser.add_argument("-o", "--output", required=True)
    arguments = parser.parse_args()
    start = time.monotonic()
    try:
        page = Page(read_config(arguments.farm))
        remove_vanished(page.plan)
        text = page.html()
    except ConfigError as error:
        print(f"farm_index.py: {error}", file=sys.stderr)
        sys.exit(exit_code(error))
    write_whole(arguments.output, text)
    if arguments.report:
        write_whole(arguments.report, json.dumps({"schema": "penumbra.report", "schema_version": 1, "tool": "farm_index.py",
                    "verb": "index", "exit_code": 0, "output": arguments.output, "seconds": time.monotonic() - start}))


if __name__ == "__main__":
    main()
