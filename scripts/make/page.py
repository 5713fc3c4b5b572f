"""The page that `penumbra make` ends with: what it shows, and how it becomes one file."""
import base64
import html
import json
import os
import re

from farm.plan import report_of
from farm.stamps import write_whole

WARNING = re.compile(r"^penumbra-\w+: warning: (.*)$", re.M)
ERRORS = ("1 is no better than a static bake. The ambient error is that of the open share of the sky, from 0 to 1: its mean, "
          "what 99.9% of points stay below, and the largest.")


def number(value, digits=3):
    return "-" if value is None else f"{value:.{digits}f}"


def table(caption, columns, rows):
    return {"table": {"caption": caption, "columns": columns, "rows": rows}}


def read(folder, path):
    """Returns the text of a file, or "" where there is none."""
    try:
        with open(os.path.join(folder, path)) as file:
            return file.read()
    except OSError:
        return ""


def report(folder, job):
    try:
        return json.loads(read(folder, report_of(job.output)))
    except ValueError:
        return {}


def pictures_table(plan):
    """Links to the pictures, which embed() turns into the pictures themselves."""
    rows = []
    for number_, (clip, at, _) in enumerate(plan.frames):
        cell = lambda kind: {"text": f"{clip}, frame {at}: {kind}", "link": f"pictures/{number_}_{kind}.png"}
        rows.append([cell("truth"), cell("model"), cell("error")])
    kind = "held out: no model saw them" if plan.planner.farm.rigs[plan.rig]["holdout"] else "that the model was trained on"
    return table(f"Frames {kind}. The error is of the open share of the sky: dark blue is none, yellow 0.25 and more.",
                 ["ray traced", "the asset", "error"], rows)


def clips_table(figures):
    rows = [[clip["name"], "held out" if clip["held_out"] else "training", str(clip["frames"]), number(clip["relative_error"]),
             number(clip["ambient_error"], 4), number(clip.get("ambient_error_p999")), number(clip.get("ambient_error_max"))]
            for clip in [*sorted(figures.get("clips", []), key=lambda clip: not clip["held_out"]), figures.get("held_out"),
                         figures.get("training")] if clip and clip.get("frames")]
    return table("Relative error: " + ERRORS,
                 ["clip", "part", "frames", "relative error", "ambient error", "99.9%", "largest"], rows)


def sizes_table(figures):
    sizes = figures.get("bytes", {})
    vertices = sizes.get("file", 0) / figures["file_bytes_per_vertex"] if figures.get("file_bytes_per_vertex") else None
    rows = [[name, str(size), number(size / vertices, 1) if vertices else "-"] for name, size in sizes.items() if size]
    return table("Bytes of the asset", ["part", "bytes", "bytes a vertex"], rows)


def times_table(jobs, reports):
    rows = [[job.rule, job.output, number(reports[job.output].get("seconds"), 1),
             number(reports[job.output].get("peak_memory_bytes", 0) / 1e6, 0)] for job in jobs]
    rows.append(["all", "", number(sum(made.get("seconds", 0) for made in reports.values()), 1), "-"])
    return table("Jobs", ["job", "file", "seconds", "memory MB"], rows)


def warnings(folder, runner, jobs):
    """Returns what the programs warned of, each sentence once."""
    return list(dict.fromkeys(text for job in jobs for text in WARNING.findall(read(folder, runner.log_of(job.output)))))


def describe(plan, runner, jobs, request):
    """Returns the page as penumbra.page JSON (formats/README.md), and what was warned of."""
    folder, by_rule = runner.folder, {job.rule: job for job in jobs}
    reports = {job.output: report(folder, job) for job in jobs}
    figures = lambda rule: reports[by_rule[rule].output].get("figures", {})
    warned = warnings(folder, runner, jobs)
    rig = plan.planner.farm.rigs[plan.rig]
    nothing = "nothing, as asked" if request.holdout == [] else "nothing, as there is too little to hold out"
    held = ", ".join(rig["holdout"]) or nothing
    facts = [f"Made of {', '.join(os.path.basename(path) for path in request.files)} by penumbra make --effort {request.effort}.",
             f"Held out to measure the asset on: {held}.", *plan.facts]
    held_out = figures("check").get("held_out", {})
    if held_out.get("frames"):
        facts.append(f"On held-out frames the relative error is {number(held_out['relative_error'])}, the mean ambient error "
                     f"{number(held_out['ambient_error'], 4)}.")
    name = os.path.basename(request.output)
    section = lambda id_, title, *blocks: {"id": id_, "title": title, "blocks": list(blocks)}
    paragraph = lambda text: {"paragraph": text}
    sections = [
        section("pictures", "Pictures", pictures_table(plan)), section("errors", "Errors", clips_table(figures("check"))),
        section("warnings", "What was not honoured", *map(paragraph, warned or ["The programs had nothing to warn of."])),
        section("sizes", "Sizes", sizes_table(figures("pack"))), section("times", "Times", times_table(jobs, reports)),
        section("next", "Where next", paragraph(f"penumbra view {name} shows the asset in a window, penumbra render {name} -o "
                                                f"picture.png draws it, penumbra info {name} tells what is in it."))]
    return {"schema": "penumbra.page", "schema_version": 1, "title": os.path.splitext(name)[0], "facts": facts,
            "sections": sections}, warned


def embed(text, folder):
    """Returns the page with each link to a picture replaced by the picture."""
    def picture(found):
        with open(os.path.join(folder, html.unescape(found[1])), "rb") as file:
            data = base64.b64encode(file.read()).decode()
        return f'<img src="data:image/png;base64,{data}" alt="{found[2]}">{found[2]}'
    whole = "<style>.scroll:has(img) { max-height: none; }</style></head>"  # tables of figures scroll, pictures do not
    return re.sub(r'<a href="(pictures/[^"]+\.png)">([^<]*)</a>', picture, text.replace("</head>", whole, 1))


def write_if_new(path, content):
    """Writes a text file unless it has this content already."""
    try:
        with open(path) as file:
            if file.read() == content:
                return
    except (OSError, ValueError):
        pass
    write_whole(path, content)
