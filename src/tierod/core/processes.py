"""Processes of this machine."""

from __future__ import annotations

import os


def runs(process: int) -> bool:
    """Whether a process is running.

    Args:
        process: its identifier; a process of another user counts as well
    """
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # no permission to signal it: it belongs to another user
        return True
    return True
