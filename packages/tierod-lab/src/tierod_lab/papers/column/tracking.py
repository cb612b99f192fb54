"""Tracking of the closed loop: sines, and the sweep with every observer."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Unpack

from tierod.core.block import Block
from tierod.core.claims import Claim, at_most
from tierod.core.content import Item, Table
from tierod.models.steering_column import without_gear
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod_lab.papers.column.closed_loop import SAMPLE_TIME, Belief, ClosedLoop, Followed, belief, loop_of, sine, sweep
from tierod_lab.papers.column.control.position_control import Settings
from tierod_lab.papers.column.printed import PrintedObserver
from tierod_lab.studies.effort import Effort

FREQUENCIES = (0.1, 1.0, 2.0, 3.0)
"""Frequencies of the sines [Hz]."""

MECHANICAL, BALANCED = "printed, mechanical reduction", "printed, balanced reduction"
FULL = "printed, full column with gear"
PRINTED = (MECHANICAL, BALANCED)
"""The paper's two observers."""

CHOSEN = MECHANICAL
"""Observer of all other runs, and of the figure."""

GOAL = 0.25
"""Largest rms tracking error allowed [deg]."""

SOURCE = "tierod; Raffone, section 6 and figure 10, gives no figure"


def observers(known: Belief) -> Mapping[str, Block]:
    """The compared observers by name."""
    column = known.column
    return {
        MECHANICAL: PrintedObserver.of_column(column, "series spring", SAMPLE_TIME),
        BALANCED: PrintedObserver.of_column(column, "balanced", SAMPLE_TIME),
        FULL: PrintedObserver.of_column(column, "full", SAMPLE_TIME),
        "tierod's default, without gear": ColumnObserver.of_parameters(without_gear(column), SAMPLE_TIME),
        "tierod's default, with gear": ColumnObserver.of_parameters(column, SAMPLE_TIME),
    }


@cache
def loop_with(observer: str) -> ClosedLoop:
    """The closed loop with an observer by name, designed for the column of the vehicle file."""
    return loop_of(observers(belief())[observer], belief())


def items(loops: Mapping[str, ClosedLoop], effort: Effort) -> Iterator[Item]:
    yield from _sines(loops[CHOSEN], effort)
    swept = {name: sweep(loop, 4, effort.quick)[1] for name, loop in loops.items()}
    yield _table(swept)
    yield from _claims(swept)


def _sines(loop: ClosedLoop, effort: Effort) -> Iterator[Item]:
    variants = {
        "all of it": loop,
        "without friction fed forward": changed(loop, friction=0.0),
        "without any feed-forward": changed(loop, feed_forward=0.0),
    }
    found = {name: {f: sine(each, f, 3, effort.quick) for f in FREQUENCIES} for name, each in variants.items()}
    yield Table(
        "Sines of 30° at the output shaft: error and phase, true shaft against reference",
        ("control", *(f"{f:g} Hz, rms in °" for f in FREQUENCIES), *(f"{f:g} Hz, phase in °" for f in FREQUENCIES[1:])),
        tuple(
            (name, *(f"{row[f].rms:.3f}" for f in FREQUENCIES), *(f"{row[f].phase:+.2f}" for f in FREQUENCIES[1:]))
            for name, row in found.items()
        ),
        "Dry friction of 0.1 N·m at the motor (1.8 N·m at the steering wheel) in every run.",
    )
    for f in FREQUENCIES[1:]:
        plain = found["without any feed-forward"][f]
        yield Claim(
            f"position.rms-{f:g}-hz",
            f"The output shaft follows a sine of 30° at {f:g} Hz.",
            SOURCE,
            None,
            found["all of it"][f].rms,
            at_most(GOAL),
            "deg",
            f"Without feed-forward {plain.rms:.2f}°.",
        )
        yield Claim(
            f"position.phase-{f:g}-hz",
            f"It is hardly late or early at {f:g} Hz.",
            SOURCE,
            None,
            abs(found["all of it"][f].phase),
            at_most(1.0),
            "deg",
            f"Size of the phase; without feed-forward {plain.phase:+.1f}°.",
        )


def changed(loop: ClosedLoop, **fields: Unpack[Settings]) -> ClosedLoop:
    """The loop with changed settings of its position control."""
    return replace(loop, control=replace(loop.control, **fields))


def _table(swept: Mapping[str, Followed]) -> Table:
    return Table(
        "The sweep of 30° from 0.1 to 3 Hz with each observer",
        ("observer", "rms in °", "largest in °"),
        tuple((name, f"{row.rms:.3f}", f"{row.largest:.2f}") for name, row in swept.items()),
        "An observer that has the gear follows its oscillation at 112 Hz, which the control then excites: the model of "
        "the control does not contain it. That is a reason to reduce the model which the paper does not give.",
    )


def _claims(swept: Mapping[str, Followed]) -> Iterator[Item]:
    yield Claim(
        "position.sweep",
        "The output shaft follows the sweep of figure 10, 30° from 0.1 to 3 Hz.",
        SOURCE,
        None,
        swept[CHOSEN].rms,
        at_most(GOAL),
        "deg",
        f"Largest error {swept[CHOSEN].largest:.2f}°.",
    )
    yield Claim(
        "position.observers",
        "The two printed observers are interchangeable for the control of position.",
        "Raffone, section 7",
        "interchangeable",
        max(swept[name].rms for name in PRINTED),
        at_most(GOAL),
        "deg",
        "Larger rms error of the sweep of the two.",
    )
