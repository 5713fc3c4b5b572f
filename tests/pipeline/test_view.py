"""penumbra-player view under Xvfb, driven by keys and mouse through xdotool: it plays, scrubs, switches material, light
and model/truth, and its screenshots change as they should.

usage: test_view.py BIN
"""
import json
import os
import subprocess
import sys
import tempfile
import time

import numpy as np
from PIL import Image

from x11_events import DragSource, another_window

BIN = os.path.abspath(sys.argv[1])
RIG = os.path.join(BIN, "..", "samples", "capsule_man.glb")
WIDTH, HEIGHT, PANEL, TIMELINE = 800, 600, 290, 120  # of the panels: player/view_layout.h


def run(tool, *words, **options):
    return subprocess.run([os.path.join(BIN, "penumbra-" + tool), *map(str, words)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, **options)


def good(tool, *words):
    result = run(tool, *words)
    assert result.returncode == 0, (tool, words, result.stderr)


def make_assets():
    good("bake", "visibility", RIG, "-o", "x.vis.h5", "--fps", 4, "--rays", 64)
    good("fit", "visibility", "x.vis.h5", "-o", "x.model.h5", "--holdout", "squat", "--clusters", 13)
    good("fit", "brdf", "--analytic", "lambert", "-o", "lambert.brdf.h5")
    good("fit", "brdf", "--analytic", "ggx:alpha=0.3,f0=0.9,color=1/0.6/0.2", "--operators", 8, "-o", "ggx.brdf.h5")
    good("fit", "light", "--analytic", "sky:turbidity=3", "-o", "sky.light.h5")
    good("fit", "light", "--analytic", "uniform", "-o", "even.light.h5")
    good("pack", "asset", "x.model.h5", "--brdf", "lambert.brdf.h5", "--brdf", "ggx.brdf.h5", "--light", "sky.light.h5",
         "--light", "even.light.h5", "-o", "x.pnb")
    good("pack", "truth", "x.vis.h5", "-o", "x.truth.pnb")
    good("fit", "brdf", "--analytic", "lambert:color=0.02/0.6/0.1", "--name", "green", "-o", "green.brdf.h5")
    good("fit", "light", "--analytic", "uniform", "--name", "dropped light", "-o", "dropped.light.h5")
    good("pack", "asset", "--brdf", "green.brdf.h5", "--light", "dropped.light.h5", "-o", "library.pnb")


class Display:
    """An X server of its own, on a number that is free."""

    def __enter__(self):
        read, write = os.pipe()
        self.server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", "1600x1200x24", "-nolisten", "tcp", "-noreset"],
                                       pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as numbers:
            number = numbers.readline().strip()
        assert number, "Xvfb does not start"
        os.environ["DISPLAY"] = ":" + number
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


class View:
    """A running window."""

    def __init__(self, *words, size=""):
        size = ["--size", size] if size else []  # else what the settings have
        self.process = subprocess.Popen([os.path.join(BIN, "penumbra-player"), "view", *words, *size], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        found = subprocess.run(["timeout", "60", "xdotool", "search", "--sync", "--onlyvisible", "--pid",
                                str(self.process.pid)], stdout=subprocess.PIPE, text=True).stdout.split()
        assert found, "no window: " + self.process.communicate(timeout=5)[1]
        self.window = found[0]
        self.tool("windowfocus", "--sync", self.window)

    def tool(self, *words):
        subprocess.run(["timeout", "60", "xdotool", *map(str, words)], check=True)

    def keys(self, *names):
        if names:
            self.tool("key", *names)

    def move(self, x, y):
        self.tool("mousemove", "--window", self.window, int(x), int(y))
        time.sleep(0.15)  # ImGui must see the pointer there in a frame of its own

    def drag(self, button, start, end):
        self.move(*start)
        self.tool("mousedown", button)
        time.sleep(0.15)
        self.move(*end)
        self.tool("mouseup", button)
        time.sleep(0.15)

    def shot(self, *names, panels=False):
        """Presses keys and takes a screenshot: the picture without panels, and the line that says what is on."""
        self.keys(*names)
        self.keys("F12" if panels else "shift+F12")
        line = self.process.stdout.readline()
        assert line, self.process.communicate()[1]
        path, said = line.rstrip("\n").split(": ", 1)
        return Shot(np.asarray(Image.open(path).convert("RGB"), int), said, panels)

    def close(self):
        self.keys("q")
        out, err = self.process.communicate(timeout=30)
        assert self.process.returncode == 0 and err == "", (self.process.returncode, err)


class Shot:
    def __init__(self, pixels, said, panels):
        self.whole, self.said = pixels, said
        self.picture = pixels[:HEIGHT - TIMELINE, PANEL:] if panels else pixels
        assert not panels or pixels.shape == (HEIGHT, WIDTH, 3), pixels.shape

    def frame(self):
        return float(self.said.split("frame ")[1].split(",")[0])

    def mask(self):
        """The figure: whatever differs from the background, the colour of the upper right corner."""
        return np.abs(self.picture - self.picture[20, -1]).max(-1) > 12


def difference(a, b):
    return float(np.abs(a.picture - b.picture).mean())


def center(mask):
    return np.array([axis.mean() for axis in np.nonzero(mask)])


def check_plays_and_scrubs(view, first):
    assert first.frame() == 0, first.said
    view.keys("space")
    time.sleep(1.5)
    played = view.shot("space")
    assert played.frame() > 0 and difference(first, played) > 0.1, (played.said, difference(first, played))
    again = view.shot()
    assert again.frame() == played.frame() and difference(again, played) == 0, "paused, nothing moves"
    middle = (PANEL + (WIDTH - PANEL) / 2, HEIGHT - TIMELINE + 43)
    view.drag(1, middle, (WIDTH - 20, middle[1]))
    scrubbed = view.shot()
    assert scrubbed.frame() == 12, "the end of a clip of 13 frames, not " + scrubbed.said
    assert view.shot("Left").frame() == 11
    start = view.shot("Home")
    assert start.frame() == 0 and difference(start, first) == 0, "the first frame again"
    other = view.shot("Next")
    assert other.said.split(",")[0] != first.said.split(",")[0], other.said
    assert difference(view.shot("Prior"), first) == 0


def check_smooth(view, first):
    """Between sampled frames the pose moves on; with truth it does not."""
    row = HEIGHT - TIMELINE + 43
    at = lambda number: (PANEL + 8 + (WIDTH - PANEL - 16) * number / 13, row)  # 13 frames
    between = []
    for number in (4.02, 4.5, 4.9):
        view.drag(1, at(number - 1), at(number))
        between.append(view.shot())
        assert abs(between[-1].frame() - number) < 0.05, (number, between[-1].said)
    assert difference(between[0], between[1]) > 0.05 and difference(between[1], between[2]) > 0.05
    assert difference(between[0], between[2]) > difference(between[0], between[1]), "further is further"
    on_frame = view.shot("i")
    assert on_frame.said.split("frame ")[1].startswith("4,"), on_frame.said
    assert view.shot("t").frame() == 4, "truth is baked on sampled frames"
    assert abs(view.shot("t", "i").frame() - 4.9) < 0.05
    assert view.shot("Left").frame() == 4
    assert difference(view.shot("Home"), first) == 0


def check_strips(view, first):
    """The strips of the timeline: filled, found by a click, and the worst frames by a key."""
    time.sleep(1)  # they are computed while nothing else is to do
    shown = view.shot(panels=True).whole
    strips = []
    for row, color in ((HEIGHT - 56, (235, 140, 40)), (HEIGHT - 33, (214, 72, 96))):
        strip = shown[row - 9:row + 11, PANEL + 8:WIDTH - 8]
        filled = (np.abs(strip - color).max(-1) < 12).sum(0)
        assert filled.any(), (row, "nothing is in the strip")
        cells = [filled[int(i * len(filled) / 13) + 2:int((i + 1) * len(filled) / 13) - 2].max() for i in range(13)]
        strips.append((row, cells))
    worst = view.shot("w")
    assert abs(strips[1][1][int(worst.frame())] - max(strips[1][1])) <= 1, (worst.said, strips)
    far = view.shot("shift+w")
    assert abs(strips[0][1][int(far.frame())] - max(strips[0][1])) <= 1, (far.said, strips)
    view.move(PANEL + 8 + (WIDTH - PANEL - 16) * 7.5 / 13, HEIGHT - 33)
    view.tool("click", 1)
    time.sleep(0.2)
    assert view.shot().frame() == 7, "a click on a strip's cell"
    view.move(PANEL + 100, 200)
    assert difference(view.shot("Home"), first) == 0


def check_shading(view, first):
    gold = view.shot("m")
    assert "ggx" in gold.said and "lambert" in first.said, (gold.said, first.said)
    inside = gold.mask()
    red, _, blue = gold.picture[inside].mean(0)
    plain = first.picture[first.mask()].mean(0)
    assert red / blue > 1.5 * plain[0] / plain[2], ("gold is redder", red, blue, plain)
    assert difference(view.shot("m"), first) == 0, "two materials: the first again"

    even = view.shot("l")
    assert "uniform" in even.said and difference(even, first) > 1, even.said
    upper, lower = even.picture[:250][even.mask()[:250]], first.picture[:250][first.mask()[:250]]
    assert not np.array_equal(upper, lower)
    turned_even = [even]
    view.drag(3, (550, 100), (650, 180))
    turned_even.append(view.shot())
    # A light that comes from everywhere is the same however it is turned (single precision: one step of 255).
    assert np.abs(turned_even[0].picture - turned_even[1].picture).max() <= 1
    turned = view.shot("l")
    assert difference(turned, first) > 0.3, ("the sky was turned with it", difference(turned, first))
    assert np.abs(view.shot("k").picture - first.picture).max() <= 1, "turned back, but for rounding"

    brighter = view.shot("e", "e")
    assert brighter.picture[first.mask()].mean() > first.picture[first.mask()].mean() + 5
    assert difference(view.shot("d", "d"), first) < 0.5
    assert difference(view.shot("o"), first) > 0.5, "tone mapping"
    view.keys("shift+o")


def check_forms(view, first):
    """The light's forms and the reflectance's: fixed lobes are the exact light again, three fitted lobes nearly."""
    fitted, fixed = view.shot("v"), view.shot("v")
    assert "light form lobes" in fitted.said and "light form fixed" in fixed.said, (fitted.said, fixed.said)
    assert np.abs(fixed.picture - first.picture).max() <= 2, "the same light"
    assert 0 < difference(fitted, first) < 2, difference(fitted, first)  # measured: 0.0007, a sky is three lobes
    exact = view.shot("v")
    assert exact.said == first.said and np.abs(exact.picture - first.picture).max() <= 1, "a light turned anew rounds"
    slices, operators = view.shot("m"), view.shot("p")
    assert "reflectance operators" in operators.said and "operators" not in slices.said, operators.said
    assert 0.01 < difference(slices, operators) < 8, difference(slices, operators)
    assert np.abs(view.shot("m").picture - first.picture).max() <= 1, "lambert has no operators: its slices are shown"
    view.keys("p")


def check_channels(view, first):
    pictures = [view.shot(key) for key in "2345"] + [first]
    for i, a in enumerate(pictures):
        for b in pictures[:i]:
            assert difference(a, b) > 0.5, (a.said, b.said)
    clusters = pictures[2]
    colors = {tuple(c) for c in clusters.picture[clusters.mask()][::7]}
    assert len(colors) >= 8, colors  # of 13 clusters, those that are seen
    view.keys("1")


def check_truth(view, first):
    truth = view.shot("t")
    assert ", truth," in truth.said
    gap = difference(truth, first)
    assert 0.02 < gap < 5, ("truth looks like the model, but is not it", gap)
    assert difference(view.shot("t"), first) == 0
    side = view.shot("c", "c")
    assert "side by side" in side.said
    half = (WIDTH - PANEL) // 2
    left, right = side.mask()[30:, :half - 2], side.mask()[30:, half + 2:]
    assert left.sum() > 300 and abs(left.sum() - right.sum()) < 0.02 * left.sum(), (left.sum(), right.sum())
    wipe = view.shot("c")
    left, right = wipe.picture[30:, :half - 2], wipe.picture[30:, half + 2:]
    assert np.array_equal(left, first.picture[30:, :half - 2]), "the left part is the model"
    assert np.array_equal(right, truth.picture[30:, half + 2:]), "the right part is the truth"
    apart = view.shot("c")
    assert "difference" in apart.said
    assert apart.picture[first.mask()].mean() < 0.5 * first.picture[first.mask()].mean()
    view.keys("c")


def check_camera(view, first):
    view.move(320, 40)
    before = view.shot("x")
    view.tool("mousemove", "--window", view.window, 760, 60, "click", 1)  # in one frame, past the figure
    time.sleep(0.3)
    assert difference(view.shot("x"), before) == 0, "a click turns nothing"
    view.drag(1, (500, 250), (600, 250))
    orbited = view.shot()
    assert difference(orbited, first) > 1
    view.drag(2, (500, 250), (560, 290))
    panned = view.shot()
    shift = center(panned.mask()) - center(orbited.mask())
    assert np.abs(shift - [40, 60]).max() < 12, ("the figure follows the pointer", shift)
    view.move(550, 250)
    view.tool("click", 4)
    view.tool("click", 4)
    time.sleep(0.2)
    assert view.shot().mask().sum() > 1.1 * panned.mask().sum(), "the wheel brings it nearer"
    framed = view.shot("f")
    assert np.abs(center(framed.mask()) - center(orbited.mask())).max() < 3
    before = view.shot()
    view.keys("r")
    time.sleep(1)
    assert difference(view.shot("r"), before) > 0.5, "turntable"


def check_overlays(view):
    """The picked vertex' lobe and figures, lines of normals, PCA components."""
    plain, panel = view.shot(), view.shot(panels=True)
    y, x = (int(c) for c in center(plain.mask()))
    view.move(PANEL + x, y)
    view.tool("click", 1)
    time.sleep(0.3)
    picked = view.shot()
    changed = np.abs(picked.picture - plain.picture).max(-1) > 30
    assert changed.sum() > 150 and np.abs(center(changed) - [y, x]).max() < 80, (changed.sum(), center(changed), (y, x))
    figures = view.shot(panels=True)
    assert np.abs(figures.whole[:, :PANEL] - panel.whole[:, :PANEL]).mean() > 1, "numbers of the vertex"
    assert difference(view.shot("x"), plain) == 0
    assert np.abs(view.shot("n", panels=True).picture - panel.picture).mean() > 1, "lines of normals"
    view.keys("n")
    first, second = view.shot("6"), view.shot("6")
    assert difference(first, plain) > 1 and difference(first, second) > 0.5
    inside = first.picture[first.mask()]
    assert (inside[:, 0] > inside[:, 2] + 40).any() and (inside[:, 2] > inside[:, 0] + 40).any(), "red and blue"
    assert difference(view.shot("1"), plain) == 0


def rows_of(color, pixels):
    """The first row of every run of rows that have the colour in the side panel, and the columns there."""
    near = np.abs(pixels[:, :PANEL] - color).max(-1) < 12
    rows = np.flatnonzero(near.sum(1) > 20)
    return [(int(r), np.flatnonzero(near[r])) for r in rows if r - 1 not in rows]


def check_components(view):
    """A score under its slider: the cluster of the picked vertex changes and nothing else; Z takes it back."""
    plain = view.shot("2")
    y, x = (int(c) for c in center(plain.mask()))
    view.move(PANEL + x, y)
    view.tool("click", 1)
    time.sleep(1)
    view.move(PANEL // 2, 300)
    view.tool("click", "--repeat", 30, 5)
    time.sleep(0.5)
    shown = view.shot(panels=True)
    ranges = rows_of((120, 200, 120), shown.whole)
    assert len(ranges) >= 2, "training ranges of the components"
    before = view.shot()
    row, columns = ranges[0]
    view.drag(1, (int(columns.mean()), row - 6), (PANEL - 25, row - 6))
    view.move(PANEL + 300, 30)
    changed = view.shot()
    assert "scores of cluster" in changed.said, changed.said
    where = np.abs(changed.picture - before.picture).max(-1) > 8
    where[:60, :250] = False  # the label says so
    assert 20 < where.sum() < 0.7 * plain.mask().sum(), where.sum()
    assert difference(view.shot("Right"), changed) > 0.01 and difference(view.shot("Left"), changed) == 0
    assert difference(view.shot("z"), before) == 0
    assert difference(view.shot("x"), plain) == 0
    view.keys("1")


def check_heat_map(view):
    """The scale's end moves by keys, clusters have names, frames have three axes, held-out clips another colour."""
    wide, narrow = view.shot("3"), view.shot("bracketleft", "bracketleft", "bracketleft", "bracketleft")
    assert narrow.picture[narrow.mask()].mean() > wide.picture[wide.mask()].mean() + 1, "smaller errors are brighter"
    legend = view.shot(panels=True)
    assert (legend.picture[-170:, -150:].min(-1) > 200).sum() > 60, "numbers and unit beside the scale"
    assert difference(view.shot(*["bracketright"] * 4), wide) < 0.05
    named, bare = view.shot("4", panels=True), view.shot()
    written = np.abs(named.picture - bare.picture).max(-1)[40:] > 60
    assert written.sum() > 150, ("names of clusters", written.sum())
    axes = view.shot("1", "n", panels=True).picture.reshape(-1, 3)
    for color in ((230, 70, 60), (80, 200, 80), (90, 140, 255)):
        assert (np.abs(axes - color).max(-1) < 40).sum() > 20, color
    view.keys("n")
    held_out = np.abs(legend.whole[:, :PANEL] - (242, 191, 77)).max(-1) < 12
    assert held_out.any(), "one clip is held out"


def check_drops(view):
    """Files that a file manager drops: materials and a light, a picture, and one that is nothing of the kind."""
    material, light = (view.shot().said.split(word)[1].split(", ")[0] for word in ("material ", "light "))
    for name, wrong in (("library.pnb", False), ("rays.hdr", False), ("broken.pnb", True)):
        if name == "rays.hdr":
            with open(name, "wb") as file:
                file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([64, 64, 128, 129]) * 32)
        if wrong:
            with open(name, "wb") as file:
                file.write(b"PNB1 but no more")
        DragSource(view.window).drop([os.path.abspath(name)])
        time.sleep(0.5)
    before = view.shot()
    assert material in before.said and light in before.said, ("what was on stays on", before.said)
    green = view.shot("m", "m")
    assert "material green" in green.said, green.said
    inside = green.picture[before.mask()].mean(0)
    assert inside[1] > 1.5 * inside[0], inside
    assert "light dropped light" in view.shot("m", "l", "l").said
    blue = view.shot("l")
    assert "light rays.hdr" in blue.said, blue.said
    assert light in view.shot("l").said, "three new names at most: the broken file changed nothing"


def check_window(view):
    shown = view.shot(panels=True)
    view.keys("F1")
    time.sleep(0.3)  # ImGui needs a frame for its size
    help_on = view.shot(panels=True)
    assert difference(shown, help_on) > 5, "F1 covers the picture"
    view.keys("F1")
    view.keys("Tab")
    assert view.shot().picture.shape == (HEIGHT, WIDTH, 3), "the picture takes the panels' place"
    assert view.shot("Tab").picture.shape == shown.picture.shape
    # Background and ground: the sky is brighter than what lies under the horizon, the ground is chequered.
    sky = view.shot("b")
    assert sky.picture[20].mean() > shown.picture[20].mean() + 20, "the light behind the figure"
    assert difference(view.shot("b", "g"), shown) > 2, "ground"
    view.drag(1, (500, 350), (500, 200))  # the camera goes below it
    below = view.shot()
    assert difference(view.shot("g"), below) == 0, "no ground between the camera and the figure"
    view.drag(1, (500, 200), (500, 350))


def cpu_seconds(view):
    fields = open("/proc/%d/stat" % view.process.pid).read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def check_idle(view):
    """Nothing moves: nothing is computed or drawn."""
    time.sleep(2)  # strips are finished then
    before = cpu_seconds(view)
    time.sleep(3)
    used = (cpu_seconds(view) - before) / 3
    assert used < 0.02, ("share of a core while idle", used)  # measured: 0.000 to 0.003
    return used


def check_managed():
    """Under a window manager: sizes, iconify and restore, another window in focus, the place that is remembered."""
    global WIDTH, HEIGHT
    manager = subprocess.Popen(["openbox", "--sm-disable"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    time.sleep(1)
    view = View("x.pnb", size="800x600")
    view.keys("b")
    first = view.shot("f")
    for WIDTH, HEIGHT in ((640, 500), (1100, 900), (800, 600)):
        view.tool("windowsize", "--sync", view.window, WIDTH, HEIGHT)
        time.sleep(0.5)
        shot = view.shot("f", panels=True)
        assert shot.mask()[:, 5:].sum() > 500, (WIDTH, HEIGHT)
    view.keys("space")
    view.tool("windowminimize", "--sync", view.window)
    time.sleep(0.5)
    before = cpu_seconds(view)
    time.sleep(2)
    assert cpu_seconds(view) - before < 0.1, "an icon needs no frames"
    view.tool("windowmap", "--sync", view.window)
    view.tool("windowactivate", "--sync", view.window)
    view.shot("space")
    assert difference(view.shot("Home"), first) < 0.05, "as before"
    view.keys("space")
    other, number = another_window()
    view.tool("windowfocus", "--sync", number)
    view.keys("Next")  # goes to the other window
    time.sleep(1)
    other.close()
    view.tool("windowactivate", "--sync", view.window)
    played = view.shot("space")
    assert played.frame() > 0 and played.said.split(",")[0] == first.said.split(",")[0], played.said
    view.tool("windowmove", "--sync", view.window, 300, 200)
    time.sleep(0.5)
    view.close()
    view = View("x.pnb")
    geometry = subprocess.run(["xdotool", "getwindowgeometry", view.window], stdout=subprocess.PIPE, text=True).stdout
    view.close()
    place = [int(n) for n in geometry.split("Position: ")[1].split(" ")[0].split(",")]
    assert abs(place[0] - 300) < 12 and abs(place[1] - 200) < 40, geometry  # but for the frame around it
    assert "800x600" in geometry, geometry
    manager.terminate()
    manager.wait()


def check_resize(view):
    global WIDTH, HEIGHT
    view.keys("space")
    for i in range(40):  # while it draws
        view.tool("windowsize", view.window, 400 + 37 * i % 800, 300 + 53 * i % 700)
        time.sleep(0.03)
    view.keys("space")
    view.tool("windowsize", "--sync", view.window, 640, 500)
    time.sleep(0.5)
    WIDTH, HEIGHT = 640, 500
    assert view.shot("f").mask().sum() > 500
    view.tool("windowunmap", "--sync", view.window)
    time.sleep(0.5)
    view.tool("windowmap", "--sync", view.window)
    view.tool("windowfocus", "--sync", view.window)
    time.sleep(0.5)
    assert view.shot().mask().sum() > 500
    WIDTH, HEIGHT = 800, 600


def check_high_density():
    """A display of 192 dots an inch: everything has twice as many pixels, the pointer still finds it."""
    subprocess.run(["xprop", "-root", "-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER", "Xft.dpi: 192"],
                   check=True)
    view = View("x.pnb", "--no-settings", size="700x500")
    assert view.shot().picture.shape == (2 * (500 - TIMELINE), 2 * (700 - PANEL), 3)
    view.drag(1, (2 * (PANEL + 200), 2 * (500 - TIMELINE + 43)), (2 * 690, 2 * (500 - TIMELINE + 43)))
    assert view.shot().frame() == 12, "the timeline is where it is seen"
    view.close()
    subprocess.run(["xprop", "-root", "-remove", "RESOURCE_MANAGER"], check=True)


def check_paths_agree():
    """The GLSL path's window is the CPU path's; it is the default on a GPU."""
    shots = []
    for path in ("cpu", "glsl"):
        view = View("x.pnb", "--truth", "x.truth.pnb", "--path", path)
        shots.append([view.shot(), view.shot("m", "l"), view.shot("t"), view.shot("2"), view.shot("c", "c")])
        view.close()
    for cpu, glsl in zip(*shots):
        rmse = float(np.sqrt(np.mean((cpu.picture - glsl.picture) ** 2.0)))
        assert cpu.said == glsl.said and rmse < 0.5, (cpu.said, glsl.said, rmse)


def check_sequence(view):
    view.keys("F11")
    lines = [view.process.stdout.readline() for _ in range(13)]
    assert [Shot(None, line, False).frame() for line in lines] == list(range(13)), lines
    pictures = [np.asarray(Image.open("wave_%04d.png" % i), int) for i in range(13)]
    assert all(np.abs(a - b).mean() > 0.01 for a, b in zip(pictures, pictures[1:]))


def check_settings():
    """What the run before left: its exposure, no background, its window's size."""
    with open("penumbra/view.json") as file:
        kept = json.load(file)
    assert (kept["window"]["width"], kept["background"]) == (640, False), kept
    for text, says in (("{", "view.json is not used"), (json.dumps({**kept, "exposure": 0}), "exposure is out of range")):
        with open("penumbra/view.json", "w") as file:
            file.write(text)
        view = View("x.pnb")
        view.keys("q")
        err = view.process.communicate()[1]
        assert view.process.returncode == 0 and says in err, err
    with open("penumbra/view.json", "w") as file:
        json.dump({**kept, "exposure": 4, "window": {**kept["window"], "x": -60, "y": -20}}, file)
    view = View("x.pnb")
    bright = view.shot()
    view.close()
    view = View("x.pnb", "--no-settings")
    plain = view.shot("b")
    view.close()
    assert bright.picture.shape[0] == 500 - TIMELINE and plain.picture.shape[0] == 800 - TIMELINE
    assert bright.picture[bright.mask()].mean() > plain.picture[plain.mask()].mean() + 30
    with open("penumbra/view.json", "w") as file:
        json.dump(kept, file)


def check_several():
    """The same file twice, a picture as a light beside the asset's own."""
    with open("red.hdr", "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([128, 64, 64, 129]) * 32)
    said = run("player", "view", "x.pnb", "x.pnb", "red.hdr", "--dry-run").stdout
    assert said == "would show 2 characters, 2 materials, 3 lights\n", said
    view = View("x.pnb", "x.pnb", "red.hdr")
    two = view.shot()
    columns = np.flatnonzero(two.mask().any(0))
    gaps = np.flatnonzero(np.diff(columns) > 5)
    assert len(gaps) == 1, "two figures with a gap between them"
    view.keys(*"ll")
    red = view.shot()
    assert "red.hdr" in red.said, red.said
    inside = red.picture[red.mask()].mean(0)
    assert inside[0] > 1.2 * inside[1], inside
    view.close()


def check_errors():
    display = os.environ.pop("DISPLAY")
    result = run("player", "view", "x.pnb")
    assert result.returncode == 5 and "no window" in result.stderr, result
    good("player", "render", "x.pnb", "--size", "32x32", "-o", "still.png")
    os.environ["DISPLAY"] = display
    for code, words, says in ((3, ["x.truth.pnb"], "holds no model"), (2, ["none.pnb"], "none.pnb"),
                              (1, ["x.pnb", "--size", "9"], "--size"), (1, ["x.pnb", "--size", "5x5"], "480x320"), (1, ["x.pnb", "--path", "fast"], "--path"),
                              (2, ["x.pnb", "--screenshots", "nowhere"], "nowhere"),
                              (3, ["x.pnb", "--truth", "x.vis.h5"], "not a Penumbra asset")):
        result = run("player", "view", *words)
        assert result.returncode == code and says in result.stderr, (words, result)
    said = run("player", "view", "x.pnb", "--dry-run").stdout
    assert "would show 1 character, 2 materials, 2 lights" in said, said


with tempfile.TemporaryDirectory() as folder, Display():
    os.chdir(folder)
    os.environ["XDG_CONFIG_HOME"] = folder
    make_assets()
    check_errors()
    window = View("x.pnb", "--truth", "x.truth.pnb", "--report", "r.json", size="800x600")
    window.keys("b")  # without the light's background
    start = window.shot()
    assert start.mask().sum() > 2000, start.mask().sum()
    check_plays_and_scrubs(window, start)
    check_smooth(window, start)
    check_strips(window, start)
    check_shading(window, start)
    check_forms(window, start)
    start = window.shot()  # the light was turned and turned back, which rounds
    check_channels(window, start)
    check_truth(window, start)
    check_camera(window, start)
    check_overlays(window)
    check_components(window)
    check_heat_map(window)
    check_window(window)
    check_sequence(window)
    idle = check_idle(window)
    check_drops(window)
    check_resize(window)
    window.close()
    with open("r.json") as report:
        figures = json.load(report)["figures"]
    print("%d frames, %s, path %s; %.3f of a core while idle" % (figures["frames"], figures["gl"], figures["path"], idle))
    check_settings()
    check_several()
    check_high_density()
    check_paths_agree()
    check_managed()  # last: GLFW 3.3 may abort where a window manager has just gone
    os.chdir("/")
print("ok")
