"""The command line of `penumbra`: its verbs, and which program does the work of each."""
import difflib
import os
import re
import sys

from make import doctor, make, pictures, programs
from make.efforts import EFFORTS
from make.failure import FAILED, INVALID, UNREADABLE, USAGE, Failure
from usage import ArgumentParser

HELP = """penumbra FILE...              make an asset of a character or a cloth, and show it
penumbra VERB ...

  make FILE... [-o X.pnb]     an asset with pictures beside ray-traced truth, and a page; further files bring clips
  view X.pnb...               a window: play, relight, compare with the truth
  render X.pnb -o OUT.png     pictures without a window
  export X.pnb [RIG.glb] -o OUT   occlusion for other programs (docs/exports.md)
  info FILE                   what is in a file: rig, bake, model, asset, light, material or picture
  doctor [FILE]               what is installed; what would go wrong with a file
  help [VERB]                 the same as VERB --help

A file that is named like a verb is given as ./view. $PENUMBRA_BIN says where the programs lie.
Exit codes: 0 done, 1 usage, 2 cannot read or write, 3 input invalid, 4 failed while running or stopped, 5 unsupported
"""
MAKE = """Makes an asset of a character, a cloth or a still mesh: X.pnb and the page X.html, which shows it beside ray-traced
truth. Everything else lies in X.penumbra/. A second run makes again what has changed, and nothing else; after a kill it
goes on where it stopped."""
# verb -> program and verb of it
OTHERS = {"view": ("penumbra-player", "view"), "render": ("penumbra-player", "render"), "export": ("penumbra-pack", "export")}
VERBS = ("make", *OTHERS, "info", "doctor", "help")


def verb_parser(verb, description):
    parser = ArgumentParser(description)
    parser.prog = f"penumbra {verb}"
    return parser


def add_meshes(parser):
    parser.add_argument("--nodes", action="append", metavar="NODE", help="only the meshes of these nodes and of those below them; names "
                        "or globs; several with commas between")
    parser.add_argument("--without", action="append", metavar="NODE", help="leave out the meshes of these nodes and of those below "
                        "them; several with commas between")


def meshes_of(given):
    """Returns (key of a farm's rig, value) of what add_meshes() has added."""
    return [(f"bake.{key}", ",".join(texts)) for key in ("nodes", "without") if (texts := getattr(given, key))]


def make_parser():
    parser = verb_parser("make", MAKE)
    parser.add_argument("files", nargs="+", metavar="FILE", help="the mesh and its clips; further files may bring clips only")
    parser.add_argument("-o", "--output", help="X.pnb (default: the name of the first file, here)")
    parser.add_argument("--light", help="a picture (.exr, .hdr), or a text as of penumbra-fit light --analytic (default: a clear sky)")
    parser.add_argument("--effort", choices=EFFORTS, default="good", help="draft: a first picture soon; best: more rays, and poses that "
                        "trial fits choose (default: good)")
    parser.add_argument("--clips", action="append", metavar="CLIP", help="only these clips; several with commas between (default: all; "
                        "draft takes 6, spread over the list)")
    parser.add_argument("--holdout", action="append", metavar="CLIP", help="clips that the model may not see, to measure it on; "
                        "several with commas between, auto or none (default: auto)")
    parser.add_argument("--fps", type=float, help="samples a second of the clips (default: by the effort)")
    add_meshes(parser)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a key of a farm's rig (docs/farm.md), as "
                        "in bake.rays=512 or bake.up=z; or of its light, as in light.layout=angular")
    parser.add_argument("-q", "--quiet", action="store_true", help="no messages but errors")
    return parser


def names_of(text):
    """Splits names at commas, but not at \\, (docs/clips.md)."""
    return [re.sub(r"\\([\\,])", r"\1", name) for name in re.findall(r"(?:\\[\\,]|[^,])+", text)]


def request_of(words):
    given = make_parser().parse_args(words)
    if given.fps is not None and not 0 < given.fps <= 1000:
        raise Failure(f"--fps: takes a number above 0, at most 1000, not {given.fps:g}", USAGE)
    first = os.path.basename(given.files[0].rstrip("/"))
    stem = first if os.path.isdir(given.files[0]) else os.path.splitext(first)[0]
    if not given.output and not stem.strip("."):
        raise Failure(f"'{given.files[0]}' gives the asset no name; give one with -o", USAGE)
    output = given.output or stem + ".pnb"
    if not output.endswith(".pnb") or os.path.basename(output) == ".pnb":
        raise Failure(f"-o: takes a name that ends with .pnb, not '{output}'", USAGE)
    clips, held = ([name for text in texts or [] for name in names_of(text)] for texts in (given.clips, given.holdout))
    holdout = None if not held or held == ["auto"] else [] if held == ["none"] else held
    light = given.light
    return make.Request([os.path.abspath(path) for path in given.files], os.path.abspath(output), light, given.effort,
                        clips or None, holdout, given.fps, [*meshes_of(given), *(make.setting(text) for text in given.set)], given.quiet)


def has_screen():
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def make_and_show(words):
    request = request_of(words)
    if len(request.files) == 1 and request.files[0].endswith(".pnb"):
        show(request.files[0])
    make.make(request)
    show(request.output, make.truth_of(request.output), request.quiet)


def show(asset, truth=None, quiet=False):
    """Opens the window, where there is a screen. What was just made lies beside its page and pictures."""
    if has_screen():
        programs.become("penumbra-player", ["view", asset, *(["--truth", truth] if truth else [])])
    if not truth:
        raise Failure(f"{asset}: there is no screen for a window; penumbra render {asset} -o picture.png draws it", FAILED)
    if not quiet:
        print("there is no screen for a window: look at the page or the pictures")


def info(words):
    shown = [path for path in words if os.path.isfile(path) and pictures.kind_of(path)]
    others = [word for word in words if word not in shown]
    if shown and any(word.startswith("-") for word in others):
        raise Failure("info: takes no options beside a picture", USAGE)
    refused = False
    for path in shown:
        for name, text in pictures.describe(path):
            print(f"{name:<22} {text}", flush=True)
            refused |= str(text).startswith("no: ")
    return programs.become("penumbra-bake", ["info", *others]) if others or not shown else INVALID if refused else 0


def run_doctor(words):
    parser = verb_parser("doctor", "Says what is installed and what is missing; with files, what would go wrong with them.")
    parser.add_argument("files", nargs="*", metavar="FILE")
    add_meshes(parser)
    given = parser.parse_args(words)
    return doctor.doctor(given.files, [word for key, text in meshes_of(given) for word in (f"--{key[5:]}", text)])


def version():
    for name in programs.NAMES:
        said = programs.ask(programs.find(name), "--version")
        print(said.stdout.splitlines()[0] if said.stdout else f"{name}: does not start")
    return 0


def tell(words):
    """Prints what there is, or the options of one verb."""
    if not words or words[0] in ("help", "--help", "-h"):
        print(HELP, end="")
        return 0
    if words[0] not in VERBS:
        raise Failure(f"{words[0]}: no verb; penumbra help lists them", USAGE)
    return run_verb(words[0], ["--help"])


def run_verb(verb, words):
    if verb == "help":
        return tell(words)
    if verb == "make":
        return make.make(request_of(words))
    if verb in OTHERS:
        program, own = OTHERS[verb]
        return programs.become(program, [own, *words])
    return info(words) if verb == "info" else run_doctor(words)


def neither(word):
    """Refuses a word that is no verb and no file."""
    near = difflib.get_close_matches(word, VERBS, 1)
    raise Failure(f"{word}: no such file, and no verb" + (f"; did you mean {near[0]}?" if near else "; penumbra help lists the verbs"),
                  USAGE if near else UNREADABLE)


def run(words):
    if not words or words[0] in ("-h", "--help"):
        print(HELP, end="")
        return 0 if words else USAGE
    if words[0] == "--version":
        return version()
    if words[0] in VERBS:
        return run_verb(words[0], words[1:])
    if not words[0].startswith("-") and not make.files_of(words[0]):
        neither(words[0])
    return make_and_show(words)


def main(words):
    """Returns the exit code. No traceback reaches a user."""
    try:
        return run(words) or 0
    except Failure as error:
        print(f"penumbra: {error}", file=sys.stderr)
        return error.code
    except KeyboardInterrupt:
        print("penumbra: stopped", file=sys.stderr)
        return FAILED
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return FAILED
    except Exception as error:  # a mistake of ours: the sentence is what a report of it needs
        place = error.__traceback__
        while place.tb_next:
            place = place.tb_next
        print(f"penumbra: a mistake in penumbra itself: {type(error).__name__}: {error} "
              f"({os.path.basename(place.tb_frame.f_code.co_filename)}:{place.tb_lineno})", file=sys.stderr)
        return FAILED
