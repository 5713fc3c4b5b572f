"""Evaluates every frame of an asset through the C interface, by ctypes and NumPy, and prints how open its vertices are:

    LD_LIBRARY_PATH=PREFIX/lib python3 ambient.py character.pnb

docs/c-api.md explains the calls. Structures repeat those of penumbra.h, member by member.
"""
import ctypes
import sys
from ctypes import POINTER, byref, c_char, c_char_p, c_float, c_int, c_size_t, c_void_p

import numpy as np


class Error(ctypes.Structure):
    _fields_ = [("status", c_int), ("message", c_char * 508)]


class AssetInfo(ctypes.Structure):
    _fields_ = [
        ("has_model", c_int), ("provenance", c_char_p),
        ("vertex_count", c_size_t), ("source_vertex_count", c_size_t), ("triangle_count", c_size_t),
        ("rest_positions", c_void_p), ("rest_normals", c_void_p), ("rest_tangents", c_void_p),
        ("triangles", c_void_p), ("source_vertex", c_void_p),
        ("influence_count", c_size_t), ("skin_joints", c_void_p), ("skin_weights", c_void_p),
        ("slot_count", c_size_t), ("slot_of_vertex", c_void_p),
        ("deforming", c_int), ("two_sided", c_int), ("has_playback", c_int), ("input_count", c_size_t),
        ("joint_count", c_size_t), ("joint_parents", c_void_p), ("rest_transforms", c_void_p), ("inverse_bind", c_void_p),
        ("clip_count", c_size_t), ("frame_count", c_size_t), ("rotation_count", c_size_t),
        ("convention", c_char_p), ("coefficient_count", c_size_t), ("stride", c_size_t), ("cluster_count", c_size_t),
        ("score_count", c_size_t), ("quantization_error", c_float), ("material_count", c_size_t), ("light_count", c_size_t),
    ]


class Vertices(ctypes.Structure):
    _fields_ = [(name, c_void_p) for name in ("positions", "normals", "tangents", "coefficients", "bounced")]
    _fields_ += [("first", c_size_t), ("count", c_size_t), ("received", c_void_p)]


library = ctypes.CDLL("libpenumbra.so.0")


def call(name, *arguments):
    """A function that can fail. A ctypes.c_size_t is as wide as the function expects, a plain number is not."""
    error = Error()
    if getattr(library, "penumbra_" + name)(*arguments, byref(error)) != 0:
        sys.exit("ambient: " + error.message.decode())


def main(path):
    asset, character, info = c_void_p(), c_void_p(), AssetInfo()
    call("asset_open_file", path.encode(), byref(asset))
    library.penumbra_asset_get_info(asset, byref(info))
    call("character_create", asset, byref(character))
    # The library writes into arrays of ours, which must stay alive while `vertices` points to them.
    positions, normals, tangents = (np.empty((info.vertex_count, 3), np.float32) for _ in range(3))
    coefficients = np.empty((info.vertex_count, info.stride), np.float32)
    ambient = np.empty(info.vertex_count, np.float32)
    arrays = (positions, normals, tangents, coefficients)
    vertices = Vertices(*(a.ctypes.data for a in arrays), None, 0, info.vertex_count, None)
    for frame in range(info.frame_count):
        call("character_set_frame", character, c_size_t(frame))
        call("character_evaluate", character, c_size_t(0), c_size_t(info.cluster_count), byref(vertices))
        call("character_skin", character, byref(vertices))
        call("character_ambient", character, byref(vertices), ambient.ctypes.data_as(POINTER(c_float)))
        print(f"frame {frame}: mean ambient {ambient.mean():.4f}, least {ambient.min():.4f}, top {positions[:, 1].max():.3f} m")
    library.penumbra_character_destroy(character)
    library.penumbra_asset_close(asset)


if __name__ == "__main__":
    main(sys.argv[1])
