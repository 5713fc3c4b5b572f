"""The run time as a part of another project, by add_subdirectory: it looks for nothing but FlatBuffers.

usage: test_guest.py BIN [--whole]   (--whole builds and runs the guest, which takes two minutes of one core)
"""
import os
import re
import sys
import tempfile

from programs import must

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
GUEST = os.path.join(os.path.dirname(os.path.abspath(__file__)), "guest")
OTHERS = ("HDF5", "TBB", "embree", "OpenEXR", "CLI11", "nlohmann_json", "Eigen3", "assimp", "PNG", "JPEG", "Ceres", "GTest")

with tempfile.TemporaryDirectory() as build:
    hidden = [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in OTHERS]
    must("cmake", "-G", "Ninja", "-S", GUEST, "-B", build, f"-DPENUMBRA_SOURCE={ROOT}", "-DCMAKE_BUILD_TYPE=Release", *hidden)
    with open(os.path.join(build, "CMakeCache.txt")) as file:
        found = re.findall(r"^(\w+)_DIR:PATH=/", file.read(), re.M)
    assert not found, found
    steps = must("cmake", "--build", build, "--", "-n")
    assert "libpenumbra.a" in steps and "penumbra-bake" not in steps and "test_" not in steps, steps
    if "--whole" in sys.argv:
        must("cmake", "--build", build, "--target", "guest")
        said = must(os.path.join(build, "guest"))
        assert "not a Penumbra asset" in said, said
print("guest: ok")
