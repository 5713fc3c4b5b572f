"""Helpers of the scripts that test_blender.py runs in Blender."""
import os
import sys

import bpy
import numpy as np


def check(good, *what):
    if not good:
        print("FAILED", *what)
        sys.stdout.flush()
        os._exit(1)


def values(thing, attribute):
    mesh = thing.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    colors = np.empty(4 * len(mesh.vertices), np.float32)
    mesh.attributes[attribute].data.foreach_get("color", colors)
    return colors.reshape(-1, 4)[:, 0]


def worst_difference(things, attribute, table, frames):
    """Returns the difference between the rows of a table [F,V] and the values that Blender shows in these frames."""
    worst = 0.0
    for row, frame in enumerate(frames):
        bpy.context.scene.frame_set(frame)
        shown = np.concatenate([values(thing, attribute) for thing in things])
        check(shown.shape == table[row].shape, shown.shape, table[row].shape)
        worst = max(worst, float(abs(shown - table[row]).max()))
    return worst


def said(settings):
    return " | ".join(line.text for line in settings.lines)


def refused(button, settings, part):
    try:
        button()
    except RuntimeError as error:
        check(part in str(error) and part in said(settings), part, "is not in", error, said(settings))
    else:
        check(False, "not refused:", part)
