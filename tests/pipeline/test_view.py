"""penumbra-player view under Xvfb, driven by keys and mouse through xdotool: it plays, scrubs, switches material, light
and model/truth, and its screenshots change as they should.

usage: test_view.py BIN
"""
import json
import os
import time

import numpy as np
from PIL import Image

from programs import good
from x11_events import DragSource
from view_window import (ERROR, HEIGHT, PANEL, RANGE, ROWS, SCRUB, TIMELINE, WIDTH, View, center, difference, frame_x, make_scene, opened,
                         prepared, wait_until)


def check_plays_and_scrubs(view, first):
    assert first.frame() == 0, first.said
    view.keys("space")
    wait_until(lambda: difference(view.shot(), first) > 0.2, "a moving figure")
    played = view.shot("space")
    assert played.frame() > 0 and difference(first, played) > 0.1, (played.said, difference(first, played))
    again = view.shot()
    assert again.frame() == played.frame() and difference(again, played) == 0, "paused, nothing moves"
    middle = (frame_x(6.5), SCRUB)
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
    at = lambda number: (frame_x(number), SCRUB)
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


def finished_strips(view):
    """The picture with its panels if the strips of the timeline are there and stay as they are."""
    before = view.shot(panels=True)
    time.sleep(0.3)
    after = view.shot(panels=True)
    rows = slice(RANGE - 12, ERROR + 12)
    timeline = after.whole[rows, PANEL:]
    there = all((np.abs(timeline - color).max(-1) < 12).any() for color in ((235, 140, 40), (214, 72, 96)))
    return after if there and np.array_equal(timeline, before.whole[rows, PANEL:]) else None


def check_strips(view, first):
    """The strips of the timeline are filled. A click finds a frame, and a key finds the worst ones."""
    shown = wait_until(lambda: finished_strips(view), "the strips, which are computed while nothing else is to do").whole
    strips = []
    for row, color in ((RANGE, (235, 140, 40)), (ERROR, (214, 72, 96))):
        strip = shown[row - 11:row + 12, ROWS:WIDTH - 8]
        filled = (np.abs(strip - color).max(-1) < 12).sum(0)
        assert filled.any(), (row, "nothing is in the strip")
        cells = [filled[int(i * len(filled) / 13) + 2:int((i + 1) * len(filled) / 13) - 2].max() for i in range(13)]
        strips.append((row, cells))
    worst = view.shot("w")
    assert abs(strips[1][1][int(worst.frame())] - max(strips[1][1])) <= 1, (worst.said, strips)
    far = view.shot("shift+w")
    assert abs(strips[0][1][int(far.frame())] - max(strips[0][1])) <= 1, (far.said, strips)
    view.move(frame_x(7.5), ERROR)
    view.tool("click", 1)
    wait_until(lambda: view.shot().frame() == 7, "the frame of a strip's cell that was clicked")
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
    """Switches the light's forms and the reflectance's: fixed lobes are the exact light again, and three fitted lobes
    nearly."""
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
    assert len(colors) >= 8, colors  # 13 clusters, some of which are hidden
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
    time.sleep(0.3)  # for a turn that must not come
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
    wait_until(lambda: view.shot().mask().sum() > 1.1 * panned.mask().sum(), "the wheel to bring it nearer")
    framed = view.shot("f")
    assert np.abs(center(framed.mask()) - center(orbited.mask())).max() < 3
    before = view.shot()
    view.keys("r")
    wait_until(lambda: difference(view.shot(), before) > 0.5, "the turntable")
    assert difference(view.shot("r"), before) > 0.5, "turntable"


def check_overlays(view):
    """Shows the picked vertex' lobe and figures, lines of normals, and PCA components."""
    plain, panel = view.shot(), view.shot(panels=True)
    y, x = (int(c) for c in center(plain.mask()))
    view.move(PANEL + x, y)
    view.tool("click", 1)
    lobe = lambda: np.abs(view.shot().picture - plain.picture).max(-1) > 30
    wait_until(lambda: lobe().sum() > 150, "the lobe of the picked vertex")
    changed = lobe()
    assert np.abs(center(changed) - [y, x]).max() < 80, (changed.sum(), center(changed), (y, x))
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
    """Returns the first row of every run of rows that have the colour in the side panel, and the columns there."""
    near = np.abs(pixels[:, :PANEL] - color).max(-1) < 12
    rows = np.flatnonzero(near.sum(1) > 20)
    return [(int(r), np.flatnonzero(near[r])) for r in rows if r - 1 not in rows]


def check_components(view):
    """A score moves under its slider: the cluster of the picked vertex changes and nothing else does. Z takes it
    back."""
    plain = view.shot("2")
    y, x = (int(c) for c in center(plain.mask()))
    view.move(PANEL + x, y)
    panel = view.shot(panels=True).whole[:, :PANEL]
    view.tool("click", 1)
    wait_until(lambda: np.abs(view.shot(panels=True).whole[:, :PANEL] - panel).mean() > 1, "numbers of the vertex")
    ranges_shown = lambda: rows_of((120, 200, 120), view.shot(panels=True).whole)
    wait_until(lambda: len(ranges_shown()) >= 2, "training ranges of the components")
    ranges = ranges_shown()
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
    """Keys move the scale's end, clusters have names, frames have three axes, and held-out clips have another
    colour."""
    wide, narrow = view.shot("3"), view.shot("bracketleft", "bracketleft", "bracketleft", "bracketleft")
    assert narrow.picture[narrow.mask()].mean() > wide.picture[wide.mask()].mean() + 1, "smaller errors are brighter"
    legend = view.shot(panels=True)
    assert (legend.picture[:190, -150:].min(-1) > 200).sum() > 60, "numbers and unit beside the scale"
    assert difference(view.shot(*["bracketright"] * 4), wide) < 0.05
    named, bare = view.shot("4", panels=True), view.shot()
    written = np.abs(named.picture - bare.picture).max(-1)[40:] > 60
    assert written.sum() > 150, ("names of clusters", written.sum())
    axes = view.shot("1", "n", panels=True).picture.reshape(-1, 3)
    for color in ((230, 70, 60), (80, 200, 80), (90, 140, 255)):
        assert (np.abs(axes - color).max(-1) < 40).sum() > 20, color
    view.keys("n")
    panel = legend.whole[:, :PANEL]
    assert (panel[..., 0] - panel[..., 2] > 80).sum() > 20, "one clip is held out: its name is yellow"


def check_paths_agree():
    """The GLSL path's window is the CPU path's. It is the default on a GPU."""
    shots = []
    for path in ("cpu", "glsl"):
        view = View("x.pnb", "--truth", "x.truth.pnb", "--path", path)
        shots.append([view.shot(), view.shot("m", "l"), view.shot("t"), view.shot("2"), view.shot("c", "c")])
        view.close()
    for cpu, glsl in zip(*shots):
        rmse = float(np.sqrt(np.mean((cpu.picture - glsl.picture) ** 2.0)))
        assert cpu.said == glsl.said and rmse < 0.5, (cpu.said, glsl.said, rmse)


def check_scene():
    """A scene's ground has shadows that go on and off, and a character that is moved takes its shadow along."""
    make_scene()
    view = View("--scene", "scene.json", "--no-settings", size=f"{WIDTH}x{HEIGHT}")
    shown = view.shot()
    both = view.shot("9")
    assert "direct" in both.said and (shown.picture - both.picture).mean() > 0, "things send light to one another"
    alone, cast, none = view.shot("j"), view.shot("j"), view.shot("j")
    for shot, words in ((alone, "shadows on itself"), (cast, "shadows on others"), (none, "no shadows")):
        assert words in shot.said and difference(both, shot) > 0.2, (shot.said, difference(both, shot))
    assert (none.picture - both.picture).mean() > (none.picture - cast.picture).mean() > 0, "shadows are dark"
    assert difference(view.shot("j"), both) == 0
    for x in range(PANEL + 60, PANEL + 260, 25):  # across the left figure, wherever it is
        view.tool("keydown", "alt")
        view.drag(1, (x, 200), (x - 40, 330))
        view.tool("keyup", "alt")
        moved = view.shot()
        if difference(moved, both) > 1:
            break
    assert difference(moved, both) > 1
    assert difference(view.shot("j", "j", "j", "j"), moved) == 0
    view.close()


def check_who_is_there():
    """A scene that is opened takes the place of what was there, and the x at a name takes its character away."""
    view = View("x.pnb", "--no-settings", size=f"{WIDTH}x{HEIGHT}")
    alone = view.shot("b")
    DragSource(view.window).drop([os.path.abspath("y.pnb")])
    wait_until(lambda: difference(view.shot(), alone) > 0.5, "two side by side")
    two = view.shot()
    for y in range(40, 80, 6):  # the first name is below a row of buttons and a heading; its x is at the right edge
        view.move(PANEL - 30, y)
        view.tool("click", 1)
        view.move(PANEL + 200, 200)
        if difference(view.shot(), two) > 0.5:
            break
    assert 0.5 < difference(view.shot(), two) and difference(view.shot(), alone) < 5, "one of them alone"
    DragSource(view.window).drop([os.path.abspath("scene.json")])
    staged = wait_until(lambda: (shot := view.shot()) and difference(shot, alone) > 2 and shot, "the scene")
    view.close()
    view = View("--scene", "scene.json", "--no-settings", size=f"{WIDTH}x{HEIGHT}")
    assert difference(view.shot("b"), staged) < 0.5, "as if it had been opened alone"
    view.close()


def fix_camera(name, **changes):
    with open("scene.json") as file:
        fixed = {**json.load(file), "camera": "yaw=10,pitch=25,target=0/0.6/0,distance=5", **changes}
    with open(name, "w") as file:
        json.dump(fixed, file)


def share_like_render(scene, shot):
    """Draws the scene without a window. Returns the share of the pixels of its middle that are within 5 steps in the
    shot, which has no background."""
    size = f"{shot.picture.shape[1]}x{shot.picture.shape[0]}"
    good("player", "render", "--scene", scene, "--size", size, "--gl", "osmesa", "--aa", 1, "--tone", "filmic", "-o", "drawn.png")
    drawn = np.asarray(Image.open("drawn.png").convert("RGBA"), int)
    covered = drawn[..., 3] == 255
    side = covered.shape[1] // 4  # where the ground of the window fades
    covered[:, :side] = covered[:, -side:] = False
    off = np.abs(shot.picture - drawn[..., :3]).max(-1)[covered]
    share = float((off < 6).mean())
    print(f"the window beside render: {covered.sum()} pixels, {np.median(off):.0f} steps off at the median, {share:.3f} within 5")
    assert covered.sum() > 50000
    return share


def check_same_as_render():
    """The window chooses the exposure that render chooses, the ground's share of the picture included. A fifth of the
    light is taken off every other tile of its grid."""
    fix_camera("fixed.json")
    view = View("--scene", "fixed.json", "--no-settings", size=f"{WIDTH}x{HEIGHT}")
    shown = view.shot("b")
    view.close()
    assert share_like_render("fixed.json", shown) > 0.5


def turned_sun(view, before):
    """Turns the light, again if the window has missed the drag."""
    view.drag(3, (550, 100), (650, 100))
    shot = view.shot()
    return shot if difference(shot, before) > 1 else None


def check_suns():
    """The suns of the light shine as in render, on both paths. Their shadows go with the light, and H takes them
    away."""
    good("fit", "light", "--analytic", "uniform", "--analytic", "sun:direction=-0.6/1/0.5,irradiance=4", "--factor",
         "--name", "sunny", "-o", "sunny.light.h5")
    good("pack", "asset", "y.model.h5", "--brdf", "lambert.brdf.h5", "--light", "sunny.light.h5", "-o", "sunny.pnb")
    with open("scene.json") as file:
        people = [{**one, "asset": "sunny.pnb"} for one in json.load(file)["characters"]]
    fix_camera("sunny.json", characters=people)
    shots = []
    for path in ("cpu", "glsl"):
        view = View("--scene", "sunny.json", "--no-settings", "--path", path, size=f"{WIDTH}x{HEIGHT}")
        shots.append(view.shot("b"))
        assert "suns with shadow maps" in shots[-1].said, shots[-1].said
        if path == "cpu":
            soft = view.shot("h")
            assert "suns" not in soft.said and difference(soft, shots[0]) > 1, (soft.said, difference(soft, shots[0]))
            assert difference(view.shot("h"), shots[0]) == 0
            turned = wait_until(lambda: turned_sun(view, shots[0]), "another sun")
            assert "suns" in turned.said
            assert np.abs(view.shot("k").picture - shots[0].picture).max() <= 1, "turned back, but for rounding"
        view.close()
    assert difference(*shots) < 0.01, "both paths have the values of the CPU"
    share = share_like_render("sunny.json", shots[0])
    assert share > 0.5 and share_like_render("sunny.json", soft) < share - 0.08, share  # measured: 0.637 and 0.532


with prepared():
    with opened() as (window, start):
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
    check_paths_agree()
    check_scene()
    check_who_is_there()
    check_same_as_render()
    check_suns()
print("ok")
