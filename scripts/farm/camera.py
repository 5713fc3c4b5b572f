"""Tells what is wrong with a camera ("yaw=35,pitch=12"), in the words of sh/key_values.cpp and sh/camera.cpp: no
program can be asked of it before there is something to see."""
import re

RANGES = {"yaw": (-360, 360), "pitch": (-89, 89), "fov": (1, 170), "distance": (1e-9, 1e9), "target": (-1e9, 1e9)}
NUMBER = re.compile(r"-?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?")  # std::from_chars


def number_problem(key, text):
    least, most = RANGES[key]
    if NUMBER.fullmatch(text) and least <= float(text) <= most:
        return ""
    return f"camera {key} must be a number from {least:g} to {most:g}, not '{text}'"


def value_problem(key, value):
    if key not in RANGES:
        return f"camera has no '{key}': use {', '.join(RANGES)}"
    numbers = value.split("/") if key == "target" else [value]
    if len(numbers) not in (1, 3):
        return f"camera {key} must be three numbers like 1/0.5/0, not '{value}'"
    return next(filter(None, (number_problem(key, number) for number in numbers)), "")


def camera_problem(text):
    """Returns a sentence that tells what is wrong, or ""."""
    items = [item.partition("=") for item in text.split(",")]
    for i, (key, _, value) in enumerate(items):
        if not key or not value:
            return f"expected key=value, not '{text.split(',')[i]}'"
        if key in (before for before, _, _ in items[:i]):
            return f"'{key}' is given twice"
    return next(filter(None, (value_problem(key, value) for key, _, value in items)), "")
