"""Robustness of the closed loop: wrong parameters, other friction, and a motor whose torque saturates."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tierod.core.claims import Claim, at_most, exactly
from tierod.core.content import Item, Table
from tierod.experiments.effort import Effort
from tierod.papers.column.closed_loop import BEGIN, ClosedLoop, Followed, Run, error, followed, run, sine, sweep
from tierod.papers.column.control.position_control import TorqueLimits
from tierod.papers.column.control.reference import Step, Sweep
from tierod.papers.column.parameter_sets import scattered
from tierod.papers.column.reported import SCATTERED, SEEDS
from tierod.papers.column.tracking import CHOSEN, GOAL, SHARES, SOURCE, changed, deaf, loop_with


def items(loop: ClosedLoop, effort: Effort) -> Iterator[Item]:
    """Tables and claims on scattered parameters, friction and saturation."""
    yield from _scatter(effort)
    yield from _friction(loop, effort)
    yield from _saturation(loop)


def _scattered(case: tuple[float, int, bool]) -> tuple[Followed, Followed, int]:
    """Tracking of the sweep and of 3 Hz with a scattered column, and number of false detections of a driver."""
    share, seed, quick = case
    loop = replace(loop_with(CHOSEN), bench=scattered(share, SEEDS.of(SCATTERED, seed + 1)[seed]))
    still = deaf(loop)
    return sweep(still, seed, quick)[1], sine(still, 3.0, seed, quick), sweep(loop, seed, quick)[1].found


def _scatter(effort: Effort) -> Iterator[Item]:
    count = 4 if effort.quick else 100
    rows: list[tuple[str, ...]] = []
    for share in (0.0, *SHARES):
        cases = [(share, seed, effort.quick) for seed in range(1 if share == 0.0 else count)]
        swept, late, ends = map(list, zip(*effort.made(_scattered, cases), strict=True))
        ended = sum(ends)
        rows.append((f"{100.0 * share:g} %", *_spread(swept, late), f"{ended} of {len(cases)}"))
        if share > 0.0:
            yield _scatter_claim(share, swept, late, ended)
    yield Table(
        "Every parameter of the column wrong by itself, normally distributed",
        (
            "deviation",
            "sweep, rms in °, median",
            "95 of 100 below",
            "worst",
            f"above {GOAL:g}°",
            "phase at 3 Hz in °, 95 of 100 below",
            "ended by a false driver",
        ),
        tuple(rows),
        "Inertias, dampings, stiffnesses and friction of the bench; observer and controller keep those of its file. "
        "Error and phase with the rule for a driver's hands off.",
    )


def _spread(swept: list[Followed], late: list[Followed]) -> tuple[str, ...]:
    return (
        f"{np.median([row.rms for row in swept]):.3f}",
        f"{_most(row.rms for row in swept):.3f}",
        f"{max(row.rms for row in swept):.3f}",
        f"{sum(row.rms > GOAL for row in swept)} of {len(swept)}",
        f"{_most(abs(row.phase) for row in late):.2f}",
    )


def _most(values: Iterable[float]) -> float:
    """The 95th percentile."""
    return float(np.percentile(list(values), 95.0))


def _scatter_claim(share: float, swept: list[Followed], late: list[Followed], ended: int) -> Claim:
    percent = f"{100.0 * share:g}"
    return Claim(
        f"position.sweep-parameters-{percent}-percent",
        f"The sweep is followed with every parameter of the column wrong by {percent} %.",
        SOURCE,
        None,
        _most(row.rms for row in swept),
        at_most(GOAL),
        "deg",
        f"What 95 % of {len(swept)} columns stay below; {sum(row.rms > GOAL for row in swept)} are above the goal, the "
        f"worst has {max(row.rms for row in swept):.2f}°; phase at 3 Hz likewise "
        f"{_most(abs(row.phase) for row in late):.2f}°. A false driver ended {ended}: what the wheel's inertia feigns "
        "grows with the frequency.",
    )


def _friction(loop: ClosedLoop, effort: Effort) -> Iterator[Item]:
    kinds = {
        "fed forward as the file says": loop,
        "not fed forward": changed(loop, friction=0.0),
        "half of the observed disturbance instead": changed(loop, friction=0.0, disturbance_compensation=0.5),
    }
    levels = (0.0, 0.1, 0.2)
    rows = []
    for name, each in kinds.items():
        cells = []
        for level in levels:
            bench = replace(each.bench, friction=replace(each.bench.friction, level=level))
            done = replace(each, bench=bench)
            cells.append(f"{sweep(done, 6, effort.quick)[1].rms:.3f}")
        rows.append((name, *cells))
    yield Table(
        "Dry friction at the motor, rms error of the sweep in °",
        ("friction", *(f"{level:g} N·m" for level in levels)),
        tuple(rows),
        "The file says 0.1 N·m, which is 1.8 N·m at the steering wheel. What is fed forward costs no margin; the "
        "observed disturbance is a second integral action and does.",
    )


def _saturation(loop: ClosedLoop) -> Iterator[Item]:
    loop = deaf(loop)
    weak = changed(loop, limits=TorqueLimits(torque=0.6))
    falling = Sweep(start=3.0, stop=1.0, duration=4.0)
    strong, limited = (run(each, falling, BEGIN + 9.0, 8) for each in (loop, weak))
    calm = BEGIN + 6.0
    before, after = followed(strong, calm), followed(limited, calm)
    during = followed(limited, BEGIN + 0.5, BEGIN + 2.5)
    rows = [
        ("sine falling from 3 to 1 Hz, 3 N·m", f"{followed(strong, BEGIN + 0.5, BEGIN + 2.5).largest:.2f}", "", ""),
        ("the same with 0.6 N·m, of 1.4 N·m needed", f"{during.largest:.1f}", "", f"{after.rms:.3f}"),
    ]
    steps = []
    for rise, torque in ((0.3, 3.0), (0.3, 0.6), (0.0, 0.6), (0.0, 3.0)):
        each = changed(loop, limits=TorqueLimits(torque=torque))
        done = run(each, Step(math.radians(90.0), 0.5, rise), BEGIN + 5.0, 9)
        over, settled = _step(done)
        steps.append((over, settled))
        what = f"step of 90° within {rise:g} s" if rise > 0.0 else "jump of 90°"
        rows.append(
            (f"{what}, {torque:g} N·m", f"{over:.1f}", f"{settled:.2f}", f"{followed(done, BEGIN + 4.0).rms:.3f}")
        )
    yield Table(
        "Motor too weak for what is asked",
        ("run", "largest error, or overshoot, in °", "within 1° for good after, in s", "rms in ° at the end"),
        tuple(rows),
        "A jump is no reference that a column can follow; the weak motor overshoots less, since it turns more slowly. "
        "The rule for a driver's hands is off here.",
    )
    yield Claim(
        "position.windup",
        "After the motor has been too weak for the sweep, control is back as if nothing had been.",
        "tierod",
        None,
        after.rms / before.rms,
        at_most(1.1),
        "",
        f"Error at 1 Hz, 2 s after 3 Hz with 0.6 N·m, over that with 3 N·m. Meanwhile it was {during.largest:.0f}°.",
    )
    yield Claim(
        "position.large-steps",
        "Steps of 90° end within 1° for good, also where the motor saturates.",
        "tierod",
        None,
        float(sum(settled > 2.0 for _, settled in steps)),
        exactly(0.0),
        "",
        f"Steps that took more than 2 s, of {len(steps)}; the slowest took {max(s for _, s in steps):.2f} s.",
    )


def _step(done: Run) -> tuple[float, float]:
    """Overshoot [deg], and settling time until the error stays below one degree [s]."""
    wrong = error(done)
    start = BEGIN + 0.5
    moving = done.time > start
    late = np.nonzero((np.abs(wrong) > 1.0) & moving)[0]
    settled = float(done.time[late[-1]] - start) if len(late) else 0.0
    whole = math.degrees(float(np.max(done.signals["plant.truth_gear_angle"]))) - 90.0
    return whole, settled
