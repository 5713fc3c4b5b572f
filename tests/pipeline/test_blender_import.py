"""Blender reads exports: every corner of every face has the place and the colour that the file has.

Of an export that plays Blender has the mean, because its importer leaves out morph targets of colours. The weights of
these are there as shape keys that move nothing. Attributes whose names begin with _ are not there.

usage: test_blender_import.py BIN
"""
import os
import tempfile

import numpy as np
from export_cases import export_cases, vertices_of, worst_of_nearest
from run_blender import run

with tempfile.TemporaryDirectory() as folder:
    paths = export_cases(folder)
    run("blender_import.py", *paths)
    for path in paths:
        read, (positions, colors, targets) = np.load(path + ".npz"), vertices_of(path)
        corners = np.unique(np.round(np.c_[read["positions"], read["colors"][:, :3]], 6), axis=0)
        seen = corners[:, :3], corners[:, 3:]
        there, back = worst_of_nearest((positions, colors), seen, 1e-5), worst_of_nearest(seen, (positions, colors), 1e-5)
        print("%s: %d corners, colours within %.5f, %d of %d morph targets, %d of them driven" %
              (os.path.basename(path), len(read["colors"]), max(there, back), read["keys"], targets, read["driven"]))
        # Blender stores colours as 8 bits of sRGB. Half a step of these near white is .00446, and .00449 was measured.
        assert max(there, back) < 0.0046 and np.ptp(read["colors"][:, 0]) > 0.1
        assert read["keys"] == targets and len(read["attributes"]) == 0
        assert read["driven"] == targets
