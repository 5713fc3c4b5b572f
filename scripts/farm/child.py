"""Processes that end with the one that started them."""
import ctypes
import signal


def stop_with_parent():
    """Sends us SIGTERM when our parent is gone, even by kill -9: nobody would stop this job, and the next try would
    find its output taken. For preexec_fn of subprocess.Popen."""
    ctypes.CDLL(None).prctl(1, signal.SIGTERM)  # PR_SET_PDEATHSIG
