"""The OpenJD template: keys, names and references as the 2023-09 schema has them, and its tasks, run here one after the
other, make the bytes of the unsplit bake. (openjd check is the full validator; it is not packaged for Debian.)

usage: test_openjd.py BIN
"""
import os
import re
import shutil
import subprocess
import sys
import tempfile

import yaml

BIN = os.path.abspath(sys.argv[1])
BAKE = os.path.join(BIN, "penumbra-bake")
RIG = os.path.join(BIN, "..", "samples", "bend.glb")
TEMPLATE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "scripts", "farm", "openjd.yaml")
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,63}")
# Object -> (keys that must be there, keys that may be), from "Template Schemas [Version: 2023-09]", without
# extensions.
KEYS = {
    "template": ({"specificationVersion", "name", "steps"}, {"$schema", "description", "parameterDefinitions", "jobEnvironments"}),
    "STRING": ({"name", "type"}, {"description", "default", "allowedValues", "minLength", "maxLength", "userInterface"}),
    "INT": ({"name", "type"}, {"description", "default", "allowedValues", "minValue", "maxValue", "userInterface"}),
    "PATH": ({"name", "type"}, {"description", "default", "allowedValues", "minLength", "maxLength", "objectType", "dataFlow",
                                "userInterface"}),
    "step": ({"name", "script"}, {"description", "dependencies", "stepEnvironments", "hostRequirements", "parameterSpace"}),
    "space": ({"taskParameterDefinitions"}, {"combination"}),
    "task parameter": ({"name", "type", "range"}, set()),
    "script": ({"actions"}, {"embeddedFiles"}),
    "actions": ({"onRun"}, set()),
    "action": ({"command"}, {"args", "timeout", "cancelation"}),
    "file": ({"name", "type", "data"}, {"filename", "runnable"}),
    "amount": ({"name"}, {"min", "max"}),
}


def check_keys(kind, item):
    must, may = KEYS[kind]
    assert must <= set(item) <= must | may, (kind, item)
    return item


def check_references(text, known):
    for reference in re.findall(r"{{\s*(.*?)\s*}}", text):
        assert reference in known, (reference, text)


def check_step(step, parameters, steps_before):
    check_keys("step", step)
    assert 1 <= len(step["name"]) <= 64
    for dependency in step.get("dependencies", []):
        assert set(dependency) == {"dependsOn"} and dependency["dependsOn"] in steps_before, dependency
    known = set(parameters)
    for parameter in check_keys("space", step["parameterSpace"])["taskParameterDefinitions"] if "parameterSpace" in step else []:
        check_keys("task parameter", parameter)
        check_references(parameter["range"], parameters)
        known |= {f"Task.{kind}.{parameter['name']}" for kind in ("Param", "RawParam")}
    for amount in step.get("hostRequirements", {}).get("amounts", []):
        assert re.fullmatch(r"amount\.worker\.(vcpu|memory)", check_keys("amount", amount)["name"]) and amount["min"] > 0, amount
    script = check_keys("script", step["script"])
    for file in script["embeddedFiles"]:
        assert check_keys("file", file)["type"] == "TEXT" and IDENTIFIER.fullmatch(file["name"]), file
        known.add(f"Task.File.{file['name']}")
    for file in script["embeddedFiles"]:
        check_references(file["data"], known)
    action = check_keys("action", check_keys("actions", script["actions"])["onRun"])
    for word in [action["command"], *action["args"]]:
        check_references(word, known)
    stop = action.get("cancelation", {"mode": "TERMINATE"})
    assert stop["mode"] == "TERMINATE" or 0 < stop["notifyPeriodInSeconds"] <= 600, stop


def check_template(template):
    check_keys("template", template)
    assert template["specificationVersion"] == "jobtemplate-2023-09"
    names = [p["name"] for p in template["parameterDefinitions"]]
    assert len(set(names)) == len(names) <= 50 and all(map(IDENTIFIER.fullmatch, names)), names
    for parameter in template["parameterDefinitions"]:
        check_keys(parameter["type"], parameter)
        assert len(parameter.get("description", "")) <= 2048
    known = {f"{kind}.{name}" for kind in ("Param", "RawParam") for name in names}
    check_references(template["name"], known)
    before = []
    for step in template["steps"]:
        check_step(step, known, before)
        before.append(step["name"])
    assert len(set(before)) == len(before), before


def resolve(text, values):
    return re.sub(r"{{\s*(.*?)\s*}}", lambda match: str(values[match[1]]), text)


def run_step(step, values, folder, code=0):
    """Runs all tasks of a step, in order, and returns what they print."""
    tasks = [{}]
    for parameter in step.get("parameterSpace", {}).get("taskParameterDefinitions", []):
        first, last = map(int, resolve(parameter["range"], values).split("-"))
        tasks = [{f"Task.Param.{parameter['name']}": i} for i in range(first, last + 1)]
    text = ""
    for task in tasks:
        mine = {**values, **task}
        for file in step["script"]["embeddedFiles"]:
            mine[f"Task.File.{file['name']}"] = os.path.join(folder, "run.sh")
            with open(os.path.join(folder, "run.sh"), "w") as out:
                out.write(resolve(file["data"], mine))
        action = step["script"]["actions"]["onRun"]
        words = [resolve(word, mine) for word in [action["command"], *action["args"]]]
        result = subprocess.run(words, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        assert result.returncode == code, (words, result.returncode, result.stdout)
        text += result.stdout
        if code:
            break
    return text


def check_run(template, folder):
    """Bakes eight shards of a rig whose folder has every character that means something to a shell. Progress matches
    the specification's regular expressions."""
    rig = shutil.copy(RIG, folder)
    given = {"Rig": rig, "Output": os.path.join(folder, "out put.vis.h5"), "Shards": 8, "KeepShards": "yes",
             "Options": '--fps "6" --rays 64', "Bake": BAKE}
    values = {f"{kind}.{name}": value for kind in ("Param", "RawParam") for name, value in given.items()}
    plan, bake, merge = template["steps"]
    assert " frames x " in run_step(plan, values, folder)
    text = run_step(bake, values, folder)
    progress = [float(value) for value in re.findall(r"^openjd_progress: ([0-9.]+)$", text, re.M)]
    assert len(progress) >= 8 and min(progress) >= 0 and progress.count(100) >= 8, progress
    assert len(re.findall(r"^openjd_status: .+$", text, re.M)) == len(progress)
    shards = given["Output"] + ".shards"
    frames = os.path.join(shards, "frames")
    os.rename(frames, frames + ".kept")
    run_step(merge, values, folder)  # a node may not see the list yet
    assert os.path.exists(given["Output"])
    os.rename(frames + ".kept", frames)
    run_step(merge, values, folder)
    assert len(os.listdir(shards)) == 9, os.listdir(shards)
    values["Param.KeepShards"] = "no"
    run_step(merge, values, folder)
    assert not os.path.exists(shards)
    run_step(merge, values, folder)  # a kill at the very end leaves this state
    whole = os.path.join(folder, "whole.vis.h5")
    subprocess.run([BAKE, "visibility", rig, "--fps", "6", "--rays", "64", "-o", whole, "-q"], check=True)
    assert open(whole, "rb").read() == open(given["Output"], "rb").read()
    os.remove(given["Output"])
    run_step(merge, values, folder, code=2)  # neither shards nor output: no success
    values["Param.Shards"] = 1000
    assert "openjd_fail: 1000 shards of " in run_step(plan, values, folder, code=1)


def main():
    with open(TEMPLATE) as file:
        template = yaml.safe_load(file)
    check_template(template)
    with tempfile.TemporaryDirectory() as top:
        folder = os.path.join(top, "a b 'c' \"d\" $e `f` \\ g")
        os.mkdir(folder)
        check_run(template, folder)
    print("OpenJD: keys and references as in 2023-09; eight tasks and a merge make the bytes of one bake")


main()
