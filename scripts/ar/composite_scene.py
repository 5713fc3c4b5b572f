#!/usr/bin/python3
"""Writes the scenes of a test scene with a known truth, and prints what a shell needs to make its character.

composite_scene.py FOLDER NAME     FOLDER has truth.json. Writes NAME.json, with the true camera, NAME.plain.json, which
                                   adds nothing to a photograph, and NAME.video.json where there is a video
"""
import json
import pathlib
import shlex
import sys


def main():
    folder, name = pathlib.Path(sys.argv[1]), sys.argv[2]
    truth = json.loads((folder / "truth.json").read_text())
    camera, character = truth["camera"], truth["character"]
    lens = {key: camera[key] for key in ("f", "cx", "cy", "size")}
    scene = {
        "version": 1, "world_scale": truth["world_scale"], "camera": lens | {key: camera[key] for key in ("R", "t")},
        "characters": [{"asset": f"{name}.pnb", "clip": character["clip"], "time": character["time"],
                        "position": character["position_scene"], "yaw": character["yaw"]}],
        "ground": {"catcher": True}, "light": {"asset": f"{name}.pnb"}}
    pathlib.Path(f"{name}.json").write_text(json.dumps(scene))
    plain = {key: scene[key] for key in ("version", "camera", "light")}
    pathlib.Path(f"{name}.plain.json").write_text(json.dumps(plain))
    if truth.get("video"):
        frames = [{"file": f"plate_{one['index']:03d}.jpg", "R": one["R"], "t": one["t"]} for one in truth["video"]]
        pathlib.Path(f"{name}.poses.json").write_text(
            json.dumps({"format": "penumbra.camera_poses", "camera": lens, "frames": frames}))
        pathlib.Path(f"{name}.video.json").write_text(json.dumps(scene | {"camera": {"poses": f"{name}.poses.json"}}))
    words = {"RIG": character["rig"], "CLIP": character["clip"], "EXPOSURE": truth["exposure"],
             "ALBEDO": "/".join(map(str, character["albedo"])), "VIDEO": "1" if truth.get("video") else ""}
    for key, value in words.items():
        print(f"{key}={shlex.quote(str(value))}")


if __name__ == "__main__":
    main()
