"""Other processes of this machine."""

from __future__ import annotations

import os


def runs(process: int) -> bool:
    """Whether a process of this number runs.

    Args:
        process: number of it; one of another user counts as well
    """
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:
        return True
    return True
