"""The program: `python -m sideray render scene.glb -o picture.png`, and the command `sideray` (docs/cli.md)."""

import os
import pathlib
import signal
import sys

# In a wheel the program itself; elsewhere a link to the one that was built or installed with the package.
_PROGRAM = pathlib.Path(__file__).parent / "bin" / "sideray"


def main() -> None:
    """Becomes the program, with this process's arguments, streams and environment; returns never."""
    # Python ignores them, which the program would inherit: `sideray option-list | head` is to end with head.
    for name in ("SIGPIPE", "SIGXFSZ"):
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    try:
        os.execv(_PROGRAM, ["sideray", *sys.argv[1:]])
    except OSError as error:
        sys.exit(f"sideray: {_PROGRAM}: {error.strerror}; build the target `sideray`, or install the package again")


if __name__ == "__main__":
    main()
