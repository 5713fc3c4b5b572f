"""Times of a frame in node beside those of libpenumbra, on one thread, in one run.

usage: web_times.py BIN PACKAGE ASSET.pnb...   (PACKAGE: see docs/web.md)
"""
import ctypes
import os
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "pipeline"))
from test_web_runtime import LIBRARY, Error, Vertices

ROUNDS, STEP = 6, 3  # the same values as in web_times.mjs


def native_ms(path, simd):
    """Milliseconds of a frame: pose, evaluation, skin, E."""
    lib, size, error = ctypes.CDLL(LIBRARY), ctypes.c_size_t, Error()
    asset, character, info = ctypes.c_void_p(), ctypes.c_void_p(), (ctypes.c_size_t * 40)()
    assert lib.penumbra_asset_open_file(path.encode(), ctypes.byref(asset), ctypes.byref(error)) == 0, error.message
    lib.penumbra_asset_get_info(asset, info)
    vertices, stride, clusters, frames = info[2], info[27], info[28], info[23]
    assert lib.penumbra_character_create(asset, ctypes.byref(character), ctypes.byref(error)) == 0, error.message
    assert lib.penumbra_character_set_simd(character, simd, ctypes.byref(error)) == 0, error.message
    arrays = [np.zeros((vertices, n), np.float32) for n in (3, 3, 3, stride)]
    of, ambient = Vertices(*(a.ctypes.data for a in arrays), None, 0, vertices), np.zeros(vertices, np.float32)
    least = np.inf
    for _ in range(ROUNDS):
        begin = time.thread_time()
        for frame in range(0, frames, STEP):
            lib.penumbra_character_set_frame(character, size(frame), None)
            lib.penumbra_character_evaluate(character, size(0), size(clusters), ctypes.byref(of), None)
            lib.penumbra_character_skin(character, ctypes.byref(of), None)
            lib.penumbra_character_ambient(character, ctypes.byref(of), ctypes.c_void_p(ambient.ctypes.data), None)
        least = min(least, (time.thread_time() - begin) * 1e3 / -(-frames // STEP))
    return least


if __name__ == "__main__":
    package, assets = sys.argv[2], sys.argv[3:]
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "web_times.mjs")
    print("| asset | AVX2 ms | best ms | portable ms | node ms | node / AVX2 |\n|---|---|---|---|---|---|")
    for path in assets:
        times = [native_ms(path, simd) for simd in (2, 0, 1)]
        node = float(subprocess.run(["node", script, package, path], check=True, stdout=subprocess.PIPE, text=True).stdout)
        print(f"| {os.path.basename(path)} | {' | '.join(f'{t:.2f}' for t in times)} | {node:.2f} | {node / times[0]:.2f} |")
