"""Reads and writes the description of a .glb, for tests that change a sample."""
import json
import struct


def read_glb(path):
    with open(path, "rb") as file:
        data = file.read()
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20:20 + length]), data[20 + length:]


def write_glb(path, description, rest):
    text = json.dumps(description).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(b"glTF" + struct.pack("<3I", 2, 20 + len(text) + len(rest), len(text)) + b"JSON" + text + rest)
