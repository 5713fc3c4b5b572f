"""The window of penumbra-player view under Xvfb: errors, size, idle, dropped files, settings, several assets, displays
of high density, a window manager.

usage: test_view_window.py BIN
"""
import json
import os
import subprocess
import time

import numpy as np
from PIL import Image

import view_window
from programs import BIN, good, run_tool as run
from view_window import PANEL, TIMELINE, Shot, View, cpu_seconds, difference, opened, panel_of, prepared, wait_until
from x11_events import DragSource, another_window


def check_drops(view):
    """A file manager drops files: materials and a light, a picture, and one that is nothing of the kind."""
    material, light = (view.shot().said.split(word)[1].split(", ")[0] for word in ("material ", "light "))
    for name, wrong in (("library.pnb", False), ("rays.hdr", False), ("broken.pnb", True)):
        if name == "rays.hdr":
            with open(name, "wb") as file:
                file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([64, 64, 128, 129]) * 32)
        if wrong:
            with open(name, "wb") as file:
                file.write(b"PNB1 but no more")
        DragSource(view.window).drop([os.path.abspath(name)])
    before = view.shot()
    assert material in before.said, ("a library changes nothing that is on", before.said)
    assert "light rays.hdr" in before.said, ("the light of a picture is on", before.said)
    view.keys("l")
    before = view.shot()
    assert light in before.said, before.said
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
    panel = lambda: view.shot(panels=True).whole[:, :PANEL]
    for key, what in (("F1", "the keys"), ("F2", "the files")):
        view.keys(key)
        wait_until(lambda: np.abs(shown.whole[:, :PANEL] - panel()).mean() > 3, f"{key} to list {what}")
        assert difference(shown, view.shot(panels=True)) == 0, "beside the picture"
        view.keys(key)
    view.keys("F2")
    wait_until(lambda: np.abs(shown.whole[:, :PANEL] - panel()).mean() > 3, "the files")
    files = panel()
    view.keys("F1")
    wait_until(lambda: np.abs(files - panel()).mean() > 1, "the keys in the files' place")
    view.keys("F1")
    before = view.shot()
    view.drag(1, (500, 350), (600, 330))
    dragged = view.shot()
    assert difference(dragged, before) > 0.1
    assert difference(view.shot("BackSpace"), before) == 0, "the view before"
    assert difference(view.shot("shift+BackSpace"), dragged) == 0, "forward again"
    view.keys("BackSpace")
    corner = lambda: view.shot(panels=True).picture[-40:, :300]
    view.keys("x")
    plain = corner()
    view.keys("semicolon")
    wait_until(lambda: np.abs(corner() - plain).max(-1).mean() > 5, "why a key does nothing")
    view.keys("Tab")
    assert view.shot().picture.shape == (view_window.HEIGHT, view_window.WIDTH, 3), "the picture takes the panels' place"
    assert view.shot("Tab").picture.shape == shown.picture.shape
    # The sky is brighter than what lies under the horizon, and the ground is chequered.
    sky = view.shot("b")
    assert sky.picture[20].mean() > shown.picture[20].mean() + 20, "the light behind the figure"
    assert difference(view.shot("b", "g"), shown) > 2, "ground"
    view.drag(1, (500, 350), (500, 200))  # the camera goes below it
    # A change of the ground measures an automatic exposure anew, and that would change the figure.
    view.keys("e")
    below = view.shot()
    assert difference(view.shot("g"), below) == 0, "no ground between the camera and the figure"
    view.keys("shift+e")
    view.drag(1, (500, 200), (500, 350))


def check_idle(view):
    """Nothing moves, so nothing is computed or drawn."""
    def share(seconds):
        before = cpu_seconds(view)
        time.sleep(seconds)
        return (cpu_seconds(view) - before) / seconds

    wait_until(lambda: share(0.2) < 0.02, "the strips, after which nothing is to do")
    used = share(2)
    assert used < 0.02, ("share of a core while idle", used)  # measured: 0.000 to 0.003
    return used


def root_property(name):
    return subprocess.run(["xprop", "-root", name], stdout=subprocess.PIPE, text=True).stdout


def wait_for_size(view):
    """The window draws in its new size a little after it has it."""
    wanted = (view_window.HEIGHT - TIMELINE, view_window.WIDTH - panel_of(view_window.WIDTH), 3)
    wait_until(lambda: view.shot().picture.shape == wanted, f"a picture of {wanted}")


def check_managed():
    """Runs under a window manager: sizes, iconify and restore, another window in focus, and the place that is
    remembered."""
    manager = subprocess.Popen(["openbox", "--sm-disable"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wait_until(lambda: "window id" in root_property("_NET_SUPPORTING_WM_CHECK"), "the window manager")
    view = View("x.pnb", size="800x600")
    view.keys("b")
    first = view.shot("f")
    for view_window.WIDTH, view_window.HEIGHT in ((640, 500), (1100, 900), (800, 600)):
        view.tool("windowsize", "--sync", view.window, view_window.WIDTH, view_window.HEIGHT)
        wait_for_size(view)
        shot = view.shot("f", panels=True)
        assert shot.mask()[:, 5:].sum() > 500, (view_window.WIDTH, view_window.HEIGHT)
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
    view.focus(number)
    view.keys("Next")  # goes to the other window
    time.sleep(1)  # it plays on in the background, where no key asks for a picture
    other.close()
    view.tool("windowactivate", "--sync", view.window)
    played = view.shot("space")
    assert played.frame() > 0 and played.said.split(",")[0] == first.said.split(",")[0], played.said
    view.tool("windowmove", "--sync", view.window, 300, 200)
    time.sleep(0.5)  # the window manager tells the window later, and only the settings show that it did
    view.close()
    view = View("x.pnb")
    geometry = subprocess.run(["xdotool", "getwindowgeometry", view.window], stdout=subprocess.PIPE, text=True).stdout
    view.close()
    place = [int(n) for n in geometry.split("Position: ")[1].split(" ")[0].split(",")]
    assert abs(place[0] - 300) < 12 and abs(place[1] - 200) < 40, geometry  # the window's frame shifts the position
    assert "800x600" in geometry, geometry
    manager.terminate()
    manager.wait()


def check_resize(view):
    view.keys("space")
    for i in range(40):  # presses keys while the window draws
        view.tool("windowsize", view.window, 400 + 37 * i % 800, 300 + 53 * i % 700)
        time.sleep(0.03)
    view.keys("space")
    view.tool("windowsize", "--sync", view.window, 640, 500)
    view_window.WIDTH, view_window.HEIGHT = 640, 500
    wait_for_size(view)
    assert view.shot("f").mask().sum() > 500
    view.tool("windowunmap", "--sync", view.window)
    view.tool("windowmap", "--sync", view.window)
    view.focus(view.window)
    wait_until(lambda: view.shot().mask().sum() > 500, "the figure in a window that is back")
    view_window.WIDTH, view_window.HEIGHT = 800, 600


def check_high_density():
    """On a display of 192 dots an inch everything has twice as many pixels, and the pointer still finds it."""
    subprocess.run(["xprop", "-root", "-f", "RESOURCE_MANAGER", "8s", "-set", "RESOURCE_MANAGER", "Xft.dpi: 192"],
                   check=True)
    view = View("x.pnb", "--no-settings", size="700x500")
    assert view.shot().picture.shape == (2 * (500 - TIMELINE), 2 * (700 - panel_of(700)), 3)
    view.drag(1, (2 * (panel_of(700) + 200), 2 * (500 - TIMELINE + 44)), (2 * 690, 2 * (500 - TIMELINE + 44)))
    assert view.shot().frame() == 12, "the timeline is where it is seen"
    view.close()
    subprocess.run(["xprop", "-root", "-remove", "RESOURCE_MANAGER"], check=True)


def check_library():
    """A button adds the materials that come with the player."""
    view = View("x.pnb", "--no-settings", size="1280x800")
    assert not any("matte" in view.shot("m").said for _ in range(4))
    view.move(220, 18)
    view.tool("click", 1)
    wait_until(lambda: "material matte white" in view.shot("m").said, "a material of the library")
    view.close()


def check_sequence(view):
    view.keys("F11")
    lines = [view.process.stdout.readline() for _ in range(13)]
    assert [Shot(None, line, False).frame() for line in lines] == list(range(13)), lines
    pictures = [np.asarray(Image.open("wave_%04d.png" % i), int) for i in range(13)]
    assert all(np.abs(a - b).mean() > 0.01 for a, b in zip(pictures, pictures[1:]))


def check_turntable(view):
    """Shift + F11 writes a whole turn as a video, which ends where it began."""
    before = view.shot()
    view.keys("shift+F11")
    line = view.process.stdout.readline()
    assert line.startswith("./turn_0001.y4m: turntable"), line
    with open("turn_0001.y4m", "rb") as file:
        header, *frames = file.read().split(b"FRAME\n")
    assert header.startswith(b"YUV4MPEG2 ") and len(frames) == 300, (header, len(frames))
    luma = [np.frombuffer(frame, np.uint8)[:before.picture[..., 0].size].astype(int) for frame in frames]
    assert np.abs(luma[0] - luma[150]).mean() > 0.5 and np.abs(luma[0] - luma[299]).mean() < np.abs(luma[0] - luma[150]).mean()
    assert difference(view.shot(), before) < 0.2, "a whole turn"


def check_settings():
    """The window starts with what the run before left: its exposure, no background, its size."""
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
    """Opens the same file twice, and a picture as a light beside the asset's own."""
    with open("red.hdr", "wb") as file:
        file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([128, 64, 64, 129]) * 32)
    said = run("player", "view", "x.pnb", "x.pnb", "red.hdr", "--dry-run").stdout
    assert said == "would show 2 characters, 2 materials, 3 lights\n", said
    view = View("x.pnb", "x.pnb", "red.hdr")
    two = view.shot()
    columns = np.flatnonzero(two.mask().any(0))
    gaps = np.flatnonzero(np.diff(columns) > 5)
    assert len(gaps) == 1, "two figures with a gap between them"
    view.keys(*"oll")  # colours are cut at white, and not bent
    red = view.shot()
    assert "red.hdr" in red.said, red.said
    inside = red.picture[red.mask()].mean(0)
    assert inside[0] > 1.2 * inside[1], inside
    view.close()


def check_pictures():
    """A picture with a sun is factored when it is opened: it shines with a shadow map. Lights fade into one another."""
    for name, sun in (("noon.hdr", (200, 200, 200, 137)), ("dull.hdr", (64, 64, 64, 129))):
        pixels = bytearray(bytes([64, 64, 64, 129]) * 64 * 32)
        pixels[4 * (8 * 64 + 20):4 * (8 * 64 + 21)] = bytes(sun)
        with open(name, "wb") as file:
            file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n" + pixels)
    view = View("x.pnb", "noon.hdr", "dull.hdr", "--no-settings", "--light-fade", "3", "--sun-time", "0.2")
    view.keys("l", "l")  # past the two of the asset
    noon = wait_until(lambda: (shot := view.shot()) and "of the way" not in shot.said and shot, "the light of noon.hdr")
    assert "light noon.hdr" in noon.said and "suns with shadow maps" in noon.said, noon.said
    between = view.shot("l")
    assert "% of the way from noon.hdr)" in between.said and "light dull.hdr" in between.said, between.said
    dull = wait_until(lambda: (shot := view.shot()) and "suns" not in shot.said and shot, "the light of dull.hdr")
    assert "of the way" not in dull.said, dull.said
    # Shortly after the key, the picture is nearer to the light that it leaves.
    assert difference(between, noon) < difference(dull, noon), (difference(between, noon), difference(dull, noon))
    view.close()
    for words in (("--light-fade", "-1"), ("--sun-time", "99")):
        assert run("player", "view", "x.pnb", *words, "--dry-run").returncode == 1, words


def check_exposure():
    """Lights 4000 times as bright or as dark look like the light between them. A fixed exposure stays."""
    for name, exponent in (("bright", 141), ("grey", 129), ("dim", 117)):
        with open(name + ".hdr", "wb") as file:
            file.write(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + bytes([64, 64, 64, exponent]) * 32)
    for path in ("cpu", "glsl"):
        view = View("x.pnb", "bright.hdr", "grey.hdr", "dim.hdr", "--no-settings", "--path", path)
        shots = {}
        for shot in (view.shot("b", "o"), *(view.shot("l") for _ in range(4))):
            shots[shot.said.split("light ")[1].split(",")[0].removesuffix(".hdr")] = shot
        inside = shots["grey"].mask()
        for name in ("bright", "dim"):
            assert np.abs(shots[name].picture - shots["grey"].picture).max() <= 2, (path, name)
        assert 100 < shots["grey"].picture[inside].mean() < 210, (path, shots["grey"].picture[inside].mean())
        fixed = view.shot("e")  # with the last light, dim.hdr
        assert difference(fixed, shots["dim"]) > 0.3, path
        view.keys("l", "l")
        assert "bright" in view.shot("l").said and view.shot().picture[inside].min() > 250, "a fixed exposure stays"
        assert difference(view.shot("shift+e"), shots["bright"]) == 0, "automatic again"
        view.close()


def check_cloth():
    """A sheet with two sides plays, truth beside it looks alike, and from behind its back is seen."""
    sheet = os.path.join(BIN, "..", "samples", "sheet.npz")
    good("bake", "visibility", sheet, "-o", "sheet.vis.h5", "--two-sided", "--rays", 64)
    good("fit", "visibility", "sheet.vis.h5", "-o", "sheet.model.h5", "--parts", 4, "--model", "linear")
    good("pack", "asset", "sheet.model.h5", "--brdf", "lambert.brdf.h5", "--light", "sky.light.h5", "-o", "sheet.pnb")
    good("pack", "truth", "sheet.vis.h5", "-o", "sheet.truth.pnb")
    view = View("sheet.pnb", "--truth", "sheet.truth.pnb", "--no-settings", size="800x600")
    front = view.shot("b")
    assert front.mask().sum() > 2000, front.mask().sum()
    moved = view.shot(*["Right"] * 5)
    assert moved.frame() == 5 and difference(moved, front) > 0.5, moved.said
    assert 0 < difference(view.shot("t"), moved) < 5, "truth looks like the model, but is not it"
    view.keys("t")
    view.drag(1, (330, 250), (780, 250))  # about half a turn
    assert view.shot().mask().sum() > 2000, "the back is there"
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


with prepared():
    check_errors()
    with opened() as (window, _):
        check_window(window)
        check_sequence(window)
        check_turntable(window)
        idle = check_idle(window)
        check_drops(window)
        check_resize(window)
    with open("r.json") as report:
        figures = json.load(report)["figures"]
    print("%d frames, %s, path %s; %.3f of a core while idle" % (figures["frames"], figures["gl"], figures["path"], idle))
    check_settings()
    check_several()
    check_pictures()
    check_exposure()
    check_cloth()
    check_high_density()
    check_library()
    check_managed()  # last: GLFW 3.3 may abort where a window manager has just gone
print("ok")
