"""The command line: `tierod VERB ...`, one file per verb."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Args:
        arguments: arguments without the name of the program; those of the process if not given
    """
    from tierod.cli.streams import abandon_output, failed_output, open_closed_streams

    open_closed_streams()
    given = list(sys.argv[1:] if arguments is None else arguments)
    if arguments is None:
        # In a process of the command line, and in its workers, no script can have changed a constant of a compiled
        # graph.
        os.environ.setdefault("TIEROD_GRAPHS", "known")
    if given in (["--version"], ["-V"]):
        from tierod.core.version import __version__

        try:
            print(f"tierod {__version__}", flush=True)
        except OSError as error:
            abandon_output()
            return failed_output(error)
        return 0

    from tierod.cli.app import run
    from tierod.core.processes import one_thread_each

    one_thread_each()
    return run(given)
