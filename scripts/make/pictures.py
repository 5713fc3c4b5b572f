"""Tells what is in a picture: its size and channels from its head, and as a light its mean radiance and its brightest
place."""
import json
import math
import os
import re
import struct
import tempfile

from make import programs
from make.failure import INVALID, UNREADABLE, Failure

PNG_CHANNELS = {0: "grey", 2: "red, green, blue", 3: "palette", 4: "grey, alpha", 6: "red, green, blue, alpha"}


def head_of(path, size=1 << 16):
    try:
        with open(path, "rb") as file:
            return file.read(size)
    except OSError as error:
        raise Failure(f"{path}: {error.strerror}", UNREADABLE) from None


def kind_of(path):
    """Returns what reads the head of a picture, or None for any other file."""
    start = head_of(path)[:12]
    kinds = {b"\x89PNG\r\n\x1a\n": png, b"\x76\x2f\x31\x01": exr, b"#?": hdr, b"\xff\xd8\xff": jpeg}
    return next((reader for magic, reader in kinds.items() if start.startswith(magic)), None)


def png(head):
    width, height, bits, colours = struct.unpack(">IIBB", head[16:26])
    return {"kind": "PNG", "size": (width, height), "channels": PNG_CHANNELS[colours], "bits": bits}


def jpeg(head):
    at = 2
    while head[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + struct.unpack(">H", head[at + 2:at + 4])[0]
    bits, height, width, count = struct.unpack(">BHHB", head[at + 4:at + 10])
    return {"kind": "JPEG", "size": (width, height), "channels": "grey" if count == 1 else "red, green, blue", "bits": bits}


def hdr(head):
    found = re.search(rb"[-+]([XY]) (\d+) [-+]([XY]) (\d+)\n", head)
    sides = {found[1]: int(found[2]), found[3]: int(found[4])}
    return {"kind": "Radiance HDR", "size": (sides[b"X"], sides[b"Y"]), "channels": "red, green, blue", "bits": 32}


def exr(head):
    at, found = 8, {}
    while head[at]:
        end = head.index(b"\0", at)
        name, at = head[at:end], head.index(b"\0", end + 1) + 1
        size = struct.unpack("<i", head[at:at + 4])[0]
        found[name.decode()] = head[at + 4:at + 4 + size]
        at += 4 + size
    channels, names, bits = found["channels"], [], set()
    while channels[0]:
        name, channels = channels.split(b"\0", 1)
        bits.add({1: 16}.get(struct.unpack("<i", channels[:4])[0], 32))
        names.append(name.decode())
        channels = channels[16:]
    low_x, low_y, high_x, high_y = struct.unpack("<4i", found["dataWindow"])
    return {"kind": "OpenEXR", "size": (high_x - low_x + 1, high_y - low_y + 1), "channels": ", ".join(names), "bits": max(bits)}


def angles(direction):
    x, y, z = direction
    return f"elevation {math.degrees(math.asin(max(-1, min(1, y)))):.0f}, azimuth {math.degrees(math.atan2(z, x)):.0f} degrees"


def as_light(path):
    """Returns lines about the picture as a light, by `penumbra-fit light`."""
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")
        done = programs.ask(programs.find("penumbra-fit"), "light", path, "--factor", "-o", os.path.join(folder, "x.light.h5"),
                            "--report", report)
        if done.returncode != 0:
            return [("as a light", "no: " + programs.complaint(done).removeprefix(f"penumbra-fit: {path}: "))]
        with open(report) as file:
            figures = json.load(file)["figures"]
        lobes = programs.ask(programs.find("penumbra-bake"), "info", os.path.join(folder, "x.light.h5"), "--report", report)
        with open(report) as file:
            lobes = json.load(file)["figures"].get("lobes", {}).get("directions", [])
    suns = [sun["direction"] for sun in figures.get("suns", [])]
    lines = [("mean radiance", " ".join(f"{value:.4g}" for value in figures["mean_radiance"]))]
    for name, found in (("sun", suns), ("brightest lobe", lobes[:1])):
        lines += [(name, f"{direction[0]:.3f} {direction[1]:.3f} {direction[2]:.3f} ({angles(direction)})") for direction in found]
    return lines


def describe(path):
    """Returns the lines about a picture, or None for any other file."""
    reader = kind_of(path)
    if reader is None:
        return None
    try:
        found = reader(head_of(path, 1 << 26))  # cameras put previews before the size
    except (struct.error, IndexError, KeyError, TypeError, ValueError, UnicodeDecodeError):
        raise Failure(f"{path}: its head is damaged or cut short", INVALID) from None
    width, height = found["size"]
    lines = [("file", path), ("bytes", os.path.getsize(path)), ("format", found["kind"]), ("size", f"{width} x {height}"),
             ("channels", found["channels"]), ("bits", found["bits"])]
    return lines + (as_light(path) if found["kind"] in ("OpenEXR", "Radiance HDR") else [])
