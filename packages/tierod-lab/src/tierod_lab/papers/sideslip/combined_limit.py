"""Low road friction: announcement of the peak of the front axle's force before it is reached."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np

from tierod.core.claims import Claim, at_least, at_most
from tierod.core.content import Band, Chart, Heading, Item, Lines, Panel, Table
from tierod.core.graph import Result
from tierod_lab.papers.sideslip.combined_drives import (
    WITH,
    WITHOUT_TORQUE,
    Driven,
    driven,
    estimated,
    on,
    rms,
    slippery_ramp,
)
from tierod_lab.papers.sideslip.combined_table import GOAL
from tierod_lab.papers.sideslip.reported import COMBINED, LIMIT, SEEDS
from tierod_lab.studies.effort import Effort

RAMPS: dict[str, tuple[float, float, float]] = {
    "0.35, 2 degrees/s": (0.35, 60.0, 2.0),
    "0.35, 5 degrees/s to the right": (0.35, -70.0, 5.0),
    "0.35, 15 degrees/s": (0.35, 75.0, 15.0),
    "0.2, 3 degrees/s": (0.2, 50.0, 3.0),
    "0.6, 5 degrees/s": (0.6, 100.0, 5.0),
    "1, 10 degrees/s": (1.0, 150.0, 10.0),
}
"""Ramp -> road friction over that of a dry road [-], final steering wheel angle [deg] and its rate [deg/s]."""

SHOWN = "0.35, 5 degrees/s to the right"
PEAK = 0.98
"""Share of the largest front force of a ramp from which the peak counts as reached: the curve is flat there [-]."""
FALSE = 0.6
"""Share of the front axle's grip in use below which an announcement counts as false [-]."""
QUIET = ("random steering", "mixed drive from standstill", "low friction, 0.35")
"""Drives that are searched for false announcements; on the last one alone the front axle comes near its peak."""
ICE = 0.6
"""Ratio of estimated to true road friction below which the estimate counts as false ice [-]."""
DRY = 8
"""Number of dry mixed drives that are searched for false ice; friction's random walk was tuned on twelve with seeds
below 200."""
GRIP = 7900.0
"""Largest front axle force over road friction [N], measured on the ramps: 2790 N at a friction of 0.35. On a dry road
load transfer reduces it to 7500, so the share in use comes out 5 % too small there."""
TURNING = 15.0
"""Time at which a ramp begins to steer [s]."""


@dataclass(frozen=True)
class Ramp:
    """One ramp with the estimate.

    Args:
        drive: drive over the ramp
        result: outputs of the estimator
        share: true front axle force over the largest of the ramp [-], (n,)
        peak: time at which the share first exceeds `PEAK` [s]
        announced: time of the announcement [s], infinite without one
    """

    drive: Driven
    result: Result
    share: np.ndarray
    peak: float
    announced: float

    @property
    def lead(self) -> float:
        """Time from the announcement to the peak [s]."""
        return self.peak - self.announced

    @property
    def share_then(self) -> float:
        """True share of the front force at the announcement; NaN without one."""
        return float(np.interp(self.announced, self.drive.time, self.share)) if np.isfinite(self.announced) else np.nan

    @property
    def error(self) -> float:
        """Root mean square error of the sideslip angle from the start of steering to the peak [deg]."""
        error = self.result["sideslip_angle"] - self.drive.truth("sideslip_angle")
        return float(np.degrees(rms(error[(self.drive.time > TURNING) & (self.drive.time <= self.peak)])))


def ramp(name: str, readings: str = WITH) -> Ramp:
    """Drives a ramp of `RAMPS` and runs the estimator with the measurements of `readings`."""
    drive = driven(slippery_ramp(*RAMPS[name]), SEEDS.of(LIMIT, 1)[0])
    return _judged(drive, estimated(drive, readings=readings))


def _judged(drive: Driven, result: Result) -> Ramp:
    force = np.abs(drive.truth("front_lateral_force"))
    share = force / force.max()
    ahead = (result["limit_ahead"] > 0.5) & (drive.time > TURNING)
    announced = float(drive.time[np.argmax(ahead)]) if ahead.any() else np.inf
    return Ramp(drive, result, share, float(drive.time[np.argmax(share > PEAK)]), announced)


def false_seconds(seeds: tuple[int, ...], readings: str) -> tuple[float, float]:
    """Time with a false announcement and total time over the drives of `QUIET` [s]."""
    wrong = total = 0.0
    for name in QUIET:
        for seed in seeds:
            drive = on(name, seed)
            step = float(drive.time[1] - drive.time[0])
            ahead = estimated(drive, readings=readings)["limit_ahead"] > 0.5
            used = np.abs(drive.truth("front_lateral_force")) / _grip(drive)
            wrong += step * float(np.sum(ahead & (used < FALSE)))
            total += step * len(ahead)
    return wrong, total


def false_ice(seeds: tuple[int, ...], readings: str) -> tuple[float, float, float]:
    """Smallest ratio of estimated to true friction [-], time with false ice [s] and total time [s] on dry drives."""
    least, below, total = np.inf, 0.0, 0.0
    for seed in seeds:
        drive = on("mixed drive from standstill", seed)
        step = float(drive.time[1] - drive.time[0])
        share = estimated(drive, readings=readings)["friction"] / drive.truth("road_friction")
        least = min(least, float(share.min()))
        below += step * float(np.sum(share < ICE))
        total += step * len(share)
    return least, below, total


def _grip(drive: Driven) -> np.ndarray:
    """Largest possible front axle force on the present road [N]; see `GRIP`."""
    friction: np.ndarray = np.maximum(drive.truth("road_friction"), 0.05)
    return GRIP * friction


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Low friction: the peak announced",
        (
            "As a tyre slips, its pneumatic trail vanishes before its force has its peak, so the steering "
            "torque indicates the friction of the road early. The estimator announces the peak where the front axle "
            "uses more than 70 % of the greatest force that it expects, with a standard deviation to spare.",
        ),
    )
    names = (SHOWN,) if effort.quick else tuple(RAMPS)
    found = {
        readings: dict(zip(names, effort.made(partial(ramp, readings=readings), names), strict=True))
        for readings in (WITH, WITHOUT_TORQUE)
    }
    yield _table(found)
    yield from _claims(found, tuple(SEEDS.of(COMBINED, 1 if effort.quick else 3)))
    yield _chart(found[WITH][SHOWN])


def _table(found: dict[str, dict[str, Ramp]]) -> Table:
    rows = []
    for name in found[WITH]:
        cells = [name]
        for each in (found[WITH][name], found[WITHOUT_TORQUE][name]):
            lead = f"{each.lead:.2f}" if np.isfinite(each.lead) else "never"
            cells += [lead, f"{each.share_then:.2f}", f"{each.error:.3f}"]
        rows.append(tuple(cells))
    header = ("lead (s)", "share of the peak then", "error to the peak (deg)")
    return Table(
        "Ever more steering on a slippery road: how long before the peak of the front force it is announced",
        ("road friction, steering", *header, *(f"no torque: {each}" for each in header)),
        tuple(rows),
        f"At 22 m/s, onto the slippery road from a dry one; the peak is {PEAK:.0%} of the greatest force of the ramp.",
    )


def _claims(found: dict[str, dict[str, Ramp]], seeds: tuple[int, ...]) -> Iterator[Claim]:
    ramps = [each for name, each in found[WITH].items() if name.startswith("0.35")]
    yield Claim(
        "combined.peak-announced",
        "On a road of friction 0.35 the peak of the front force is announced before it is reached: shortest lead.",
        GOAL,
        None,
        _shortest(found[WITH]),
        at_least(0.0),
        "s",
        f"Without the steering's torque {_shortest(found[WITHOUT_TORQUE]):.2f}.",
    )
    yield Claim(
        "combined.low-friction-ramp",
        "Sideslip on the way to that peak: largest root mean square error.",
        GOAL,
        None,
        max(each.error for each in ramps),
        at_most(0.3),
        "deg",
    )
    wrong, total = false_seconds(seeds, WITH)
    without, _ = false_seconds(seeds, WITHOUT_TORQUE)
    yield Claim(
        "combined.false-announcements",
        "Announced with less than 60 % of the front axle's grip in use, over quiet drives.",
        GOAL,
        None,
        100.0 * wrong / total,
        at_most(1.0),
        "percent",
        f"Of {total:.0f} s on dry and slippery roads {wrong:.1f}; without the steering's torque {without:.1f}.",
    )
    yield _false_ice(seeds if len(seeds) == 1 else tuple(SEEDS.of(COMBINED, DRY)))


def _false_ice(seeds: tuple[int, ...]) -> Claim:
    least, below, total = false_ice(seeds, WITH)
    poorer, longer, _ = false_ice(seeds, WITHOUT_TORQUE)
    return Claim(
        "combined.false-ice",
        "Share of the time on dry mixed drives in which the estimated friction is below 60 % of the road's.",
        GOAL,
        None,
        100.0 * below / total,
        at_most(1.0),
        "percent",
        f"{below:.1f} s of {total:.0f}, least {least:.2f}; without the steering's torque {longer:.1f} s, {poorer:.2f}.",
        cause=f"{below:.1f} s of {total:.0f} in {len(seeds)} drives. Where tyres are hardly used, friction shows in no "
        "signal and wanders. A slower wander would lessen it, and announce the peak later.",
    )


def _shortest(ramps: dict[str, Ramp]) -> float:
    return min(each.lead for name, each in ramps.items() if name.startswith("0.35"))


def _chart(shown: Ramp) -> Chart:
    time, result = shown.drive.time, shown.result
    kept = (time > TURNING - 2.0) & (time < shown.peak + 2.0)
    used, deviation = result["front_friction_used"], result["front_friction_used_deviation"]
    marks = (("announced", shown.announced), ("peak", shown.peak))
    return Chart(
        "low-friction",
        "The peak announced",
        "Road friction 0.35. Upper field: share of the greatest front force in use, true and estimated with one "
        "standard deviation. Lower field: the sideslip angle.",
        f"The announcement comes {shown.lead:.1f} s before the peak, at {shown.share_then:.0%} of it.",
        (
            Panel(
                "Front axle",
                "time (s)",
                "share of the greatest force",
                (
                    Lines("true", time[kept], shown.share[kept]),
                    Lines("estimated", time[kept], used[kept]),
                    Band("estimated", time[kept], (used - deviation)[kept], (used + deviation)[kept]),
                ),
                uprights=marks,
            ),
            Panel(
                "Sideslip",
                "time (s)",
                "sideslip angle (deg)",
                (
                    Lines("true", time[kept], np.degrees(shown.drive.truth("sideslip_angle"))[kept]),
                    Lines("estimated", time[kept], np.degrees(result["sideslip_angle"])[kept]),
                ),
                uprights=marks,
            ),
        ),
    )
