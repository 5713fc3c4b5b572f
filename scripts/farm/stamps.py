"""Keeps beside a file what it was made from: OUT.stamp (JSON) holds the command, the tool's version and the SHA-256
of every input and of OUT itself. Whether OUT must be made again is decided by that content, never by time stamps."""
import hashlib
import json
import os
import re
import secrets
import socket
import subprocess

SCHEMA, SCHEMA_VERSION = "penumbra.stamp", 1
STAMP = {"command": list, "version": str, "inputs": list, "further_inputs": dict, "output": dict}


class ForeignFile(Exception):
    """A file that is not what its stamp says."""


def write_whole(path, content):
    """Writes a file so that its name only ever stands for a whole one. Process ids repeat on other hosts and in
    containers, so the partial name is random too."""
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    partial = f"{path}.part-{socket.gethostname()}-{os.getpid()}-{secrets.token_hex(4)}"
    try:
        with open(partial, "xb" if isinstance(content, bytes) else "x") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
    except BaseException as error:
        remove(partial)
        if isinstance(error, OSError) and error.filename in (None, partial):
            error.filename = path
        raise


def remove(path):
    """Removes a file, whether it is there or not."""
    try:
        os.remove(path)
    except FileNotFoundError:
        pass


def sha256(path):
    total = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            total.update(block)
    return total.hexdigest()


def remembered(path):
    """Returns what a file of ours remembers by names. It is a memory only: without it we find out again."""
    try:
        with open(path) as file:
            content = json.load(file)
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


class Digests:
    """Computes the SHA-256 of files, and remembers it in FOLDER/.farm/digests.json for as long as size and time stamp
    stay."""

    def __init__(self, folder="."):
        self.folder = folder
        self.memory = os.path.join(folder, ".farm", "digests.json")
        self.known, self.changed = remembered(self.memory), False

    def of(self, path):
        status = os.stat(os.path.join(self.folder, path))
        found = self.known.get(path)
        size, time, digest = found if isinstance(found, list) and len(found) == 3 else (None, None, None)
        if (size, time) != (status.st_size, status.st_mtime_ns):
            digest = sha256(os.path.join(self.folder, path))
            self.known[path] = [status.st_size, status.st_mtime_ns, digest]
            self.changed = True
        return digest

    def retimed(self, path):
        """Call this when only the time of a file that was asked for has changed."""
        self.known[path][1] = os.stat(os.path.join(self.folder, path)).st_mtime_ns
        self.changed = True

    def save(self):
        if self.changed:
            try:
                write_whole(self.memory, json.dumps(self.known, indent=0))
            except OSError:  # no job fails because its memory cannot be written
                pass
            self.changed = False


def label(path):
    """Returns what stands for a path in a stamp: files from outside may lie in another folder the next time."""
    return os.path.basename(path) if os.path.isabs(path) else path


PROGRAMS = ("penumbra-bake", "penumbra-fit", "penumbra-pack", "penumbra-player")


def tool_version(command, known={}):
    """Returns what our programs in a command say, with the hashes of their sources; "" without one. Scripts are
    inputs of their jobs."""
    said = []
    for program in command[:4]:  # a script of ours takes programs first
        if os.path.basename(program) in PROGRAMS:
            if program not in known:
                known[program] = " ".join(subprocess.run([program, "--version"], capture_output=True, text=True).stdout.split())
            said.append(known[program])
    return "; ".join(said)


def depfile_inputs(path):
    """Returns the files that a make rule (--depfile of our programs) lists."""
    if not path or not os.path.exists(path):
        return []
    with open(path) as file:
        rule = file.read().replace("\\\n", " ").partition(": ")[2]
    # Blanks and # have a backslash and $ is doubled; quotes and other backslashes stand for themselves.
    return [re.sub(r"\\([ \t#])", r"\1", name).replace("$$", "$") for name in re.findall(r"(?:\\[ \t#]|\S)+", rule)]


def read_stamp(folder, output):
    """Returns the stamp of `output`, or None when there is no whole one."""
    try:
        with open(os.path.join(folder, output + ".stamp")) as file:
            stamp = json.load(file)
        known = (stamp["schema"], stamp["schema_version"]) == (SCHEMA, SCHEMA_VERSION)
        whole = all(isinstance(stamp[key], kind) for key, kind in STAMP.items()) and all(len(item) == 2 for item in stamp["inputs"])
        return stamp if known and whole and {"sha256", "mtime_ns"} <= set(stamp["output"]) else None
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None


def write_stamp(folder, output, command, inputs, further, digests):
    """Writes OUTPUT.stamp. `inputs` have the order of the job; `further` are those that only the command knew."""
    status = os.stat(os.path.join(folder, output))
    stamp = {"schema": SCHEMA, "schema_version": SCHEMA_VERSION, "command": [label(word) for word in command],
             "version": tool_version(command), "inputs": [[label(path), digests.of(path)] for path in inputs],
             "further_inputs": {os.path.relpath(os.path.join(folder, path), folder): digests.of(path) for path in further},
             "output": {"sha256": digests.of(output), "mtime_ns": status.st_mtime_ns}}
    write_whole(os.path.join(folder, output + ".stamp"), json.dumps(stamp, indent=1) + "\n")


def check_own(folder, path, digests, give_time_back=True):
    """Returns the stamp of `path`, or None when it has none. Raises ForeignFile when `path` is not what its stamp says.
    An input that was only touched gets its time back, so that make, ninja and snakemake do not take it for new."""
    stamp, place = read_stamp(folder, path), os.path.join(folder, path)
    if stamp is None or not os.path.exists(place):
        return stamp
    made = stamp["output"]
    if digests.of(path) != made["sha256"]:
        raise ForeignFile(f"{path}: is not the file that was made here: SHA-256 {digests.of(path)[:12]}..., "
                          f"made with {made['sha256'][:12]}... (delete it, and it is made again)")
    if give_time_back and os.stat(place).st_mtime_ns != made["mtime_ns"]:
        os.utime(place, ns=(made["mtime_ns"], made["mtime_ns"]))
        digests.retimed(path)
    return stamp


def changed_words(new, old):
    """Tells people what is in one command and not in the other."""
    lost, come = [w for w in old if w not in new], [w for w in new if w not in old]
    return f"{' '.join(come) or 'less'} instead of {' '.join(lost) or 'nothing'}" if lost or come else "another order of options"


def why_stale(folder, output, command, inputs, digests, temporary=False, give_time_back=True):
    """Returns "" when `output` is what `command` would make of `inputs` now, else the reason. Raises ForeignFile."""
    for path in inputs:
        check_own(folder, path, digests, give_time_back)
    stamp = check_own(folder, output, digests, give_time_back=False)  # ninja's restat compares it before and after
    if not os.path.exists(os.path.join(folder, output)) and not (temporary and stamp):
        return "is not there"
    if stamp is None:
        return "has no stamp: nobody knows what made it"
    new, old = nameless(command, inputs, [label(path) for path in inputs]), nameless(stamp["command"], inputs, names_in(stamp))
    if new != old:
        return "made with other options: " + changed_words(new, old)
    if stamp["version"] != tool_version(command):
        return f"made by {stamp['version']}, now {tool_version(command)}"
    return changed_input(folder, inputs, stamp, digests)


def is_renamed_freely(path):
    """Tells whether a file from outside gives the same result under another name. Files whose clips are named after the
    file do not: BVH, point caches, numbered meshes."""
    return os.path.isabs(path) and not path.lower().endswith((".bvh", ".mdd", ".pc2", ".npy", ".npz", ".obj", ".ply", ".abc"))


def names_in(stamp):
    return [name for name, _ in stamp["inputs"]]


def nameless(command, inputs, names):
    """Returns the words of a command with numbers for the names of files from outside: a file that was renamed is what
    it was. `names` are the inputs as the command has them; where they are not as many as `inputs` they all count."""
    words = [label(word) for word in command]
    if len(names) != len(inputs):
        return words
    numbers = {name: f"file {i}" for i, (path, name) in enumerate(zip(inputs, names)) if is_renamed_freely(path)}
    return [numbers.get(word, word) for word in words]


def changed_input(folder, inputs, stamp, digests):
    """Returns the first input that is not what the output was made from, as a reason; or ""."""
    new, old = [label(path) for path in inputs], names_in(stamp)
    renamed = len(new) == len(old) and all(is_renamed_freely(path) or a == b for path, a, b in zip(inputs, new, old))
    if new != old and not (renamed and all(digest_of(folder, path, digests) == digest
                                           for path, (_, digest) in zip(inputs, stamp["inputs"]))):
        return "made from other files: " + changed_words(new, old)
    for path, (name, digest) in zip(inputs, stamp["inputs"]):
        if digest_of(folder, path, digests) != digest:
            return f"made from another {name}"
    for path, digest in stamp["further_inputs"].items():
        if digest_of(folder, path, digests) != digest:
            return f"made from another {path}"
    return ""


def digest_of(folder, path, digests):
    """Returns the digest of a file that is there, or of a temporary one that is gone."""
    if os.path.exists(os.path.join(folder, path)):
        return digests.of(path)
    stamp = read_stamp(folder, path)
    return stamp["output"]["sha256"] if stamp else ""
