"""Reads OpenEXR pictures of scan lines, uncompressed or with ZIP: half or float channels as [height, width,
channels]."""
import struct
import zlib

import numpy as np

TYPES = {0: np.uint32, 1: np.float16, 2: np.float32}


def _attributes(data):
    at, found = 8, {}
    while data[at]:
        name, at = data[at:data.index(0, at)].decode(), data.index(0, at) + 1
        at = data.index(0, at) + 1  # the type's name
        size, = struct.unpack_from("<i", data, at)
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def _unpacked(block, size):
    if len(block) == size:
        return block
    shuffled = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
    shuffled[1:] -= 128
    bytes_ = (np.cumsum(shuffled) & 255).astype(np.uint8)
    out, half = np.empty(size, np.uint8), (size + 1) // 2
    out[0::2], out[1::2] = bytes_[:half], bytes_[half:]
    return out.tobytes()


def read_exr(path, channels="RGB"):
    data = open(path, "rb").read()
    found, at = _attributes(data)
    compression = found["compression"][0]
    if compression not in (0, 2, 3):
        raise ValueError(f"{path}: compression {compression} is not read")
    x0, y0, x1, y1 = struct.unpack("<4i", found["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    names, kinds, c = [], [], 0
    listed = found["channels"]
    while listed[c]:
        end = listed.index(0, c)
        names.append(listed[c:end].decode())
        kinds.append(np.dtype(TYPES[struct.unpack_from("<i", listed, end + 1)[0]]))
        c = end + 17
    lines = {0: 1, 2: 1, 3: 16}[compression]
    row_bytes = width * sum(k.itemsize for k in kinds)
    out = np.zeros((height, width, len(channels)))
    for offset in struct.unpack_from(f"<{-(-height // lines)}Q", data, at):
        y, size = struct.unpack_from("<ii", data, offset)
        count = min(lines, y1 - y + 1)
        block = _unpacked(data[offset + 8:offset + 8 + size], count * row_bytes)
        place = 0
        for row in range(count):
            for name, kind in zip(names, kinds):
                if name in channels:
                    out[y - y0 + row, :, channels.index(name)] = np.frombuffer(block, kind, width, place)
                place += width * kind.itemsize
    return out
