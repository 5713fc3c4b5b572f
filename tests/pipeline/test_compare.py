"""penumbra-fit compare as a user runs it: JSON, CSV and the page agree, and the page is whole in headless Chromium."""
import csv
import json
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile

import processor_time
from ribbon_bake import bake_file

BIN = pathlib.Path(sys.argv[1])
PLOTS = """models-error models-ambient clusters-held-out clusters-train variance-train variance-held-out
vectors-held-out vectors-train joint cosine-error cosine-product cosine-ambient frames-error frames-bytes normal-tables
conventions-error conventions-ambient eigenvalues-inputs eigenvalues-outputs cost-bytes cost-fit cost-evaluate""".split()

# This is added to a copy of the page, and tells what was laid out, and every error.
PROBE = """<script>
const errors = [];
addEventListener('error', e => errors.push(String(e.message || e.target)), true);
addEventListener('load', () => {
  const plots = [...document.querySelectorAll('svg.plot')].map(svg => {
    const box = svg.getBoundingClientRect();
    const marks = [...svg.querySelectorAll('.series > *:not(.line):not(text)')].map(m => m.getBBox());
    const lines = [...svg.querySelectorAll('.series > .line')].map(l => l.getTotalLength());
    return {id: svg.id, width: box.width, height: box.height, lines,
            marks: marks.map(b => [b.x, b.y, b.width, b.height])};
  });
  const probe = document.createElement('pre');
  probe.id = 'probe';
  probe.textContent = JSON.stringify({errors, plots, links: [...document.querySelectorAll('nav a')].map(
      a => [a.getAttribute('href'), document.querySelectorAll(a.getAttribute('href')).length])});
  document.body.append(probe);
});
</script>"""


def run(*arguments, code=0, says=""):
    done = subprocess.run([BIN / "penumbra-fit", "compare", *map(str, arguments)], capture_output=True, text=True)
    message = f"{' '.join(map(str, arguments))}\n{done.stdout}{done.stderr}"
    assert done.returncode == code, f"exit code {done.returncode}, not {code}: {message}"
    assert says in done.stdout + done.stderr, f"'{says}' not in: {message}"
    return done.stdout


def browse(page, *options):
    """Returns the DOM after loading, and the console's messages."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    assert chromium, "chromium is not installed (scripts/setup installs it)"
    with tempfile.TemporaryDirectory() as profile:
        done = subprocess.run(
            [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
             "--disable-background-networking", "--disable-component-update", "--disable-sync",
             f"--user-data-dir={profile}", "--enable-logging=stderr", "--v=0", "--dump-dom", *options, page.as_uri()],
            capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def check_browser(folder, page, data):
    text = page.read_text()
    assert not re.search(r"https?://|<script|@import|url\(", text), "the page is not self-contained"
    _, console = browse(page)
    assert not console, console

    with_probe = folder / "probe.html"
    policy = re.search(r"<meta http-equiv=\"Content-Security-Policy\"[^>]*>", text).group(0)
    with_probe.write_text(text.replace(policy, PROBE))
    dom, console = browse(with_probe)
    assert not console, console
    probe = json.loads(re.search(r'<pre id="probe">(.*?)</pre>', dom, re.S).group(1).replace("&amp;", "&"))
    assert not probe["errors"], probe["errors"]
    assert probe["links"] and all(count == 1 for _, count in probe["links"]), probe["links"]
    laid_out = {plot["id"]: plot for plot in probe["plots"]}
    expected = {plot["id"]: plot for figure in data["figures"] for plot in figure["plots"]}
    assert list(laid_out) == list(expected) == ["plot-" + name for name in PLOTS], (list(laid_out), list(expected))
    for name, plot in laid_out.items():
        assert plot["width"] > 200 and plot["height"] > 100, plot
        points = [sum(y is not None for y in series["y"]) for series in expected[name]["series"]]
        # Every point is a mark, except on the long curves, which are lines alone.
        curves = name.startswith("plot-eigenvalues") or name == "plot-joint"
        assert points and min(points) > 0, (name, points)
        assert len(plot["marks"]) == sum(points) or curves and len(plot["lines"]) > 0, (name, points, plot)
        for x, y, width, height in plot["marks"]:
            assert 0 <= x and x + width <= 560 and 0 <= y and y + height <= 340 and width > 0, (name, x, y, width)
        assert all(length > 0 for length in plot["lines"]), plot

    # The checks above rest on this: a page with an error is seen as one.
    broken = folder / "broken.html"
    broken.write_text(text.replace(policy, PROBE).replace("</main>", "<script>nothing.there</script></main>"))
    dom, console = browse(broken)
    assert console and "ReferenceError" in dom, "an error on the page went unseen"


def check_compare(folder):
    bake, page = folder / "a.vis.h5", folder / "r.html"
    bake_file(bake)
    command = [bake, "--holdout", "clip1", "--clusters", "1,2,4", "--output-variances", "0.9,0.5", "--models", "linear",
               "--conventions", "A2,D3", "-o", page]
    run(*command, "--dry-run", says="16 fits")
    assert not page.exists()
    run(*command, "--threads", 2)
    data = json.loads((folder / "r.json").read_text())
    with open(folder / "r.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    vectors = [fit for fit in data["fits"] if "feature vector" in fit["model"]]
    assert len(rows) == len(data["fits"]) == 16 + len(vectors)
    assert [fit["prior"] for fit in vectors] == 6 * ["cross-validated", "none"], "two features, three degrees"
    for plain, free in zip(vectors[::2], vectors[1::2]):
        assert free["train_relative_error"] <= plain["train_relative_error"] + 1e-9, (plain, free)
    products = [fit["held_out_cosine_product_error"] for fit in data["fits"]]
    assert sum(product is not None for product in products) == 2, "of the fits of figure 8 in each kind of features"
    assert {"feature-vectors", "normal-tables"} <= {figure["id"] for figure in data["figures"]}
    for row, fit in zip(rows, data["fits"]):
        assert list(row) == list(fit)
        for name, value in fit.items():
            same = row[name] == (value or "") if value is None or isinstance(value, str) else float(row[name]) == value
            assert same, (name, row[name], value)
    joint = next(figure for figure in data["figures"] if figure["id"] == "joint")
    assert "tip" in joint["plots"][0]["title"], "only this joint turns"
    check_browser(folder, page, data)
    return command, data


def without_times(data):
    """The cost figure is about time. In the rest only the fits' own times differ between runs."""
    fits = [{k: v for k, v in fit.items() if k not in ("fit_seconds", "evaluate_milliseconds")} for fit in data["fits"]]
    return fits, [figure for figure in data["figures"] if figure["id"] != "cost"], data["provenance"]


def check_same_for_any_thread_count(folder, command, data):
    for threads in (1, 3):
        run(*command, "--threads", threads, "-q")
        assert without_times(json.loads((folder / "r.json").read_text())) == without_times(data), threads


def check_cloth(folder):
    """Cloth has both kinds of features, and a figure of every model but none of a joint. Features of joint angles are
    refused."""
    bake, page = folder / "c.vis.h5", folder / "c.html"
    sheet = BIN / ".." / "samples" / "sheet.npz"
    subprocess.run([BIN / "penumbra-bake", "visibility", sheet, "--two-sided", "--rays", "32", "--order", "3", "--blocks", "3",
                    "-q", "-o", bake], check=True)
    command = [bake, "--holdout", "sheet#3", "--clusters", "2,4", "--output-variances", "0.9", "--models", "linear,additive",
               "--conventions", "A3"]
    run(*command, "--features", "joint-angles", "-o", page, code=1, says="has no skeleton")
    run(*command, "-o", page, "--threads", 2)
    data = json.loads((folder / "c.json").read_text())
    fits = data["fits"]
    assert {fit["features"] for fit in fits} == {"relative-bones", "dihedral-angles"}, fits
    for fit in fits:
        if "feature vector" in fit["model"]:
            assert 0 < fit["train_relative_error"] < 1 and fit["held_out_relative_error"] > 0, fit
            continue
        if fit["prior"] == "none":  # it reproduces training frames, and may be anything between them
            assert fit["held_out_relative_error"] > 0 and fit["cross_validated_relative_error"] is None, fit
            kind = {key: fit[key] for key in ("model", "features", "clusters", "output_variance", "convention", "clamped")}
            plain = next(other for other in fits if other["prior"] != "none" and kind.items() <= other.items())
            assert 0 < fit["train_relative_error"] <= plain["train_relative_error"], (fit, plain)
            continue
        for error in ("train_relative_error", "held_out_relative_error", "held_out_ambient_error"):
            if error != "held_out_ambient_error" or fit["frame"] == "local":
                assert 0 < fit[error] < 3, (error, fit)
    assert any(fit["model"] == "additive" and fit["prior"] == "none" for fit in fits), fits
    for fit in fits:
        if fit["held_out_cosine_product_error"] is None:
            continue
        same = {key: fit[key] for key in ("model", "features", "clusters", "frame", "clamped")}
        weighted = next(other for other in fits if other["target"] == "cosine-weighted" and same.items() <= other.items())
        ratio = fit["held_out_cosine_product_error"] / weighted["held_out_relative_error"]
        assert 0.8 < ratio < 1.6, (ratio, same)
    assert "joint" not in [figure["id"] for figure in data["figures"]], "nothing of a sheet is a joint"
    _, console = browse(page)
    assert not console, console
    run(*command, "-o", page, "--threads", 1, "-q")
    assert without_times(json.loads((folder / "c.json").read_text())) == without_times(data)


def check_variance(folder):
    """scripts/figures/compare_variance: pictures of each variance and of the truth, on a page, and errors that fall."""
    bake, out = folder / "man.vis.h5", folder / "variance"
    subprocess.run([BIN / "penumbra-bake", "visibility", BIN / ".." / "samples" / "capsule_man.glb", "--fps", "3", "--rays",
                    "32", "-q", "-o", bake], check=True)
    script = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "figures" / "compare_variance"
    subprocess.run([script, bake, "--holdout", "squat", "-o", out, "--variances", "0.4,0.99", "--model", "linear", "--size",
                    "64", "--bin", BIN], check=True, stdout=subprocess.DEVNULL)
    with open(out / "variance.csv", newline="") as file:
        low, high = csv.DictReader(file)
    assert float(high["train_relative_error"]) < float(low["train_relative_error"]), (low, high)
    for name in ("truth.png", "v0.4.png", "v0.4_error.png", "v0.99.png", "v0.99_error.png"):
        assert (out / name).stat().st_size > 200 and name in (out / "index.html").read_text(), name


def check_errors(folder, command):
    bake, other = command[0], folder / "e.html"
    dry = [bake, "-o", other, "--dry-run"]
    run(*dry, code=1, says="--holdout")
    run(*dry, "--holdout", "dance", code=1, says="clip0, clip1, clip2")
    run(*dry, "--holdout", "clip0,clip1,clip2", code=1, says="no clip is left")
    hold = [bake, "--holdout", "clip1"]
    run(*hold, "-o", folder / "e.txt", code=1, says=".html")
    run(*hold, "-o", other, "--models", "magic", code=1, says="linear")
    run(*hold, "-o", other, "--features", "smell", code=1, says="joint-angles, relative-bones")
    run(*hold, "-o", other, "--clusters", "4,2.5", code=1, says="--clusters")
    run(*hold, "-o", other, "--clusters", "8,1000", code=1, says="40 vertices")
    run(*hold, "-o", other, "--output-variances", "0.9,1.1", code=1, says="--output-variances")
    run(*hold, "-o", other, "--conventions", "A3,E3", code=1, says="--conventions")
    run(*hold, "-o", other, "--conventions", "A4", code=1, says="order 3")
    run(*hold, "-o", other, "--report", folder / "e.json", code=1, says="the same file")
    (folder / "e.json").unlink()  # a report is written for a failure too
    run(*hold, "-o", folder / "no" / "e.html", code=2, says="no/e.html")
    (folder / "e.csv").write_text("mine")
    run(*hold, "-o", other, "--no-clobber", code=2, says="e.csv")
    assert (folder / "e.csv").read_text() == "mine"
    (folder / "e.csv").unlink()
    (folder / "e.json").mkdir()
    run(*hold, "-o", other, code=2, says="e.json")
    (folder / "e.json").rmdir()
    left = [p.name for p in folder.iterdir() if p.name.startswith("e.")]
    assert not left, f"left behind: {left}"


def check_interrupt(folder):
    """SIGINT comes in the middle. Nothing is left, the exit code is 4, and it takes a second or so."""
    bake, page = folder / "long.vis.h5", folder / "i.html"
    bake_file(bake, clips=8, frames=60)
    run_ = subprocess.Popen([BIN / "penumbra-fit", "compare", bake, "--holdout", "clip1", "--clusters",
                             ",".join(map(str, range(1, 41))), "-o", page, "--progress", "alf"],
                            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    for line in run_.stdout:
        if "ALF_PROGRESS" in line:
            break
    message, seconds = processor_time.stop(run_, signal.SIGINT)
    assert run_.returncode == 4, (run_.returncode, message)
    assert seconds < 1, seconds
    assert not [p for p in folder.iterdir() if p.name.startswith("i.")], "left behind"


with tempfile.TemporaryDirectory() as name:
    where = pathlib.Path(name)
    given, written = check_compare(where)
    check_same_for_any_thread_count(where, given, written)
    check_errors(where, given)
    check_variance(where)
    check_cloth(where)
    check_interrupt(where)
print("compare: JSON, CSV and page agree and do not depend on threads; the page opens in Chromium without errors and"
      " every plot is there; refusals and interrupts leave nothing")
