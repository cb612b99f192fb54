"""Numbers, units, times and names for display; conversions from SI units and radians happen here."""

from __future__ import annotations

import datetime
import math
import re

from tierod.core.findings import Estimate, Finding
from tierod.core.shown import shown

_CAPITALS = {"nis", "nees", "eps", "can", "rms", "dbc", "csv", "mf4"}

# Suffixes of a figure's name that give its unit, longer ones first
_ENDINGS = {
    "nms_per_rad": "N*m*s/rad",
    "nm_per_rad": "N*m/rad",
    "kgm2": "kg*m**2",
    "rad_per_s": "rad/s",
    "rad": "rad",
    "nm": "N*m",
    "hz": "Hz",
    "deg": "°",
    "n": "N",
    "m": "m",
}

INTERVAL = 1.96  # Half width of the 95 % interval of a normal distribution [standard deviations]


def bracketed(title: str, label: str) -> str:
    """Axis title with its unit, if it has one."""
    return f"{title} [{label}]" if label else title


def words(name: str) -> str:
    """A name as words, beginning with a capital letter; a decimal point is kept."""
    text = " ".join(
        part.upper() if part in _CAPITALS else part
        for part in re.sub(r"\.(?=[A-Za-z_])", ": ", name).replace("_", " ").split()
    )
    return text[:1].upper() + text[1:]


def number(value: float | None, digits: int = 4) -> str:
    """A number with the given significant digits, without trailing zeros; a dash for a missing one."""
    if value is None or not math.isfinite(value):
        return "–"
    if value != 0.0 and not 1e-4 <= abs(value) < 1e7:
        return f"{value:.{digits - 1}e}".replace("-", "−")
    decimals = digits - 1 - math.floor(math.log10(abs(value))) if value else 0
    # The option z prevents a negative zero.
    text = f"{round(value, decimals):z.{max(decimals, 0)}f}"
    return (text.rstrip("0").rstrip(".") if "." in text else text).replace("-", "−")


def share(value: float) -> str:
    if not math.isfinite(value):
        return "–"
    percent = 100.0 * value
    return f"{percent:.0f} %" if percent >= 10.0 or percent == 0.0 else f"{percent:.2g} %"


def duration(seconds: float | None) -> str:
    if seconds is None or not math.isfinite(seconds):
        return "–"
    if seconds < 60.0:
        return f"{number(seconds, 3)} s"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [f"{hours} h"] * bool(hours) + [f"{minutes} min"] * bool(minutes) + [f"{rest} s"] * bool(rest)
    return " ".join(parts)


def instant(seconds: float | None) -> str:
    """An instant of a recording [s], to a hundredth of a second, in hours, minutes and seconds."""
    if seconds is None or not math.isfinite(seconds):
        return "–"
    hundredths = round(100.0 * seconds)
    if abs(hundredths) < 6000:
        return f"{number(hundredths / 100.0, 6)} s"
    minutes, rest = divmod(hundredths, 6000)
    hours, minutes = divmod(minutes, 60)
    parts = [f"{hours} h"] * bool(hours) + [f"{minutes} min"] * bool(minutes)
    return " ".join([*parts, f"{number(rest / 100.0, 6)} s"])


def date(seconds: float) -> str:
    """Date and time in UTC of a time in seconds since 1970 [s]."""
    moment = datetime.datetime.fromtimestamp(seconds, datetime.UTC)
    return f"{moment:%Y-%m-%d %H:%M:%S} UTC"


def time_scale(span: float) -> tuple[float, str]:
    """(factor, label) of the unit of a time axis with a length of `span` seconds."""
    if span > 3.0 * 3600.0:
        return 1.0 / 3600.0, "h"
    return (1.0 / 60.0, "min") if span > 600.0 else (1.0, "s")


def interval(estimate: Estimate) -> tuple[str, str, str, str]:
    """(value, lower end, upper end, unit) of an estimate with its 95 % interval, rounded according to its uncertainty.

    The interval of a root mean square ends at zero.
    """
    factor, label = shown(estimate.unit)
    value, spread = estimate.value * factor, estimate.standard_deviation * factor
    half = INTERVAL * spread
    if not math.isfinite(value):
        return "–", "–", "–", label
    lowest = max(value - half, 0.0) if estimate.quantity.endswith(", rms") else value - half
    decimals = 2 if not (math.isfinite(half) and half > 0.0) else min(max(1 - math.floor(math.log10(half)), 0), 4)
    ends = [
        f"{end:z.{decimals}f}".replace("-", "−") if math.isfinite(end) else "–" for end in (value, lowest, value + half)
    ]
    return ends[0], ends[1], ends[2], label


def evidence(name: str, value: object) -> tuple[str, str]:
    """(label, text) of a figure of evidence whose name contains its unit."""
    if not isinstance(value, int | float):
        return words(name), str(value)
    value = float(value)
    for ending, unit in _ENDINGS.items():
        if name.lower().endswith(f"_{ending}"):
            factor, label = shown(unit)
            return words(name[: -len(ending) - 1]), f"{number(value * factor)} {label}"
    stem, _, ending = name.rpartition("_")
    if ending == "seconds" or (stem and ending == "s"):
        text = instant if stem.endswith(("from", "at")) else duration
        return words(stem or "duration"), text(value)
    return words(name), share(value) if ending == "share" else number(value)


def alarm_from(levels: tuple[float, ...], below: bool) -> str:
    """Thresholds of a rule as text: "alarm from 4", "alarm beyond ±0.06", "alarm below 9"; "" without thresholds."""
    if not levels:
        return ""
    if below:
        return f"alarm below {number(levels[0], 3)}"
    if len(levels) == 2 and levels[0] == -levels[1]:
        return f"alarm beyond ±{number(abs(levels[0]), 3)}"
    return f"alarm from {', '.join(number(level, 3) for level in levels)}"


def without_advice(reason: str) -> str:
    """The reason of a refusal without its advice and without the name of the monitor, which is shown beside it."""
    bare = re.sub(r"^the monitor '[^']*' (?:cannot run as '[^']*': )?", "", reason)
    return re.split(r"; did you mean|; known: |; none of the|\. (?=[A-Z])", bare)[0].rstrip(".")


def dated(finding: Finding) -> str:
    """Times at which the change of a finding began, ended and, where noticeably later, was declared; "" without one."""
    if finding.since is None:
        return ""
    begin = f"at {instant(finding.since)}" if finding.since > 0.0 else "at the start"
    later = (("ended", finding.end), ("declared", finding.belated))
    return ", ".join((begin, *(f"{what} at {instant(time)}" for what, time in later if time is not None)))
