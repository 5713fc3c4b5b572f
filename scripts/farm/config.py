"""The farm's YAML file: what may stand in it, checked before any job starts. docs/farm.md shows one."""
import difflib
import glob
import os
import re
import shutil
from dataclasses import dataclass

from farm.camera import camera_problem

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")  # becomes a folder and a file name, and a name in the asset
ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))


class ConfigError(Exception):
    """An error whose one sentence names the key, what it takes and what was given."""


class Unreadable(ConfigError):
    """A file that is not there or cannot be read."""


def exit_code(error):
    """Returns the exit code of our programs: 2 cannot read or write, 3 input invalid."""
    return 2 if isinstance(error, (Unreadable, OSError)) else 3


# --- Kinds of values: each takes (key, value, folder of the YAML file) and returns the value to use -------------------

def number(least, whole=False):
    def check(key, value, folder):
        good = isinstance(value, int if whole else (int, float)) and not isinstance(value, bool) and value >= least
        if not good:
            raise ConfigError(f"{key}: takes a {'whole ' if whole else ''}number from {least}, not {value!r}")
        return value
    return check


def one_of(*words):
    def check(key, value, folder):
        if value not in words:
            raise ConfigError(f"{key}: takes one of {', '.join(map(str, words))}, not {value!r}")
        return value
    return check


def either(kind, *words):
    return lambda key, value, folder: value if any(value is word or isinstance(word, str) and value == word for word in words) else \
        kind(key, value, folder)


def text(key, value, folder):
    if not isinstance(value, str) or not value:
        raise ConfigError(f"{key}: takes text, not {value!r}")
    if "\0" in value or not value.isprintable():
        raise ConfigError(f"{key}: takes text that can be printed, not {value!r}")
    return value


def word(key, value, folder):
    """Takes text, or a number that the program gets as it stands there."""
    return text(key, str(value), folder)


def a_file(key, value, folder):
    path = os.path.normpath(os.path.join(folder, os.path.expanduser(text(key, value, folder))))
    if not os.path.isfile(path):
        raise Unreadable(f"{key}: no such file: {path}")
    return path


def a_mesh(key, value, folder):
    """Takes a file; or numbered ones, by a folder or by a pattern with %d, %04d, * or #### for the number."""
    path = os.path.normpath(os.path.join(folder, os.path.expanduser(text(key, value, folder))))
    if not files_of(path):
        raise Unreadable(f"{key}: no such file, and no numbered files: {path}")
    return path


def an_occluder(key, value, folder):
    """Takes what a_mesh() takes, or MESH:CACHE."""
    refuse_colons(key, text(key, value, folder), folder)
    return ":".join(a_mesh(key, part, folder) for part in parts_of(text(key, value, folder), folder))


def parts_of(occluder, folder=""):
    """Splits "body.obj:body.mdd" in two, but not the name of a file that has a colon."""
    whole = os.path.exists(os.path.join(folder, os.path.expanduser(occluder)))
    return [occluder] if whole else occluder.split(":")


def refuse_colons(key, occluder, folder):
    """Refuses paths that the colons would spoil. Absolute paths are joined with colons: only one file, or one folder of
    numbered ones, may lie under a folder that has one."""
    paths = [os.path.join(folder, os.path.expanduser(part)) for part in [occluder, *occluder.split(":")]]
    if os.path.exists(paths[0]):
        return
    for path in paths:
        folders = [path[:i] for i, letter in enumerate(path) if letter == "/" and ":" in path[:i]]
        for found in filter(os.path.isdir, folders):
            raise ConfigError(f"{key}: no MESH:CACHE and no pattern can lie in a folder with a colon: {found}")


def files_of(path):
    """Returns the files that a path of a_mesh() names."""
    if os.path.isfile(path):
        return [path]
    if os.path.isdir(path):
        found = [os.path.join(path, name) for name in os.listdir(path)]
    else:
        parent, name = os.path.split(path)
        found = glob.glob(os.path.join(glob.escape(parent), re.sub(r"%[0-9]*d|#+|\*", "*", name)))
    return sorted(file for file in found if os.path.isfile(file))


def list_of(kind):
    def check(key, value, folder):
        if not isinstance(value, list) or not value:
            raise ConfigError(f"{key}: takes a list, as in [a, b], not {value!r}")
        if len(set(map(str, value))) < len(value):
            raise ConfigError(f"{key}: lists something twice: {value}")
        return [kind(f"{key}[{i}]", v, folder) for i, v in enumerate(value)]
    return check


def names(key, value, folder):
    """Takes a list of names, or text with commas between them."""
    return list_of(text)(key, value, folder) if isinstance(value, list) else text(key, value, folder)


def map_of(kind):
    def check(key, value, folder):
        if not isinstance(value, dict) or not value:
            raise ConfigError(f"{key}: takes NAME: ..., not {value!r}")
        for name in value:
            if not isinstance(name, str) or not NAME.fullmatch(name):
                raise ConfigError(f"{key}: {name!r} cannot be a name: letters, digits, _ and - only")
        return {name: kind(f"{key}.{name}", v, folder) for name, v in value.items()}
    return check


def keys(**kinds):
    """Takes a map of these keys only. Those whose kind is wrapped in needed() must be there."""
    def check(key, value, folder):
        if not isinstance(value, dict):
            raise ConfigError(f"{key or 'the file'}: takes a map of {', '.join(kinds)}, not {value!r}")
        prefix = key + "." if key else ""
        for name in value:
            if name not in kinds:
                near = difflib.get_close_matches(str(name), kinds, 1)
                hint = f"; did you mean {near[0]}?" if near else f"; it takes {', '.join(kinds)}"
                raise ConfigError(f"{prefix}{name}: no such key{hint}")
        for name, kind in kinds.items():
            if getattr(kind, "needed", False) and name not in value:
                raise ConfigError(f"{prefix}{name}: missing")
        return {name: kinds[name](prefix + name, v, folder) for name, v in value.items()}
    return check


def needed(kind):
    def check(key, value, folder):
        return kind(key, value, folder)
    check.needed = True
    return check


def exactly_one(names, kind):
    def check(key, value, folder):
        value = kind(key, value, folder)
        if sum(name in value for name in names) != 1:
            raise ConfigError(f"{key}: takes exactly one of {', '.join(names)}")
        return value
    return check


def camera(key, value, folder):
    if problem := camera_problem(text(key, value, folder)):
        raise ConfigError(f"{key}: {problem}")
    return value


def convention(key, value, folder):
    """Checks a convention as parseConvention() of sh/visibility_convention.cpp does."""
    if not re.fullmatch("[ABD][1-8]", text(key, value, folder)):
        raise ConfigError(f"{key}: convention must be A, B or D and an order from 1 to 8 (such as D5), not '{value}'")
    return value


def slots(key, value, folder):
    if not isinstance(value, dict):
        raise ConfigError(f"{key}: takes SLOT: MATERIAL, not {value!r}")
    return {text(f"{key}: a slot", str(slot), folder): text(f"{key}.{slot}", material, folder) for slot, material in value.items()}


# --- The file ---------------------------------------------------------------------------------------------------------

# Keys of bake, fields, fit, pack, a material and a light are the options of the programs, with _ for -.
BAKE = dict(order=number(1, True), rays=number(16, True), seed=number(0, True), bias=number(0), precision=one_of("f32", "f16"),
            ground=either(number(-1e9), True, False), poses=either(a_file, "auto"), units=word, up=one_of("y", "z"),
            cache_fps=number(0.001), blocks=number(1, True), two_sided=one_of(True, False), occluder=list_of(an_occluder), inputs=a_file,
            nodes=names, without=names, crease=number(0), split_angle=number(0), one_sided=one_of(True, False),
            local=one_of(True, False), local_steps=number(1, True), local_order=number(5, True))
MESHES = ("nodes", "without", "crease", "split_angle", "one_sided")  # fields and poses take these from bake
FIELDS = dict(rays=number(16, True), seed=number(0, True), cells=number(4, True), megabytes=number(0.01), fade=number(1e-6))
MODELS = ("linear", "quadratic", "neural", "additive")
FIT = dict(model=one_of(*MODELS, "composed"), local_model=one_of(*MODELS), parts=either(number(1, True), "auto"),
           features=one_of("relative-bones", "joint-angles", "dihedral-angles"),
           clusters=either(number(1, True), "auto"), input_variance=either(number(0), "auto"), output_variance=number(0),
           convention=convention, train_frames=a_file)
PACK = dict(precision=one_of("f32", "f16", "i8"), max_error=number(0), max_bytes_per_vertex=number(0), slot=slots, materials_of=a_file,
            textures=one_of("embed", "link", "none"))
MATERIAL = dict(analytic=text, merl=a_file, table=a_file, material=text, operators=number(1, True), slice_order=number(1, True),
                view_order=number(1, True))
LIGHT = dict(analytic=text, layout=one_of("latlong", "angular", "ball", "cube"), order=number(1, True),
             window=word, lobes=number(0, True), lobe_fit=one_of("greedy", "joint", "fixed"), factor=one_of(True, False),
             suns=number(1, True))
OF_A_RIG = dict(clips=list_of(text), holdout=either(list_of(text), "none"), fps=number(0.001), shards=number(1, whole=True),
                predict=one_of(True, False),
                materials=list_of(text), lights=list_of(text), bake=keys(**BAKE), fields=keys(**FIELDS), fit=keys(**FIT),
                pack=keys(**PACK))
JOB = keys(threads=number(1, True), memory_mb=number(1, True), minutes=number(1, True))
RULES = ("bake", "poses", "merge", "fields", "fit", "predict", "brdf", "light", "pack", "truth", "check", "sheet", "index")
FARM = keys(
    output=needed(text), programs=text, defaults=keys(**OF_A_RIG),
    rigs=needed(map_of(keys(files=needed(list_of(a_mesh)), **OF_A_RIG))),
    materials=needed(map_of(exactly_one(("analytic", "merl", "table"), keys(**MATERIAL)))),
    lights=needed(map_of(exactly_one(("picture", "analytic"), keys(picture=a_file, **LIGHT)))),
    pictures=keys(frames=number(1, True), size=number(16, True), camera=camera),
    jobs=keys(**{rule: JOB for rule in RULES}))


RESERVED = ("materials", "lights", "reports", "lists")  # folders of the output


@dataclass
class Farm:
    file: str      # the YAML file
    output: str    # absolute folder
    programs: str  # absolute folder, or "" for $PATH
    rigs: dict
    materials: dict
    lights: dict
    pictures: dict
    jobs: dict     # rule -> threads, memory_mb, minutes


def with_defaults(defaults, rig):
    """Puts a rig's own values over those of `defaults`: for bake, fields, fit and pack key by key."""
    merged = {**defaults, **rig}
    for part in ("bake", "fields", "fit", "pack"):
        merged[part] = {**defaults.get(part, {}), **rig.get(part, {})}
    return merged


def clip_of_block(name):
    """Returns the clip that --blocks cut this one from: flag for flag#5."""
    return name.rpartition("#")[0] or name


def is_composed(rig):
    return rig["fit"].get("model") == "composed"


def chooses_poses(rig):
    return rig["bake"].get("poses") == "auto"


def settle_composed(key, rig, own):
    """Gives the bake of a composed model its local moments and refuses what does not go with one. `own` are the rig's
    own keys: those of `defaults` hold for the rigs whose model has them."""
    if not is_composed(rig):
        if "local_model" in own.get("fit", {}):
            raise ConfigError(f"{key}.fit.local_model: only model composed has one")
        if "fields" in own:
            raise ConfigError(f"{key}.fields: only fit: {{model: composed}} reads them")
        rig["fit"].pop("local_model", None)
    if rig["bake"].pop("local", is_composed(rig)):
        rig["bake"]["local"] = True  # the last word in any case: to spell it out bakes nothing again
    elif is_composed(rig):
        raise ConfigError(f"{key}.bake.local: model composed needs local moments, not False")


def check_poses(key, rig):
    """Refuses what does not go with poses that the farm chooses: nobody knows their number before they are there."""
    if not chooses_poses(rig):
        return
    if rig.get("shards", 1) != 1:
        raise ConfigError(f"{key}.bake.poses: auto takes shards: 1, not {rig['shards']}")
    if "blocks" in rig["bake"]:
        raise ConfigError(f"{key}.bake.poses: auto does not go with blocks")
    if not rig["holdout"]:
        raise ConfigError(f"{key}.bake.poses: auto needs clips in holdout")


def check_convention(key, rig):
    """Checks the convention against the moments that the bake will have, with the defaults of the programs."""
    wanted, bake = rig["fit"].get("convention", "D5"), rig["bake"]
    if int(wanted[1]) > bake.get("order", 5):
        raise ConfigError(f"{key}: {wanted} needs moments of order {wanted[1]}; the bake has order {bake.get('order', 5)}")
    if not is_composed(rig):
        return
    if wanted[0] != "D":
        raise ConfigError(f"{key}: model composed takes convention D, not {wanted}")
    if int(wanted[1]) > bake.get("local_order", 5):
        raise ConfigError(f"{key}: {wanted} needs local moments of order {wanted[1]}; bake.local_order is {bake.get('local_order', 5)}")


def check_rig(name, rig, farm):
    key = f"rigs.{name}"
    if name.lower() in RESERVED:
        raise ConfigError(f"{key}: a rig becomes a folder of the output, and {name} is one already: {', '.join(RESERVED)}")
    if rig.get("holdout") == "none":
        rig["holdout"] = []
    elif not rig.get("holdout"):
        raise ConfigError(f"{key}.holdout: missing: clips that no model may see, to measure it on")
    for clip in map(clip_of_block if "blocks" in rig["bake"] else str, rig["holdout"]):
        if "clips" in rig and clip not in rig["clips"]:
            raise ConfigError(f"{key}.holdout: {clip} is not among its clips: {', '.join(rig['clips'])}")
    settle_composed(key, rig, farm["rigs"][name])
    check_poses(key, rig)
    check_convention(f"{key}.fit.convention", rig)
    for part, known in (("materials", farm["materials"]), ("lights", farm["lights"])):
        rig.setdefault(part, list(known))
        for item in rig[part]:
            if item not in known:
                raise ConfigError(f"{key}.{part}: {item} is not among {part}: {', '.join(known)}")
    for slot, material in rig["pack"].get("slot", {}).items():
        if material not in rig["materials"]:
            raise ConfigError(f"{key}.pack.slot.{slot}: {material} is not among its materials: {', '.join(rig['materials'])}")


def programs_folder(given, folder):
    """Returns $PENUMBRA_BIN, what the file says, the build of this checkout, the programs that this was installed with
    (packages/install.cmake), or those in the path."""
    wanted = os.environ.get("PENUMBRA_BIN") or (given and os.path.join(folder, os.path.expanduser(given)))
    for place in [wanted] if wanted else [os.path.join(ROOT, "build", "release", "bin"), os.path.join(ROOT, "..", "..", "bin")]:
        if os.path.isfile(os.path.join(place, "penumbra-bake")):
            return os.path.abspath(place)
    if wanted:
        raise ConfigError(f"programs: no penumbra-bake in {wanted}")
    if not shutil.which("penumbra-bake"):
        raise ConfigError("programs: no penumbra-bake in $PATH; say where it is, or run scripts/setup")
    return ""


def check_config(content, path):
    """Returns the Farm that `content`, as read from the YAML file `path`, describes. Raises ConfigError."""
    folder = os.path.dirname(os.path.abspath(path))
    farm = FARM("", content, folder)
    rigs = {name: with_defaults(farm.get("defaults", {}), rig) for name, rig in farm["rigs"].items()}
    for name, rig in rigs.items():
        check_rig(name, rig, farm)
    jobs = {rule: {"threads": 1, "memory_mb": 2000, "minutes": 60, **farm.get("jobs", {}).get(rule, {})} for rule in RULES}
    pictures = {"frames": 3, "size": 320, "camera": "yaw=35,pitch=12", **farm.get("pictures", {})}
    output = os.path.normpath(os.path.join(folder, os.path.expanduser(farm["output"])))
    return Farm(os.path.abspath(path), output, programs_folder(farm.get("programs"), folder), rigs, farm["materials"],
                farm["lights"], pictures, jobs)


def load_yaml(file):
    """Loads as yaml.safe_load() does, but a key that stands there twice is an error: PyYAML would keep the last
    one."""
    import yaml

    class Loader(yaml.SafeLoader):
        def construct_mapping(self, node, deep=False):
            names = [key.value for key, _ in node.value]
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise yaml.constructor.ConstructorError(None, None, f"{name}: stands here twice", node.value[i][0].start_mark)
            return super().construct_mapping(node, deep)

    return yaml.load(file, Loader)


def read_config(path):
    import yaml
    try:
        with open(path, encoding="utf-8") as file:
            content = load_yaml(file)
    except OSError as error:
        raise Unreadable(f"{path}: cannot read: {error.strerror}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: not YAML: {' '.join(str(error).split())}") from None
    except (ValueError, RecursionError, TypeError) as error:
        # Other letters than UTF-8, a date that is none, or a thousand brackets.
        raise ConfigError(f"{path}: not YAML that can be read: {' '.join(str(error).split())[:120]}") from None
    try:
        return check_config(content, path)
    except ConfigError as error:
        raise type(error)(f"{path}: {error}") from None
