"""The little of .glb files that the add-on reads and writes: the vertex numbers it exported, and names."""
import json
import struct

import numpy as np

from .programs import Failed

TYPES = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
VERTEX = "_pnb_vertex"  # attribute of the exported meshes: the number of the vertex in Blender


def chunks(path):
    """The JSON of a .glb as a dictionary, and its binary chunk."""
    with open(path, "rb") as file:
        data = file.read()
    if len(data) < 20 or data[:4] != b"glTF":
        raise Failed(f"{path}: the exporter wrote no .glb")
    size = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def rename(path, of_objects, of_data, clips):
    """Gives nodes, meshes and clips the names of what they stand for. Everything else stays, as bones do.

    Objects and their data are two dictionaries, because a mesh may have the name of another object. Exporters call a
    skin by the object of its armature, or by its data.
    """
    content, binary = chunks(path)
    skins = content.get("skins", ())
    joints = {number for skin in skins for number in skin["joints"]}
    of_skins = {**of_data, **of_objects}
    for kind, known in (("nodes", of_objects), ("meshes", of_data), ("skins", of_skins), ("animations", clips)):
        for number, entry in enumerate(content.get(kind, ())):
            if entry.get("name") in known and not (kind == "nodes" and number in joints):
                entry["name"] = known[entry["name"]]
    text = json.dumps(content, ensure_ascii=False).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(binary))
    with open(path, "wb") as file:
        file.write(head + struct.pack("<II", len(text), 0x4E4F534A) + text)
        file.write(struct.pack("<II", len(binary), 0x004E4942) + binary)


def numbers(content, binary, index):
    """The values of an accessor of scalars."""
    accessor = content["accessors"][index]
    view = content["bufferViews"][accessor["bufferView"]]
    kind = np.dtype(TYPES[accessor["componentType"]])
    start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    stride = view.get("byteStride", kind.itemsize)
    raw = np.ndarray((accessor["count"],), kind, binary, start, (stride,))
    return np.rint(raw).astype(np.int64)


def vertex_numbers(path, without=()):
    """Blender's number of each source vertex [R], in the order of the programs: nodes of the file, then primitives."""
    content, binary = chunks(path)
    found = []
    for node in content["nodes"]:
        if "mesh" not in node or node.get("name") in without:
            continue
        for primitive in content["meshes"][node["mesh"]]["primitives"]:
            if primitive.get("mode", 4) < 4:
                continue
            key = next((k for k in primitive["attributes"] if k.lower().endswith(VERTEX)), None)
            if key is None:
                raise Failed(f"{path}: the exporter left out the attribute {VERTEX}")
            found.append(numbers(content, binary, primitive["attributes"][key]))
    return np.concatenate(found)


def clip_order(path):
    return [animation.get("name") for animation in chunks(path)[0].get("animations", ())]
