"""How well the closed loop follows: sines and the sweep, with every observer, and how far it is from instability."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from tierod.control.margins import Margins, margins
from tierod.control.open_loop import open_loop
from tierod.models.column_observation import linear_column
from tierod.models.linear import LinearSystem, sampled
from tierod.models.steering_column import SteeringColumn
from tierod.monitors.driver_torque.observer import ColumnObserver
from tierod.monitors.driver_torque.printed import PrintedObserver
from tierod.studies.claims import Claim, at_least, at_most
from tierod.studies.column.closed_loop import SAMPLE_TIME, Belief, ClosedLoop
from tierod.studies.column.followed import Followed, sine, sweep
from tierod.studies.content import Item, Table
from tierod.studies.registry import Effort

FREQUENCIES = (0.1, 1.0, 2.0, 3.0)
"""Of the sines [Hz]."""

DEFAULT = "tierod's default"
SOURCE = "tierod's goal; Raffone, section 6 and figure 10, gives no figure"


def observers(known: Belief) -> Mapping[str, Any]:
    """The observers that are compared, by name; the paper's two are the series spring and the balanced one."""
    column = known.column
    return {
        DEFAULT: ColumnObserver.of_parameters(column, SAMPLE_TIME),
        "full column": PrintedObserver.of_column(column, "full", SAMPLE_TIME),
        "mechanical reduction": PrintedObserver.of_column(column, "series spring", SAMPLE_TIME),
        "balanced reduction": PrintedObserver.of_column(column, "balanced", SAMPLE_TIME),
    }


def items(loops: Mapping[str, ClosedLoop], known: Belief, effort: Effort) -> Iterator[Item]:
    """Tables of sines, of observers, of margins, and their claims."""
    yield from _sines(loops[DEFAULT], known, effort)
    swept = {name: sweep(loop, 4, effort.quick)[1] for name, loop in loops.items()}
    late = {name: sine(loop, 3.0, 4, effort.quick) for name, loop in loops.items()}
    far = {name: margins_of(loop, known) for name, loop in loops.items()}
    yield _table(swept, late, far)
    yield from _claims(swept, far)


def margins_of(loop: ClosedLoop, known: Belief) -> Margins:
    """Of a closed loop, its column with gear and without friction, cut at the motor's torque."""
    whole = sampled(linear_column(SteeringColumn, known.column), SAMPLE_TIME)
    plant = LinearSystem(
        whole.A, whole.B[:, :1], whole.C, whole.D[:, :1], whole.states, whole.inputs[:1], whole.outputs
    )
    return margins(open_loop(plant, loop.observer, loop.controller.position, loop.read), SAMPLE_TIME)


def _sines(loop: ClosedLoop, known: Belief, effort: Effort) -> Iterator[Item]:
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
            at_most(0.25),
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


def changed(loop: ClosedLoop, **fields: Any) -> ClosedLoop:
    """The loop with other fields of its position control."""
    controller = loop.controller
    return replace(loop, controller=replace(controller, position=replace(controller.position, **fields)))


def _table(swept: Mapping[str, Followed], late: Mapping[str, Followed], far: Mapping[str, Margins]) -> Table:
    rows = []
    for name, row in swept.items():
        m = far[name]
        rows.append(
            (
                name,
                f"{row.rms:.3f}",
                f"{row.largest:.2f}",
                f"{late[name].phase:+.2f}",
                f"{20.0 * math.log10(m.gain_up):.1f}",
                f"{math.degrees(m.phase):.0f}",
                f"{1e3 * m.delay:.1f}",
                f"{m.distance:.2f}",
            )
        )
    return Table(
        "The sweep of 30° from 0.1 to 3 Hz with each observer, and the margins of the loop",
        (
            "observer",
            "rms in °",
            "largest in °",
            "phase at 3 Hz in °",
            "gain margin in dB",
            "phase margin in °",
            "delay margin in ms",
            "distance from −1",
        ),
        tuple(rows),
        "Margins of the loop cut at the motor's torque, the column with its gear, without friction, the delay of one "
        "sample included. The torque may fall to nothing without harm.",
    )


def _claims(swept: Mapping[str, Followed], far: Mapping[str, Margins]) -> Iterator[Item]:
    yield Claim(
        "position.sweep",
        "The output shaft follows the sweep of figure 10, 30° from 0.1 to 3 Hz.",
        SOURCE,
        None,
        swept[DEFAULT].rms,
        at_most(0.25),
        "deg",
        f"Largest error {swept[DEFAULT].largest:.2f}°.",
    )
    worst = max(swept.values(), key=lambda row: row.rms)
    yield Claim(
        "position.observers",
        "The observers are interchangeable for the control of position.",
        "Raffone, section 7",
        "interchangeable",
        worst.rms,
        at_most(0.25),
        "deg",
        "Largest rms error of the sweep with any of the four. In margin they differ, see the next claim.",
    )
    least = min(far, key=lambda name: far[name].distance)
    yield Claim(
        "position.distance",
        "The loop with the default observer keeps its distance from instability.",
        "tierod's goal",
        None,
        far[DEFAULT].distance,
        at_least(0.4),
        "",
        f"Distance of the Nyquist curve from −1. With the {least} it is {far[least].distance:.2f}: an observer that "
        "leaves out the gear takes its swing at 112 Hz for something else.",
    )
