"""The command line: `tierod VERB ...`, one file per verb."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Args:
        arguments: without the name of the program; those of the process where not given
    """
    given = list(sys.argv[1:] if arguments is None else arguments)
    if given in (["--version"], ["-V"]):
        from tierod import __version__

        print(f"tierod {__version__}")
        return 0

    from tierod.cli.app import run
    from tierod.core.threads import one_thread_each

    one_thread_each()
    return run(given)
