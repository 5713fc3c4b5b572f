#!/bin/bash
# The player is small and free of GPL parts: neither HDF5, Embree nor Ceres in its closure, and no GL library either
# (those are opened at run time). $1: folder with the programs.
set -eu
closure=$(ldd "$1/penumbra-player")
echo "$closure" | grep -q libstdc++ || { echo "ldd listed nothing of penumbra-player: $closure"; exit 1; }
for library in libhdf5 libembree libceres libassimp libGL libOSMesa libEGL; do
    if echo "$closure" | grep "$library"; then
        echo "penumbra-player links $library"
        exit 1
    fi
done
echo "penumbra-player links $(echo "$closure" | wc -l) libraries; HDF5, Embree, Ceres, assimp, GL, OSMesa and EGL are not among them"
