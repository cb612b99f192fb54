"""The walk of a diagnosis: the files of tierod that `tierod diagnose` of the demonstration's recording executes, warm.

A reader follows the functions in the order of their first call. A return is a step to a file that was left before.
`python scripts/walk.py` prints how many files and returns there are, with `--files` also every file.
"""

from __future__ import annotations

import contextlib
import io
import sys
import tempfile
from pathlib import Path
from types import CodeType, FrameType

import tierod
from tierod.cli import main as command
from tierod.io.demo import VEHICLE, copied

HOME = Path(tierod.__file__).parent


def walked(arguments: list[str]) -> list[str]:
    """Files of tierod whose functions a command executes, one for each step from a file to another one.

    Functions count once, at their first call; the body of a module is no function.
    """
    seen: set[CodeType] = set()
    steps: list[str] = []

    def note(frame: FrameType, event: str, _: object) -> None:
        code = frame.f_code
        if event != "call" or code in seen:
            return
        seen.add(code)
        file = code.co_filename
        if file.startswith(str(HOME)) and code.co_name != "<module>" and (not steps or steps[-1] != file):
            steps.append(file)

    sys.setprofile(note)
    try:
        command(arguments)
    finally:
        sys.setprofile(None)
    return [str(Path(each).relative_to(HOME)) for each in steps]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder, contextlib.redirect_stdout(io.StringIO()):
        arguments = ["diagnose", str(copied(Path(folder))), "--vehicle", VEHICLE, "--monitor", "friction", "--json"]
        command([*arguments, "--no-report"])  # kernels are compiled and modules imported now
        steps = walked([*arguments, "--no-report"])
    files = list(dict.fromkeys(steps))
    if "--files" in sys.argv:
        print(*files, sep="\n")
    print(f"{len(files)} files, {len(steps) - len(files)} returns")
