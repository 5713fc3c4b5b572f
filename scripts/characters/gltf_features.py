"""The features of a glTF file that change the picture, read from its JSON alone."""
import json
import pathlib
import struct

# Extensions that only change colours, lights or what a user may do: they move nothing and block no ray.
HARMLESS = ("KHR_materials_", "KHR_lights_", "KHR_texture_", "EXT_texture_", "EXT_lights_", "KHR_xmp", "KHR_audio",
            "MSFT_texture_", "MSFT_packing_", "EXT_mesh_features", "EXT_structural_metadata", "VRMC_materials_mtoon",
            "VRMC_vrm", "VRMC_springBone", "VRMC_node_constraint", "VRM", "FB_ngon_encoding", "MOZ_", "NEEDLE_",
            "MSFT_lod", "MSFT_audio", "EXT_mesh_manifold", "KHR_techniques_webgl", "GODOT_", "EXTRAS_", "AGI_",
            "CESIUM_", "ADOBE_", "OMI_", "KHR_node_hoverability", "KHR_node_selectability", "KHR_interactivity")
# Encodings: a reader that does not know them cannot read the file at all.
ENCODINGS = ("KHR_mesh_quantization", "EXT_meshopt_compression", "KHR_meshopt_compression",
             "KHR_draco_mesh_compression")
# A feature, and the words of which a note about it has at least one.
WORDS = {
    "morphs": ("morph", "target"),
    "weights clip": ("morph", "weight"),
    "MASK": ("alpha",),
    "BLEND": ("alpha", "blend"),
    "doubleSided": ("side",),
    "hidden nodes": ("visib", "hidden"),
    "instancing": ("instanc",),
    "pointer clip": ("pointer",),
    "LODs": ("lod",),
    "several skeletons": ("skelet", "skin"),
    "more than 8 influences": ("influence", "weight"),
}


def read_json(path):
    """The JSON of a .glb, .vrm or .gltf file. Raises ValueError where there is none."""
    data = pathlib.Path(path).read_bytes()
    if data[:4] == b"glTF":
        if len(data) < 20:
            raise ValueError("cut short")
        data = data[20:20 + struct.unpack_from("<I", data, 12)[0]]
    return json.loads(data.decode("utf-8-sig"))


def primitives(scene):
    return [p for mesh in scene.get("meshes", []) for p in mesh.get("primitives", [])]


def has_extension(scene, kind, name):
    return any(name in item.get("extensions", {}) for item in scene.get(kind, []))


def of_meshes(scene):
    found = set()
    if any(p.get("targets") for p in primitives(scene)):
        found.add("morphs")
    if any(f"JOINTS_{n}" in p.get("attributes", {}) for p in primitives(scene) for n in range(2, 8)):
        found.add("more than 8 influences")
    used = {p.get("material", -1) for p in primitives(scene)}
    for number, material in enumerate(scene.get("materials", [])):
        if number in used:
            found |= {material.get("alphaMode", "OPAQUE")} & {"MASK", "BLEND"}
            found |= {"doubleSided"} if material.get("doubleSided") else set()
    return found


def of_nodes(scene):
    names = {"hidden nodes": "KHR_node_visibility", "instancing": "EXT_mesh_gpu_instancing", "LODs": "MSFT_lod"}
    return {feature for feature, name in names.items() if has_extension(scene, "nodes", name)}


def of_clips(scene):
    paths = {c.get("target", {}).get("path") for clip in scene.get("animations", []) for c in clip.get("channels", [])}
    return {feature for feature, path in (("weights clip", "weights"), ("pointer clip", "pointer")) if path in paths}


def features(scene):
    """Sorted names of WORDS that the file has, and 'extension NAME' for those that nothing here knows."""
    known = {"KHR_node_visibility", "EXT_mesh_gpu_instancing", "KHR_animation_pointer", "MSFT_lod", *ENCODINGS}
    unknown = {f"extension {name}" for name in scene.get("extensionsUsed", [])
               if name not in known and not name.startswith(HARMLESS)}
    return sorted(of_meshes(scene) | of_nodes(scene) | of_clips(scene) | unknown)


def clip_names(scene):
    return [clip.get("name") or f"clip{number}" for number, clip in enumerate(scene.get("animations", []))]


def untold(found, handled, notes):
    """Returns the features of a file that the programs neither honour (`handled`) nor tell in a note."""
    text = " ".join(notes).lower()
    return [f for f in found if f not in handled
            and not any(word in text for word in WORDS.get(f, (f.split()[-1].lower(),)))]
