"""`penumbra make`: from files to an asset, pictures and a page."""
import json
import os
import re
import shutil
import time
from dataclasses import dataclass

from farm.config import ConfigError, exit_code, files_of
from farm.stamps import Digests, write_whole
from make import page, programs
from make.failure import UNREADABLE, USAGE, Failure
from make.plan import PATTERNS, MakePlan, name_of, report_path
from make.runner import Runner, cost_of, lock


@dataclass
class Request:
    """The request of a command line."""
    files: list     # absolute; the first has the mesh
    output: str     # absolute, X.pnb
    light: str      # a picture, a text as of --analytic, or None
    effort: str     # a key of EFFORTS
    clips: list     # or None to choose
    holdout: list   # clips, or None to choose
    fps: float      # or None to choose
    settings: list  # (key of a farm's rig, value)
    quiet: bool


def work_folder(output):
    """Returns where everything but the asset and its page lies."""
    return output.removesuffix(".pnb") + ".penumbra"


def truth_of(output):
    """Returns where the baked frames of an asset lie, to look at beside it."""
    return os.path.join(work_folder(output), PATTERNS["truth"].format(rig=name_of(output)))


def missing(path):
    """Returns the failure of a path that names no file."""
    what = "is a folder without numbered files" if os.path.isdir(path) else "no such file"
    return Failure(f"{path}: {what}", UNREADABLE)


def check_files(request):
    for path in request.files:
        if not files_of(path):
            raise missing(path)
    folder = os.path.dirname(request.output)
    if not os.path.isdir(folder):
        raise Failure(f"{folder}: no such folder; make it, or give another -o", UNREADABLE)
    if not os.access(folder, os.W_OK):
        raise Failure(f"{folder}: cannot be written to; give another place with -o", UNREADABLE)
    if not os.path.isdir(work_folder(request.output)):
        for path in (request.output, page_of(request.output)):
            if os.path.exists(path):
                raise Failure(f"{path}: is there, and was not made here; give another -o, or delete it", UNREADABLE)


def plainly(error):
    """Returns the sentence of a ConfigError in the words of this command line."""
    key, _, said = str(error).partition(": ")
    said = [line for line in said.splitlines() if ": warning: " not in line][-1:]  # a program warns before it refuses
    text = ": ".join([key, *said])
    text = re.sub(r"^(rigs|materials)\.[^.: ]+(\.|: )|^make: ", "", text)
    text = re.sub(r"^lights\.[^.: ]+(\.picture: |: )", "--light: ", text)
    text = re.sub(r"^lights\.[^.: ]+\.", "light.", text)
    text = re.sub(r"^([\w-]+: )?penumbra-\w+: ", r"\1", text)
    return re.sub(r"^(clips|holdout|fps): ", r"--\1: ", text)


def make(request):
    """Makes the asset and its page."""
    check_files(request)
    place, folder = programs.folder(), work_folder(request.output)
    for name in programs.NAMES:
        programs.find(name)
    try:
        os.makedirs(folder, exist_ok=True)
        with lock(folder) as held:
            try:
                return run_all(request, folder, place, held)
            except ConfigError:
                if os.listdir(folder) == [".farm"]:
                    shutil.rmtree(folder)
                raise
    except ConfigError as error:
        raise Failure(plainly(error), exit_code(error)) from None
    except BrokenPipeError:  # nobody reads what is told
        raise
    except OSError as error:
        raise Failure(f"{error.filename or folder}: {error.strerror}", UNREADABLE) from None


def run_all(request, folder, place, held):
    started = time.monotonic()
    plan = MakePlan(request, folder, place)
    first, checks = plan.asset_jobs()
    jobs = [*first, *checks]
    runner = Runner(folder, cost_of(jobs) + 3 * (1 + 3 * plan.effort.pictures) + 1, request.quiet, held)
    runner.run(first)
    publish(folder, plan.path("pack"), request.output)
    picture = plan.first_picture()
    runner.run([picture])
    if picture in runner.ran:
        runner.progress.say(f"first picture after {time.monotonic() - started:.0f} s: {os.path.join(folder, picture.output)}")
    runner.run(checks)
    with open(report_path(folder, picture.output)) as file:
        pictures = plan.picture_jobs(json.load(file))
    runner.run(pictures)
    jobs += [picture, *pictures]
    description, warned = page.describe(plan, runner, jobs, request)
    page.write_if_new(os.path.join(folder, "page.json"), json.dumps(description, indent=1))
    last = plan.page_job("page.json")
    runner.run([last])
    with open(os.path.join(folder, last.output)) as file:
        page.write_if_new(page_of(request.output), page.embed(file.read(), folder))
    runner.progress.finish()
    remove_old(os.path.join(folder, "pictures"), {os.path.basename(job.output) for job in [picture, *pictures]})
    tell(request, runner, description, warned, time.monotonic() - started)


def remove_old(folder, wanted):
    """Removes the pictures of another effort, with their stamps."""
    for name in os.listdir(folder):
        if name.split(".png")[0] + ".png" not in wanted:
            os.remove(os.path.join(folder, name))


def publish(folder, made, output):
    """Copies the asset beside its page, unless it lies there."""
    digests = Digests(folder)
    if not os.path.exists(output) or digests.of(output) != digests.of(made):
        with open(os.path.join(folder, made), "rb") as file:
            write_whole(output, file.read())
    digests.save()


def counted(count, what):
    return f"{count} {what}" + ("" if count == 1 else "s")


def page_of(output):
    return output.removesuffix(".pnb") + ".html"


def tell(request, runner, description, warned, seconds):
    say = runner.progress.say
    if not runner.ran:
        say("nothing has changed: nothing was run")
    else:
        say(f"{counted(len(runner.ran), 'job')} in {seconds:.0f} s; {counted(len(warned), 'warning')}, which the page lists")
    for fact in description["facts"][1:]:
        say(fact)
    say(f"asset     {request.output}\npage      {page_of(request.output)}\npictures  {os.path.join(runner.folder, 'pictures')}")


def setting(text):
    """Returns (key, value) of KEY=VALUE. The value is JSON where it can be, else text."""
    key, equals, value = text.partition("=")
    if not equals or not re.fullmatch(r"[a-z_]+(\.[A-Za-z0-9_-]+)*", key):
        raise Failure(f"--set: takes KEY=VALUE as in bake.rays=512, not '{text}'", USAGE)
    try:
        return key, json.loads(value)
    except ValueError:
        return key, value
