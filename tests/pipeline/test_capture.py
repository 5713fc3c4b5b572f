"""penumbra-fit capture as a user runs it: pictures of a mirror ball, and all around, that are made here by formulas.

A sky, a sun of 2 degrees and a ground with a sheet of white paper, whose light is known in closed form."""
import json
import pathlib
import struct
import sys
import tempfile
import zlib

import numpy as np

from programs import digest, good, run_tool

SUN = np.array([-0.5, -0.4, 0.76]) / np.linalg.norm([-0.5, -0.4, 0.76])
RADIUS = np.radians(2)
SUN_IRRADIANCE = np.array([4.0, 3.6, 3.0])  # at normal incidence
SKY = np.array([0.5, 0.6, 0.8])
GROUND = np.pi * SKY + SUN[2] * SUN_IRRADIANCE  # irradiance on the ground
PAPER = 0.8
BALL, BALL_RADIUS, REFLECTANCE = np.array([-0.6, 0.2, 0.25]), 0.25, 0.7
CAMERA = {"f": 300, "cx": 79.5, "cy": 59.5, "size": [160, 120], "k1": -0.05, "k2": 0}
WIDE = {"f": 80, "cx": 79.5, "cy": 59.5, "size": [160, 120], "k1": 0, "k2": 0}
EXPOSURES = [0.5 / 8**i for i in range(5)]


def write_png(path, rgb):
    height, width, _ = rgb.shape
    rows = np.concatenate([np.zeros((height, 1), np.uint8), rgb.reshape(height, -1)], 1).tobytes()

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)) +
                     chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def looking(eye, target):
    """R and t of a level camera."""
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1])
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(forward, right), forward])
    return rotation, -rotation @ np.asarray(eye)


def radiance(start, ray):
    """Returns the radiance seen along rays [.., 3]."""
    down = ray[..., 2] < -1e-6
    distance = np.where(down, -start[..., 2] / np.where(down, ray[..., 2], -1), 0)
    place = start + distance[..., None] * ray
    side = np.maximum(np.abs(place[..., 0]), np.abs(place[..., 1]))
    albedo = np.where(side < 0.2, 0.04, np.where(side < 0.25, PAPER, 0.35))[..., None]
    sun = (ray @ SUN > np.cos(RADIUS))[..., None] * SUN_IRRADIANCE / (2 * np.pi * (1 - np.cos(RADIUS)))
    return np.where(down[..., None], albedo * GROUND / np.pi, SKY + sun)


def photograph(camera, rotation, t, ball=True, samples=4):
    """Linear picture [height, width, 3], the mean of samples^2 rays a pixel."""
    width, height = camera["size"]
    total = 0
    for j in range(samples):
        for i in range(samples):
            x, y = np.meshgrid(np.arange(width) + (i + 0.5) / samples - 0.5, np.arange(height) + (j + 0.5) / samples - 0.5)
            x, y = (x - camera["cx"]) / camera["f"], (y - camera["cy"]) / camera["f"]
            scale = np.ones_like(x)
            for _ in range(20):
                square = (x * x + y * y) * scale**2
                scale = 1 / (1 + camera["k1"] * square + camera["k2"] * square**2)
            ray = np.stack([x * scale, y * scale, np.ones_like(x)], -1)
            ray = ray / np.linalg.norm(ray, axis=-1, keepdims=True) @ rotation
            eye = np.broadcast_to(-rotation.T @ t, ray.shape)
            seen = radiance(eye, ray)
            if ball:
                along = ray @ BALL - np.sum(eye * ray, -1)
                squared = along**2 - np.sum((BALL - eye) ** 2, -1) + BALL_RADIUS**2
                hit = squared > 0
                place = eye + (along - np.sqrt(np.where(hit, squared, 0)))[..., None] * ray
                normal = (place - BALL) / BALL_RADIUS
                mirrored = ray - 2 * np.sum(ray * normal, -1, keepdims=True) * normal
                seen = np.where(hit[..., None], REFLECTANCE * radiance(place, mirrored), seen)
            total = total + seen
    return total / samples**2


def develop(path, picture, exposure):
    write_png(path, np.round(255 * np.clip(picture * exposure, 0, 1)).astype(np.uint8))


def make_ball(folder):
    rotation, t = looking([-0.3, -1.5, 0.8], [-0.4, 0.05, 0.25])
    picture = photograph(CAMERA, rotation, t)
    pictures = []
    for i, exposure in enumerate(EXPOSURES):
        develop(folder / f"ball{i}.png", picture, exposure)
        pictures.append({"file": f"ball{i}.png", "exposure": exposure})
    return {"camera": CAMERA, "response": "linear", "R": rotation.tolist(), "t": t.tolist(), "pictures": pictures}


def make_roam(folder):
    pictures = []
    for i, (up, turn) in enumerate([(up, turn) for up in (-1.5, -0.3, 0.8) for turn in range(6)] + [(5, 0), (-5, 0)]):
        eye = np.array([0.05 * np.cos(turn), 0.05 * np.sin(turn), 0.9])
        rotation, t = looking(eye, eye + [np.cos(turn * np.pi / 3 + 0.2), np.sin(turn * np.pi / 3 + 0.2), up])
        picture = photograph(WIDE, rotation, t, ball=False, samples=2)
        for name, exposure in (("long", 0.5), ("short", 0.02)):
            develop(folder / f"{name}{i}.png", picture, exposure)
            pictures.append({"file": f"{name}{i}.png", "exposure": exposure, "R": rotation.tolist(), "t": t.tolist()})
    return {"camera": WIDE, "response": "linear", "pictures": pictures}


def write(path, content):
    path.write_text(json.dumps(content))
    return path


def figures(path):
    return json.loads(path.read_text())["figures"]


def capture(folder, way, content, *more):
    """Captures, and returns the figures and what was said on stderr."""
    source = write(folder / "list.json", content)
    done = good("fit", "capture", way, source, "--at", "0/0/0.9", "-o", folder / "e.exr", "--report", folder / "r.json", *more)
    return figures(folder / "r.json"), done.stderr


OPTION = ["--ball", f"-0.6/0.2/0.25,{BALL_RADIUS},{REFLECTANCE}"]
TAG = ["--tag", "36h11:0:0.4", "--paper", PAPER]


def error_of(figures_, wanted=GROUND):
    return np.abs(np.array(figures_["irradiance"]) / wanted - 1).max()


def check_sun(folder, most_degrees, most_error):
    good("fit", "light", folder / "e.exr", "-o", folder / "e.light.h5", "--factor", "--order", 6, "--lobes", 0, "--report",
         folder / "l.json")
    sun = figures(folder / "l.json")["suns"][0]
    scene = [SUN[0], SUN[2], -SUN[1]]
    away = np.degrees(np.arccos(np.dot(sun["direction"], scene)))
    error = np.abs(np.array(sun["irradiance"]) / SUN_IRRADIANCE - 1).max()
    assert away < most_degrees and error < most_error, (away, error)
    return away, error


def check_ball(folder, bracket):
    found, said = capture(folder, "ball", bracket, *OPTION)
    assert said == "", said
    assert error_of(found) < 0.05, found
    assert found["clipped_share"] == 0 and found["uncertain_irradiance"] == 0 and found["covered_share"] > 0.95, found
    assert found["missing_stops"] == {"shorter": 0, "longer": 0}, found
    away, error = check_sun(folder, 1, 0.12)
    print(f"ball: irradiance on the ground within {100 * error_of(found):.1f}%, sun {away:.2f} degrees off, its irradiance "
          f"within {100 * error:.1f}%")
    first = digest(folder / "e.exr")
    for threads in (1, 3):
        capture(folder, "ball", bracket, *OPTION, "--threads", threads)
        assert digest(folder / "e.exr") == first, "other threads, other bytes"


def check_clipped(folder, bracket):
    """Without its shortest exposures the sun is clipped: the report says so, and paper gives the light back."""
    short = dict(bracket, pictures=bracket["pictures"][:3])
    found, said = capture(folder, "ball", short, *OPTION)
    assert found["clipped_share"] > 0 and found["uncertain_irradiance"] > 0.1, found
    assert found["missing_stops"]["shorter"] >= 3, found
    assert "is only a lower bound" in said and "stops less" in said, said
    assert error_of(found) > 0.2, found
    # The paper, which is seen but not asked to raise anything, tells how much is missing.
    found, said = capture(folder, "ball", short, *OPTION, *TAG[:2])
    assert abs(found["missing_by_paper"] - error_of(found)) < 0.1 and "is missing in what is clipped" in said, (found, said)
    found, said = capture(folder, "ball", short, *OPTION, *TAG)
    wanted = np.array(found["raised"]["irradiance_of_paper"])
    assert np.abs(wanted / GROUND - 1).max() < 0.05, found
    assert "lower bound" not in said, said
    away, error = check_sun(folder, 1, 0.12)
    print(f"clipped: told, and after the paper the sun's irradiance is within {100 * error:.1f}%")


def check_roam(folder, shots):
    found, _ = capture(folder, "roam", shots)
    assert found["clipped_share"] > 0 and error_of(found) > 0.2, found
    # Poses of a file by the names of pictures, the camera of a cam.json, and one direction that shows white alone.
    frames = [{"file": "in/" + p["file"], "R": p["R"], "t": p["t"]} for p in shots["pictures"]]
    write(folder / "poses.json", {"format": "penumbra.camera_poses", "camera": WIDE, "frames": frames})
    write(folder / "cam.json", {"format": "penumbra.camera", "version": 1} | WIDE)
    write_png(folder / "white.png", np.full((120, 160, 3), 255, np.uint8))
    bare = [{"file": p["file"], "exposure": p["exposure"]} for p in shots["pictures"]]
    first = digest(folder / "e.exr")
    for camera in ({}, {"camera": "cam.json"}, {"camera": json.loads((folder / "cam.json").read_text())}):
        capture(folder, "roam", {"response": "linear", "poses": "poses.json", "pictures": bare} | camera)
        assert digest(folder / "e.exr") == first, camera
    capture(folder, "roam", dict(shots, pictures=shots["pictures"] + [dict(shots["pictures"][0], file="white.png",
                                                                           t=[0.1, 0.2, 0.3])]))
    found, said = capture(folder, "roam", shots, *TAG)
    assert np.abs(np.array(found["raised"]["irradiance_of_paper"]) / GROUND - 1).max() < 0.02, found
    away, error = check_sun(folder, 0.5, 0.12)
    print(f"roam: sun {away:.2f} degrees off, its irradiance within {100 * error:.1f}%")


def check_refusals(folder, bracket, shots):
    """Names what is wrong, and writes nothing."""
    out = folder / "none.exr"

    def refused(code, part, way, content, *more, at="0/0/0.9"):
        source = write(folder / "bad.json", content)
        done = run_tool("fit", "capture", way, source, "--at", at, "-o", out, *more)
        assert done.returncode == code and part in done.stderr, (part, done.returncode, done.stderr)
        assert not out.exists() and not list(folder.glob("none.exr*")), part

    pictures = bracket["pictures"]
    white = np.full((120, 160, 3), 255, np.uint8)
    write_png(folder / "white0.png", white)
    write_png(folder / "white1.png", white - 1)
    write_png(folder / "small.png", white[:60])
    named = [{"file": f"white{i}.png", "exposure": 1 / (1 + i)} for i in (0, 1)]
    refused(3, "clipped everywhere", "ball", dict(bracket, pictures=named), *OPTION)
    refused(3, "small.png: has 160 x 60 pixels, and the camera has 160 x 120", "ball",
            dict(bracket, pictures=pictures[:2] + [{"file": "small.png", "exposure": 1e-4}]), *OPTION)
    refused(3, "/pictures/1/exposure", "ball", dict(bracket, pictures=[pictures[0], dict(pictures[1], exposure=0.5)]), *OPTION)
    faint = [dict(p, exposure=1e8 * p["exposure"]) for p in pictures]
    refused(3, "less than half floats hold", "ball", dict(bracket, pictures=faint), *OPTION)
    refused(3, "exposures are out of order", "ball",
            dict(bracket, pictures=[dict(pictures[1], exposure=0.5), dict(pictures[0], exposure=0.06)]), *OPTION)
    refused(3, "have the same exposure", "roam",
            dict(shots, pictures=[shots["pictures"][0], shots["pictures"][0]]))
    refused(3, "the ball is out of the picture", "ball", bracket, "--ball", "5/0.2/0.25,0.25")
    refused(3, "the camera stands inside of the ball", "ball", bracket, "--ball", "-0.3/-1.5/0.25,0.8")
    refused(3, "/t/1", "ball", dict(bracket, t=[0, 1e300, 1]), *OPTION)
    refused(3, "not JSON", "ball", dict(bracket, t=[0, float("nan"), 1]), *OPTION)
    refused(3, "is not a rotation", "roam", dict(shots, pictures=[dict(shots["pictures"][0], R=[[1, 0, 0], [0, 1, 0], [0, 0, -1]])]))
    refused(3, "neither", "ball", {key: value for key, value in bracket.items() if key not in "Rt"}, *OPTION)
    refused(1, "--ball", "ball", bracket)
    refused(1, "--ball", "roam", shots, *OPTION)
    refused(1, "--tag", "roam", shots, "--paper", 0.8)
    refused(1, "above the ground", "ball", bracket, *OPTION, at="0/0/0")
    refused(3, "find", "roam", dict(shots, response="find"))
    refused(3, "every picture is clipped everywhere", "roam",
            dict(shots, pictures=[dict(shots["pictures"][0], file="white0.png")]))
    refused(3, "no frame of \"poses\" that has a pose is called white0.png", "roam",
            dict(shots, poses="poses.json", pictures=[{"file": "white0.png", "exposure": 1}]))
    sky = [p for p in shots["pictures"] if p["file"].endswith("18.png")]
    refused(3, "no picture shows the paper", "roam", dict(shots, pictures=sky), *TAG)
    print("refusals: named, nothing written")


with tempfile.TemporaryDirectory() as name:
    work = pathlib.Path(name)
    ball, around = make_ball(work), make_roam(work)
    check_ball(work, ball)
    check_clipped(work, ball)
    check_roam(work, around)
    check_refusals(work, ball, around)
sys.exit(0)
