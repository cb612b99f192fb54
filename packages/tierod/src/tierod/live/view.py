"""Display of the drive in a terminal: verdicts, estimates with sparklines, missing signals, loads; and its keys."""

from __future__ import annotations

import contextlib
import math
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from tierod.core.shown import shown as in_shown_unit

if TYPE_CHECKING:
    from rich.console import Group

    from tierod.live.drive import Drive
    from tierod.live.judge import Shown

KEYS = "m mark   p pause   q end"

OLDEST_SHOWN = 4  # Number of signals whose age is shown, the oldest first

LATE = 0.5  # Delay of a verdict from which it is shown [s]

_BARS, _WIDTH = "▁▂▃▄▅▆▇█", 24


def sparkline(values: Sequence[float]) -> str:
    """The last values as bars between their minimum and maximum; a blank where a value is missing."""
    last = list(values)[-_WIDTH:]
    known = [each for each in last if math.isfinite(each)]
    if not known:
        return ""
    low, high = min(known), max(known)
    scale = (len(_BARS) - 1) / (high - low) if high > low else 0.0
    return "".join(_BARS[round((each - low) * scale)] if math.isfinite(each) else " " for each in last)


def picture(drive: Drive) -> Group:
    """Current display of the drive."""
    from rich.console import Group
    from rich.table import Table
    from rich.text import Text

    engine = drive.engine
    table = Table(box=None, pad_edge=False)
    for title in ("monitor", "verdict", "since [s]", "learning", "estimate", ""):
        table.add_column(title)
    for each in engine.shown():
        rows = _estimates(each) or [("", "")]
        learning = "" if math.isnan(each.enabled) else f"{each.enabled:.0%}"
        verdict = Text(f"{each.status.symbol} {each.status}", style=each.status.style)
        if not each.reason and engine.delay >= LATE:
            verdict.append(f" (up to {engine.delay:.1f} s late)", style="dim")
        for place, (estimate, bars) in enumerate(rows[:3]):
            first = (each.monitor, verdict, f"{each.since:.1f}", learning) if not place else ("", "", "", "")
            table.add_row(*first, Text(estimate), Text(bars))
    return Group(table, *(Text(line) for line in _lines(drive)))


def _lines(drive: Drive) -> list[str]:
    engine = drive.engine
    happened = "".join(f"   {what} {count}" for what, count in sorted(drive.health.notices.items()))
    missing = f"missing: {', '.join(engine.missing[:6])}" if engine.missing else "all signals are there"
    oldest = sorted(engine.ages.items(), key=lambda each: -each[1])[:OLDEST_SHOWN]
    # Ages are determined when a piece is judged, which waits this long for late frames.
    ages = ", ".join(f"{name} {max(age - engine.pace.order, 0.0):.2f} s" for name, age in oldest)
    return [
        f"time {max(engine.clock.latest, 0.0):.1f} s   frames {engine.tally.frames}   lost {engine.gaps.lost}"
        f"   late {engine.clock.late}   doubled {engine.clock.doubled}   jumps {engine.clock.jumps}{happened}",
        f"{_bus_loads(drive)}   processor {drive.health.load():.0%}",
        missing + (f"   oldest: {ages}" if ages else ""),
        *(f"not run: {each.monitor}: {each.reason}" for each in engine.shown() if each.reason),
        ("PAUSED   " if drive.paused else "") + KEYS,
    ]


def _bus_loads(drive: Drive) -> str:
    loads = drive.health.traffic.loads()
    if not loads:
        return "no traffic"
    texts = [f"CAN{bus} {each.frames:.0f} frames/s, {each.load:.0%} of {each.rate}" for bus, each in loads.items()]
    return "   ".join(texts)


def _estimates(each: Shown) -> list[tuple[str, str]]:
    found = []
    for name, value in each.values.items():
        deviation = each.values.get(f"{name}_standard_deviation")
        if deviation is None:
            continue
        factor, unit = in_shown_unit(each.units.get(name, ""))
        text = f"{name} {factor * value:.4g} ± {factor * deviation:.2g} {unit}"
        found.append((text, sparkline(each.history.get(name, ()))))
    return found


@contextmanager
def keys() -> Iterator[None]:
    """Read single key presses while the block runs; the terminal settings are restored afterwards."""
    try:
        import termios
        import tty

        descriptor = sys.stdin.fileno()
        before = termios.tcgetattr(descriptor)
    except (ImportError, OSError, ValueError):
        yield
        return
    except termios.error:
        yield
        return
    try:
        tty.setcbreak(descriptor)
        yield
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def pressed() -> str:
    """The key pressed since the last call; "" for none."""
    import select

    with contextlib.suppress(OSError, ValueError):
        if select.select([sys.stdin], [], [], 0.0)[0]:
            return os.read(sys.stdin.fileno(), 1).decode("ascii", "replace")
    return ""
