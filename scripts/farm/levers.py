"""Snakemake decides by time stamps. So that content decides, every job has one more input, a small file under
.farm/levers, whose time is set by what the stamps say: old where the job's output is current, new where it is not."""
import os
import sys
import time

from farm.stamps import Digests, why_stale, write_whole


def lever(output):
    return f".farm/levers/{output}"


def follows(path, reason):
    """Returns why what is made from a stale `path` is stale: the first cause."""
    return reason if reason.startswith("follows ") else f"follows {path}: {reason}"


def stale_jobs(plan, folder, digests):
    """Returns output -> reason for every job that must run. What is made from such an output is stale too, in no
    order."""
    stale = {}
    for output, job in plan.items():
        again = [path for path in job.inputs if path in stale]
        reason = follows(again[0], stale[again[0]]) if again else \
            why_stale(folder, output, job.command, [*job.inputs, *job.sources], digests, job.temporary)
        if reason:
            stale[output] = reason
            for path in job.inputs:  # a shard that was not kept, and is wanted again
                if plan[path].temporary and not os.path.exists(os.path.join(folder, path)):
                    stale.setdefault(path, "is not there")
    return stale


def set_levers(plan, folder):
    """Prepares Snakemake's decision, and names what is stale though it is there. Raises ForeignFile."""
    os.makedirs(os.path.join(folder, ".farm", "log"), exist_ok=True)  # folder for jobs on other machines
    digests = Digests(folder)
    try:
        stale = stale_jobs(plan, folder, digests)
    finally:
        digests.save()
    for output in plan:
        path = os.path.join(folder, lever(output))
        if output in stale:
            if os.path.exists(os.path.join(folder, output)):
                print(f"farm: {output}: {stale[output]}", file=sys.stderr)
            # The text is never the same, because Snakemake compares small files.
            write_whole(path, f"{time.time_ns()} {stale[output]}\n")
        elif not os.path.exists(path):
            write_whole(path, "")
        if output not in stale:
            os.utime(path, (0, 0))
