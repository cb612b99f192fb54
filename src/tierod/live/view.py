"""The drive in a terminal: verdicts, estimates with their bands as sparklines, what is missing, loads; and its keys."""

from __future__ import annotations

import contextlib
import math
import os
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tierod.core.shown import shown as in_shown_unit

if TYPE_CHECKING:
    from rich.console import Group

    from tierod.live.drive import Drive
    from tierod.live.judge import Shown

KEYS = "m mark   p pause   r report now   q end"

_BARS = "▁▂▃▄▅▆▇█"

_COLOURS = {"healthy": "green", "fault": "bold red", "suspect": "red", "rising": "yellow"}


def sparkline(values: Sequence[float], width: int = 24) -> str:
    """The last values as bars between their lowest and highest; a blank where one is missing."""
    last = list(values)[-width:]
    known = [each for each in last if math.isfinite(each)]
    if not known:
        return ""
    low, high = min(known), max(known)
    scale = (len(_BARS) - 1) / (high - low) if high > low else 0.0
    return "".join(_BARS[round((each - low) * scale)] if math.isfinite(each) else " " for each in last)


def picture(drive: Drive) -> Group:
    """What the terminal shows now."""
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    engine = drive.engine
    table = Table(box=None, pad_edge=False)
    for title in ("monitor", "verdict", "since [s]", "learning", "estimate", ""):
        table.add_column(title)
    for each in engine.shown():
        rows = _estimates(each) or [("", "")]
        colour = _COLOURS.get(str(each.status), "dim")
        learning = "" if math.isnan(each.enabled) else f"{each.enabled:.0%}"
        verdict = Text(str(each.status), style=colour)
        for place, (estimate, bars) in enumerate(rows[:3]):
            first = (each.monitor, verdict, f"{each.since:.1f}", learning) if not place else ("", "", "", "")
            table.add_row(*first, Text(estimate), Text(bars))
        if each.reason:
            table.add_row("", "", "", "", Text(each.reason[:120], style="dim"), "")
    late = sorted(drive.health.late)[-1] if drive.health.late else 0.0
    lines = [
        f"time {max(engine.clock.latest, 0.0):.1f} s   frames {engine.tally.frames}   lost {engine.gaps.lost}"
        f"   late {engine.clock.late}   jumps {engine.clock.jumps}   latest tick {1e3 * late:.1f} ms late"
        f"   processor {_load():.0%}",
        f"missing: {', '.join(engine.missing[:6])}" if engine.missing else "all signals are there",
        ("PAUSED   " if drive.paused else "") + KEYS,
    ]
    return Group(table, *(Text(line) for line in lines))


def _estimates(each: Shown) -> list[tuple[str, str]]:
    found = []
    for name, value in each.values.items():
        deviation = each.values.get(f"{name}_standard_deviation")
        if deviation is None:
            continue
        factor, unit = in_shown_unit(each.units.get(name, ""))
        text = f"{name} {factor * value:.4g} ± {factor * 1.96 * deviation:.2g} {unit}"
        found.append((text, sparkline(each.history.get(name, ()))))
    return found


_USED = [0.0, 0.0]


def _load() -> float:
    """Share of one core that this process took since the last call."""
    now, used = time.monotonic(), time.process_time()
    share = (used - _USED[1]) / (now - _USED[0]) if now > _USED[0] > 0.0 else 0.0
    _USED[:] = [now, used]
    return max(share, 0.0)


@contextmanager
def keys() -> Iterator[None]:
    """Keys come one by one while the block runs; the terminal is as before afterwards."""
    try:
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        before = termios.tcgetattr(descriptor)
    except (ImportError, OSError, ValueError):
        yield
        return
    except Exception:  # termios.error has no other base
        yield
        return
    try:
        tty.setcbreak(descriptor)
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def pressed() -> str:
    """The key that was pressed since the last call; "" for none."""
    import select

    with contextlib.suppress(OSError, ValueError):
        if select.select([sys.stdin], [], [], 0.0)[0]:
            return os.read(sys.stdin.fileno(), 1).decode("ascii", "replace")
    return ""
