"""Where a character's files are. Names tell characters apart, also those of two .blend files in one folder."""
import contextlib
import getpass
import hashlib
import pathlib
import tempfile

import bpy

from .programs import Failed


def folder_of(settings):
    """Where the files of a character go: beside the .blend, or in the user's own temporary folder without a .blend."""
    unsaved = settings.folder.startswith("//") and not bpy.data.filepath
    if unsaved:
        folder = pathlib.Path(tempfile.gettempdir()) / f"penumbra-{user()}"
    else:
        folder = pathlib.Path(bpy.path.abspath(settings.folder))
    try:
        folder.mkdir(mode=0o700 if unsaved else 0o777, parents=True, exist_ok=True)
    except OSError as error:
        raise Failed(f"{folder} cannot be made: {error.strerror}") from error
    return folder


def user():
    try:
        return bpy.path.clean_name(getpass.getuser())
    except (KeyError, OSError, ImportError):  # a container may have no name for its user
        return "nobody"


def file_of(settings, ending):
    """BLEND.CHARACTER.HASH and the ending. The hash tells names apart that are the same without their odd letters."""
    blend, name = pathlib.Path(bpy.data.filepath).stem or "untitled", settings.id_data.name
    short = hashlib.sha256(f"{blend}/{name}".encode()).hexdigest()[:6]
    clean = [bpy.path.clean_name(word)[:60] for word in (blend, name)]
    return folder_of(settings) / (".".join([*clean, short]) + ending)


@contextlib.contextmanager
def scratch(settings, ending):
    """The name of a file that nobody needs after the block."""
    path = file_of(settings, ending)
    try:
        yield path
    finally:
        with contextlib.suppress(OSError):
            path.unlink()
