"""`penumbra`: one command from a file to an asset, pictures and a page; it goes on after a kill and reruns changes.

usage: test_make.py BIN
"""
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile

from glb import read_glb, write_glb
from programs import BIN, digest, must, refused, run

PENUMBRA = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "penumbra")
SAMPLES = os.path.join(BIN, "..", "samples")
PYTHON = [sys.executable, PENUMBRA]
STILL_COLLADA = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Y_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 0 3 2 1 2 3</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
QUICK = ["--effort", "draft", "--set", "bake.rays=16", "--set", "fit.model=linear", "--set", "fit.clusters=2"]


def made(text):
    """Returns what the commands that were printed write."""
    return re.findall(r"^/.* -o (\S+)$", text, re.M) + re.findall(r"--report (\S*check\.json)$", text, re.M)


def make(*words):
    return must(*PYTHON, "make", *words)


def whole_run(folder):
    """A rig of three clips becomes an asset and a page that holds its pictures. A second run has nothing to do."""
    rig, asset = os.path.join(SAMPLES, "bend.glb"), os.path.join(folder, "bend.pnb")
    said = make(rig, *QUICK, "-o", asset)
    outputs = set(made(said))
    assert {"bend/bend.vis.h5", "bend/bend.model.h5", "bend/bend.pnb", "bend/check.json", "lights/sky.light.h5", "pictures/0_truth.png",
            "pictures/0_model.png", "pictures/0_error.png", "page.html"} <= outputs, outputs
    assert "first picture after" in said, said
    page = open(os.path.join(folder, "bend.html")).read()
    assert page.count('src="data:image/png;base64,') == 3 and "http:" not in page and "<script" not in page
    assert "held out" in page and "glTF's default stands in" in page, "the page lists warnings and held-out clips"
    before = digest(asset), digest(os.path.join(folder, "bend.html"))
    again = make(rig, *QUICK, "-o", asset)
    assert "nothing was run" in again and not made(again), again
    assert before == (digest(asset), digest(os.path.join(folder, "bend.html")))


def changed_light(folder):
    """Another light runs the light, the asset, what is measured of it, its pictures and the page, no bake or fit."""
    asset = os.path.join(folder, "bend.pnb")
    outputs = set(made(make(os.path.join(SAMPLES, "bend.glb"), *QUICK, "--light", "overcast", "-o", asset)))
    assert {"lights/overcast.light.h5", "bend/bend.pnb", "pictures/0_truth.png", "pictures/0_model.png", "page.html"} <= outputs, outputs
    assert not [path for path in outputs if path.endswith((".vis.h5", ".model.h5", ".truth.pnb"))], outputs
    os.remove(asset)
    again = make(os.path.join(SAMPLES, "bend.glb"), *QUICK, "--light", "overcast", "-o", asset)
    assert not made(again) and os.path.exists(asset), again


def killed(folder):
    """After a kill -9 in the middle the same command makes the same asset, and makes nothing twice."""
    rig, other = os.path.join(SAMPLES, "bend.glb"), os.path.join(folder, "killed", "bend.pnb")
    os.makedirs(os.path.dirname(other))
    words = [*PYTHON, "make", rig, *QUICK, "--light", "overcast", "-o", other]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    before = []
    for line in process.stdout:
        before.append(line)
        if line.endswith("-o bend/bend.model.h5\n"):
            break
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdout.close()
    finished = set(made("".join(before[:-1])))
    assert "bend/bend.vis.h5" in finished, before
    text = make(rig, *QUICK, "--light", "overcast", "-o", other)
    assert not finished & set(made(text)) and "bend/bend.model.h5" in made(text), (finished, text)
    assert digest(other) == digest(os.path.join(folder, "bend.pnb"))


def composed(folder):
    """A rig of several parts gets fields and a composed model unless told otherwise."""
    asset = os.path.join(folder, "man.pnb")
    said = make(os.path.join(SAMPLES, "capsule_man.glb"), "--effort", "draft", "--fps", "2", "--set", "bake.rays=16", "--set",
                "fields.rays=32", "--set", "fields.cells=5", "-o", asset, "--holdout", "walk")
    assert "man/man.fields.h5" in made(said) and "--local" in said, said
    assert "model composed" in must(*PYTHON, "info", asset)


def cloth_and_still(folder):
    """A cache of one clip holds out its last block. A still mesh has nothing to hold out."""
    said = make(os.path.join(SAMPLES, "sheet.npz"), "--effort", "draft", "--set", "bake.rays=16", "-o", os.path.join(folder, "sheet.pnb"))
    assert "--two-sided" in said and re.search(r"Held out to measure the asset on: \S+#\d", said), said
    still = os.path.join(folder, "still.obj")
    with open(still, "w") as file:
        file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    said = make(still, "--effort", "draft", "-o", os.path.join(folder, "still.pnb"))
    assert "too little to hold out" in said and os.path.exists(os.path.join(folder, "still.html")), said
    assert "a single pose: nothing is held out" in must(*PYTHON, "doctor", still)
    collada = os.path.join(folder, "lone.dae")  # read as a rig with one joint and no clips
    with open(collada, "w") as file:
        file.write(STILL_COLLADA)
    said = make(collada, "--effort", "draft", "--set", "bake.rays=16", "-o", os.path.join(folder, "lone.pnb"))
    assert "too little to hold out" in said and os.path.exists(os.path.join(folder, "lone.html")), said


def odd_names(folder):
    """Names with quotes, blanks and dots are names. What the page needs and is lost is made again."""
    place = os.path.join(folder, "Bob's \"files\" #1")
    os.makedirs(place)
    for name in ("it's v.1.obj", "it's v.2.obj"):
        shutil.copy(os.path.join(folder, "still.obj"), os.path.join(place, name))
        result = run(*PYTHON, "make", name, "--effort", "draft", "--set", "bake.rays=16", cwd=place)
        assert result.returncode == 0 and os.path.exists(os.path.join(place, name[:-4] + ".pnb")), result
    again = [*PYTHON, "make", os.path.join(place, name), "--effort", "draft", "--set", "bake.rays=16", "-o",
             os.path.join(place, name[:-4] + ".pnb")]
    assert "nothing was run" in must(*again)
    with open(os.path.join(place, name[:-4] + ".penumbra", "reports", "pictures.first.png.json"), "w") as file:
        file.write('{"x":')
    assert "its report is lost or damaged" in must(*again) and "nothing was run" in must(*again)


def numbered(folder):
    """Numbered files are a cache, given as a folder or as a pattern."""
    place = os.path.join(folder, "seq")
    os.makedirs(place)
    for i in range(12):
        with open(os.path.join(place, f"a_{i:03}.obj"), "w") as file:
            file.write(f"v 0 0 0\nv 1 {i / 10} 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    quick = ["--effort", "draft", "--set", "bake.rays=16", "--fps", "24", "--light", "uniform+sun:direction=0/1/0"]
    said = make(place, *quick, "-o", os.path.join(folder, "seq.pnb"))
    assert "--two-sided" in said and "lights/uniform.light.h5" in said and "on: a#4" in said, said
    pattern = os.path.join(place, "a_%03d.obj")
    said = make(pattern, *quick, "-o", os.path.join(folder, "pattern.pnb"), "--holdout", "none")
    assert "on: nothing, as asked" in said, said
    assert re.search("clips +1: a", must(*PYTHON, "doctor", pattern))


def files_of_clips(folder):
    """A file of clips that changed bakes its own shards again, and no others. Names of clips may have commas."""
    description, rest = read_glb(os.path.join(SAMPLES, "bend.glb"))
    files = [os.path.join(folder, name) for name in ("rig.glb", "a.glb", "b.glb")]
    animations, whole = description["animations"], {key: value for key, value in description.items() if key != "animations"}
    bare = {key: value for key, value in whole.items() if key not in ("meshes", "skins")}
    bare["nodes"] = [{key: value for key, value in node.items() if key not in ("mesh", "skin")} for node in whole["nodes"]]
    write_glb(files[0], whole, rest)
    write_glb(files[1], bare | {"animations": [animations[0] | {"name": "run, fast"}]}, rest)
    write_glb(files[2], bare | {"animations": [animations[1] | {"name": "walk"}]}, rest)
    words = [*files, *QUICK, "--fps", "4", "--set", "shards=4", "--holdout", "run\\, fast", "-o", os.path.join(folder, "clips.pnb")]
    assert len([path for path in made(make(*words)) if "/clips/" in path]) == 4
    said = must(*PYTHON, "doctor", *files)
    assert "2: run, fast, walk" in said and "cannot" not in said, said
    write_glb(files[2], bare | {"animations": [animations[2] | {"name": "walk"}]}, rest)
    outputs = made(make(*words))
    assert len([path for path in outputs if "/clips/" in path]) == 2 and "clips/clips.vis.h5" in outputs, outputs


def chosen_meshes(folder):
    """Meshes are chosen by their nodes, and paths of --set are those of the shell."""
    with open(os.path.join(folder, "body.obj"), "w") as file:
        file.write("v 5 0 0\nv 6 0 0\nv 5 1 0\nf 1 2 3\n")
    props = os.path.join(SAMPLES, "props.glb")
    must(*PYTHON, "doctor", props, "--without", "sword,shield")
    result = run(*PYTHON, "doctor", props, "--without", "nope")
    assert result.returncode == 3 and "'nope' matches no node" in result.stdout, result
    result = run(*PYTHON, "make", props, *QUICK, "--without", "sword,shield", "--set", 'bake.occluder=["body.obj"]', "-o",
                 "props.pnb", cwd=folder)
    assert result.returncode == 0 and "--without sword,shield" in result.stdout and "--occluder" in result.stdout, result
    assert "sword" not in must(*PYTHON, "info", os.path.join(folder, "props.pnb"))


def verbs(folder):
    """Each verb reaches its program; a picture is told by `info`; a file with the name of a verb is given as ./view."""
    asset = os.path.join(folder, "bend.pnb")
    picture = os.path.join(folder, "p.png")
    must(*PYTHON, "render", asset, "--size", "32x32", "-o", picture)
    text = must(*PYTHON, "info", picture)
    assert "32 x 32" in text and "alpha" in text, text
    assert must(*PYTHON, "info", picture, picture).count("32 x 32") == 2
    refused(1, "takes no options", *PYTHON, "info", picture, "-q")
    assert "clips" in must(*PYTHON, "info", os.path.join(SAMPLES, "bend.glb"))
    assert "penumbra-player view" in must(*PYTHON, "help", "view") and "--effort" in must(*PYTHON, "make", "--help")
    said = must(*PYTHON, "doctor", os.path.join(SAMPLES, "bend.glb"))
    assert "bend, twist, sway" in said and "glTF's default stands in" in said, said
    assert "works" in must(*PYTHON, "doctor")
    shutil.copy(os.path.join(SAMPLES, "bend.glb"), os.path.join(folder, "view"))
    result = run(*PYTHON, "./view", cwd=folder)
    assert result.returncode == 3 and "view: not a rig" in result.stderr, result.stderr


def rubbish(folder):
    """Every refusal is one sentence with the code of our programs."""
    rig, out = os.path.join(SAMPLES, "bend.glb"), ["-o", os.path.join(folder, "x.pnb")]
    broken = os.path.join(folder, "broken.glb")
    with open(broken, "wb") as file:
        file.write(open(rig, "rb").read()[:3000])
    empty = os.path.join(folder, "empty")
    os.makedirs(empty)
    with open(os.path.join(folder, "foreign.html"), "w") as file:
        file.write("of others")
    for code, part, words in [
            (1, "FILE", ["make"]), (1, "did you mean view", ["veiw"]), (2, "no such file", ["nope.glb"]), (1, "no verb", ["help", "x"]),
            (3, "cut short", ["make", broken, *out]), (3, "no clip 'nope'", ["make", rig, "--holdout", "nope", *out]),
            (3, "--clips: no clip 'nope'", ["make", rig, "--clips", "bend,nope", *out]),
            (3, "did you mean rays", ["make", rig, "--set", "bake.rayz=9", *out]), (1, "KEY=VALUE", ["make", rig, "--set", "x", *out]),
            (3, "bake.rays.x: no such key", ["make", rig, "--set", "bake.rays.x=1", *out]),
            (2, "numbered files", ["doctor", empty]), (2, "another -o", ["make", rig, "-o", os.path.join(folder, "foreign.pnb")]),
            (2, "--light: no such file", ["make", rig, "--light", "nope.exr", *out]), (1, "--fps", ["make", rig, "--fps", "0"]),
            (3, "no light 'blub'", ["make", rig, "--light", "blub:x=1", *out]), (1, ".pnb", ["make", rig, "-o", "x.txt"]),
            (2, "no such folder", ["make", rig, "-o", os.path.join(folder, "no", "x.pnb")]), (2, "no such file", ["doctor", "nope"])]:
        refused(code, part, *PYTHON, *words)
    assert not os.path.exists(os.path.join(folder, "x.penumbra")), "a file that is refused leaves no folder"
    changed = os.path.join(folder, "bend.penumbra", "bend", "bend.model.h5")
    with open(changed, "ab") as file:
        file.write(b"x")
    refused(3, "delete it", *PYTHON, "make", rig, *QUICK, "--light", "overcast", "-o", os.path.join(folder, "bend.pnb"))


def main():
    os.environ["PENUMBRA_BIN"] = BIN
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        os.environ.pop(name, None)
    with tempfile.TemporaryDirectory() as folder:
        for check in (whole_run, changed_light, killed, composed, cloth_and_still, odd_names, numbered, files_of_clips, chosen_meshes, verbs,
                      rubbish):
            start = os.times().children_user
            check(folder)
            print(f"{check.__doc__.splitlines()[0]} ({os.times().children_user - start:.1f} s)", flush=True)


main()
