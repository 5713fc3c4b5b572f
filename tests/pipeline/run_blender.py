"""How the tests run scripts in Blender. PENUMBRA_BLENDER names it, else it is found by PATH."""
import os
import shutil
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))


def run(script, *words):
    """Runs a script in Blender, without the user's own settings, and returns what it prints. Ends the test as skipped
    where there is no Blender."""
    blender = os.environ.get("PENUMBRA_BLENDER") or shutil.which("blender")
    if not blender:
        print("skipped: no Blender (PENUMBRA_BLENDER or PATH)")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as own:
        os.mkdir(os.path.join(own, "addons"))
        environment = dict(os.environ, BLENDER_USER_SCRIPTS=own, BLENDER_USER_CONFIG=own)
        command = [blender, "-b", "-t", "1", "--factory-startup", "--python-exit-code", "3"]
        command += ["--python", os.path.join(HERE, script), "--", *words]
        result = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=400)
    if result.returncode != 0:
        said = result.stdout[-4000:] + result.stderr[-4000:]
        sys.exit(f"{os.path.basename(sys.argv[0])}: {script} ended with {result.returncode}\n{said}")
    return result.stdout
