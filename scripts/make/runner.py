"""Runs jobs one after the other through the farm's farm_stamp, prints each command that must run, and shows one
progress over all of them."""
import fcntl
import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time

from farm.child import stop_with_parent
from farm.plan import ranges_of, report_of, stamped
from farm.stamps import Digests, ForeignFile, read_stamp, remove, why_stale, write_whole
from make.failure import FAILED, INVALID, Failure

# Seconds on two cores of a character of middle size. Only their ratios count, for the share of the whole that is done.
COSTS = {"bake": 60, "clip": 10, "shard": 10, "poses": 90, "fields": 8, "fit": 20, "check": 5, "picture": 3}
AGAIN = "the same command goes on where this one stopped"


class Progress:
    """Tells how far all is: one line that is drawn again on a terminal, else a line now and then."""

    def __init__(self, total, quiet):
        self.total, self.done, self.quiet = total, 0.0, quiet
        self.live = sys.stdout.isatty() and not quiet
        self.started = self.told = time.monotonic()

    def say(self, text):
        if not self.quiet:
            print(("\r\033[K" if self.live else "") + text, flush=True)

    def show(self, what, share, cost):
        """`share` of a job that costs `cost` is done."""
        percent = min(int(100 * (self.done + share * cost) / max(self.total, 1e-9)), 100)
        line, now = f"[{percent:3d}%] {what}", time.monotonic()
        if self.live:
            print("\r\033[K" + line[:shutil.get_terminal_size().columns - 1], end="", flush=True)
        elif not self.quiet and now - self.told >= 10:
            self.told = now
            print(line, flush=True)

    def finish(self):
        if self.live:
            print("\r\033[K", end="", flush=True)


def cost_of(jobs):
    return sum(COSTS.get(job.rule, 1) for job in jobs)


def lock(folder):
    """Returns the lock of a folder, which one `penumbra make` at a time holds. A job that outlives a killed one holds
    it, too, until it has cleaned up."""
    os.makedirs(os.path.join(folder, ".farm"), exist_ok=True)
    file = open(os.path.join(folder, ".farm", "lock"), "a")
    until = time.monotonic() + 15
    while True:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            return file
        except BlockingIOError:
            if time.monotonic() > until:
                raise Failure(f"{folder}: another penumbra works here; wait for it, or give another -o", FAILED) from None
            time.sleep(0.2)


def has_report(path):
    try:
        with open(path) as file:
            json.load(file)
    except (OSError, ValueError):
        return False
    return True


class Runner:
    def __init__(self, folder, total, quiet, held):
        self.folder, self.held = folder, held
        self.progress = Progress(total, quiet)
        self.ran = []

    def log_of(self, output):
        return os.path.join(self.folder, "log", output.replace("/", ".") + ".txt")

    def reason(self, job):
        """Returns why the job must run, or "". Raises Failure where a file is not the one that was made here."""
        digests = Digests(self.folder)
        gone = bool(job.merged) and os.path.exists(os.path.join(self.folder, job.merged)) and read_stamp(self.folder, job.merged)
        try:
            return why_stale(self.folder, job.output, job.command, [*job.inputs, *job.sources], digests,
                             temporary=bool(gone)) or self.lost(job)
        except ForeignFile as error:
            raise Failure(os.path.join(self.folder, str(error)), INVALID) from None
        except FileNotFoundError:
            return "an input is not there"
        finally:
            digests.save()

    def lost(self, job):
        """Returns what the page needs of a job and is no longer there, or "". The job then loses its stamp: by that
        farm_stamp would leave it out."""
        reason = ""
        if not os.path.exists(self.log_of(job.output)):
            reason = "what it said is lost"
        elif not has_report(os.path.join(self.folder, report_of(job.output))):
            reason = "its report is lost or damaged"
        if reason:
            remove(os.path.join(self.folder, job.output + ".stamp"))
        return reason

    def run(self, jobs):
        for job in jobs:
            if reason := self.reason(job):
                if not self.ran:
                    self.progress.say(f"cd {shlex.quote(self.folder)}")
                reason = re.sub(r" formats: .*?(?=, now |$)", "", reason)  # both versions say it
                self.progress.say(f"# {job.output}: {reason}\n{shlex.join(map(str, job.command))}")
                self.run_job(job)
                self.ran.append(job)
            self.progress.done += COSTS.get(job.rule, 1)
            self.progress.show(job.rule, 0, 0)
            if job.rule == "merge":
                for piece in ranges_of(job):
                    remove(os.path.join(self.folder, piece))

    def run_job(self, job):
        words = stamped(job, *(["--merged", job.merged] if job.merged else []))
        child = subprocess.Popen(words, cwd=self.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 text=True, errors="replace", preexec_fn=stop_with_parent, pass_fds=[self.held.fileno()])
        try:
            lines = self.follow(job, child)
            code = child.wait()
        except KeyboardInterrupt:
            child.send_signal(signal.SIGINT)  # a terminal has told it already, others may have told us alone
            child.wait()
            self.progress.finish()
            raise Failure(f"stopped; {AGAIN}", FAILED) from None
        write_whole(self.log_of(job.output), "".join(lines))
        if code != 0:
            self.progress.finish()
            raise Failure(self.why_failed(job, lines, code), code if code in (1, 2, 3, 5) else FAILED)

    def follow(self, job, child):
        """Shows the progress of a job. Returns its other lines."""
        lines, share, cost = [], 0.0, COSTS.get(job.rule, 1)
        what = f"{job.rule} {job.output}"
        self.progress.show(what, 0, cost)
        for line in child.stdout:
            if found := re.match(r"openjd_progress: ([\d.]+)", line):
                share = float(found[1]) / 100
                self.progress.show(what, share, cost)
            elif found := re.match(r"openjd_status: (.*)", line):
                what = f"{job.rule}: {found[1]}"
                self.progress.show(what, share, cost)
            else:
                lines.append(line)
                if ": warning: " in line:
                    self.progress.say(line.rstrip())
        return lines

    def why_failed(self, job, lines, code):
        said = [line.strip() for line in lines if line.strip()]
        named = [line for line in said if re.match(r"(penumbra-\w+|farm_stamp): ", line) and ": warning: " not in line]
        last = (named or said or [f"exit code {code}"])[-1]
        return f"{job.rule} failed: {last} (all that it said: {self.log_of(job.output)}; after a change {AGAIN})"
