"""How the scripts of the farm end: with a sentence and an exit code of our programs, never with a traceback."""
import os
import sys
import traceback

from farm.config import ConfigError, exit_code
from farm.stamps import ForeignFile


def sentence(error):
    """Returns what to tell of an error."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename is not None else error.strerror
    if isinstance(error, (ConfigError, ForeignFile)):
        return str(error)
    if isinstance(error, ModuleNotFoundError) and error.name:
        name = error.name.split(".")[0]
        return f"needs the Python module {name} (apt-get install python3-{name.lower()})"
    where = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}: {error} ({os.path.basename(where.filename)}, line {where.lineno}); PENUMBRA_TRACEBACK=1 shows more"


def end_with(main):
    """Runs main() and exits with what it returns, or with an error in one line."""
    name = os.path.basename(sys.argv[0])
    try:
        code = main()
        sys.stdout.flush()
    except KeyboardInterrupt:
        print(f"{name}: interrupted", file=sys.stderr)
        code = 4
    except BrokenPipeError:  # nobody reads what we print
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = 2
    except Exception as error:
        if os.environ.get("PENUMBRA_TRACEBACK"):
            traceback.print_exc()
        print(f"{name}: {sentence(error)}", file=sys.stderr)
        code = exit_code(error) if isinstance(error, (ConfigError, ForeignFile, OSError)) else 4
    sys.exit(code)
