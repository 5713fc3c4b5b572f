"""How `penumbra` ends when it cannot do its work: one sentence that names what to do, and the exit code of our
programs."""

USAGE, UNREADABLE, INVALID, FAILED, UNSUPPORTED = 1, 2, 3, 4, 5


class Failure(Exception):
    """Ends the program with this sentence on stderr and this exit code."""

    def __init__(self, message, code=FAILED):
        super().__init__(message)
        self.code = code
