"""Processor time of programs. What else runs on the machine hardly changes it, unlike the time on the clock."""
import os
import resource


def of_ended_children():
    """Seconds of all programs that were started here and have ended."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def of_running(pid):
    """Seconds that a running program has taken so far."""
    with open(f"/proc/{pid}/stat") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def stop(process, number):
    """Sends a signal to a program and waits for its end.

    Returns what the program wrote to stderr and the processor time that it still took, divided by the number of cores.
    On a machine with nothing else to do a program that keeps all cores busy ends after so many seconds. One that waits
    for something else must end within ten seconds, however busy the machine is.
    """
    ended = of_ended_children()
    used = of_running(process.pid)
    process.send_signal(number)
    _, errors = process.communicate(timeout=10)
    return errors, (of_ended_children() - ended - used) / len(os.sched_getaffinity(0))
