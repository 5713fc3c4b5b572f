"""The tests of penumbra-player view share this: an X server, assets, a running window and its screenshots."""
import contextlib
import json
import os
import subprocess
import tempfile
import time

import numpy as np
from PIL import Image

import processor_time
from programs import BIN, good

RIG = os.path.join(BIN, "..", "samples", "capsule_man.glb")
WIDTH, HEIGHT, PANEL, TIMELINE = 800, 600, 320, 132  # sizes of the panels: panelSizes() in player/view/view_layout.cpp
ROWS = PANEL + 120  # where the rows of the timeline begin, to the right of their names
SCRUB, RANGE, ERROR = HEIGHT - TIMELINE + 44, HEIGHT - TIMELINE + 70, HEIGHT - TIMELINE + 97  # the middles of the rows


def panel_of(width):
    return int(min(PANEL, 0.42 * width))


def frame_x(number, frames=13):
    """Where a frame is in the rows of the timeline."""
    return ROWS + (WIDTH - 8 - ROWS) * number / frames


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


def make_scene():
    """Two composed characters on a ground, the second one turned and later in its clip."""
    good("bake", "visibility", RIG, "-o", "y.vis.h5", "--fps", 4, "--rays", 64, "--local")
    good("bake", "fields", RIG, "-o", "y.fields.h5")
    good("fit", "visibility", "y.vis.h5", "--fields", "y.fields.h5", "-o", "y.model.h5", "--holdout", "squat")
    good("pack", "asset", "y.model.h5", "--brdf", "lambert.brdf.h5", "--light", "sky.light.h5", "-o", "y.pnb")
    people = [{"asset": "y.pnb", "position": [-0.45, 0, 0]},
              {"asset": "y.pnb", "position": [0.45, 0, 0], "yaw": 160, "time": 0.5}]
    with open("scene.json", "w") as f:
        json.dump({"version": 1, "characters": people, "ground": {"size": 5}, "camera": "yaw=10,pitch=25"}, f)


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
        if "--light-fade" not in words:
            words = (*words, "--light-fade", "0")  # a picture is of one light
        self.process = subprocess.Popen([os.path.join(BIN, "penumbra-player"), "view", *words, *size], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        found = subprocess.run(["timeout", "60", "xdotool", "search", "--sync", "--onlyvisible", "--pid",
                                str(self.process.pid)], stdout=subprocess.PIPE, text=True).stdout.split()
        assert found, "no window: " + self.process.communicate(timeout=5)[1]
        self.window = found[0]
        self.focus(self.window)

    def tool(self, *words):
        subprocess.run(["timeout", "60", "xdotool", *map(str, words)], check=True)

    def focus(self, window):
        """Gives a window the keyboard. X refuses that until the window can be seen, so it is asked again."""
        deadline = time.monotonic() + 20
        words = ["timeout", "60", "xdotool", "windowfocus", "--sync", str(window)]
        while (done := subprocess.run(words, stderr=subprocess.PIPE, text=True)).returncode:
            assert time.monotonic() < deadline, done.stderr
            time.sleep(0.05)

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
        """Presses keys and takes a screenshot. Returns the picture without panels, and the line that says what is
        on."""
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
        """Returns the figure: whatever differs from the background, which has the colour of the upper right
        corner."""
        return np.abs(self.picture - self.picture[20, -1]).max(-1) > 12


def difference(a, b):
    return float(np.abs(a.picture - b.picture).mean())


def center(mask):
    return np.array([axis.mean() for axis in np.nonzero(mask)])


def cpu_seconds(view):
    return processor_time.of_running(view.process.pid)


def wait_until(condition, what, seconds=20):
    """Asks again and again, up to a deadline, and returns the first answer that is true."""
    deadline = time.monotonic() + seconds
    while not (result := condition()):
        assert time.monotonic() < deadline, "waited in vain for " + what
        time.sleep(0.05)
    return result


@contextlib.contextmanager
def prepared():
    """Makes a folder with the assets, its own settings, and an X server."""
    with tempfile.TemporaryDirectory() as folder, Display():
        os.chdir(folder)
        os.environ["XDG_CONFIG_HOME"] = os.environ["XDG_RUNTIME_DIR"] = folder  # GLFW 3.4 asks for the latter
        make_assets()
        yield
        os.chdir("/")


@contextlib.contextmanager
def opened():
    """Opens the window of the character and its truth. Returns it with its first picture, without the light's
    background."""
    window = View("x.pnb", "--truth", "x.truth.pnb", "--report", "r.json", size="800x600")
    window.keys("b")
    start = window.shot()
    assert start.mask().sum() > 2000, start.mask().sum()
    yield window, start
    window.close()
