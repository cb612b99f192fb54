"""Table 1 of the paper: operations of a step counted from the traced graphs, and processor time of a step."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Heading, Item, Table
from tierod.core.graph.analysis import OperationCount, operation_count
from tierod.core.graph.kernel import kernel
from tierod.core.graph.trace import initial_memory
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod_lab.papers.motor_angle.bare_observers import BareFeedforward, BareLuenberger, BareReduced
from tierod_lab.papers.motor_angle.feedforward import FeedforwardAngle, FeedforwardWithLoad
from tierod_lab.papers.motor_angle.flux_observer import FluxObserver
from tierod_lab.papers.motor_angle.observer_drives import SAMPLE_TIME, parameters, to_and_fro
from tierod_lab.papers.motor_angle.printed_observers import extended_kalman, luenberger, reduced_luenberger
from tierod_lab.papers.motor_angle.reported import SEEDS, STEP_COST
from tierod_lab.studies.effort import Effort


class PrintedCount(NamedTuple):
    """A row of Table 1: numbers of multiplications, of integrators, and of trigonometric functions with logic."""

    multiplications: int
    integrators: int
    trigonometric: int


PRINTED = {
    "Luenberger": PrintedCount(19, 3, 4),
    "reduced Luenberger": PrintedCount(24, 2, 4),
    "Kalman filter": PrintedCount(115, 13, 4),
    "feedforward": PrintedCount(7, 2, 6),
}
"""Rows of Reinelt et al., Table 1."""

REPEATS = 7
"""Repetitions of a timed run, of which the fastest counts."""

PIECE = 1000
"""Samples timed at once: within a tenth of a millisecond other programs seldom interrupt."""


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "What a step costs (Table 1)",
        (
            "Operations of one step, from the stator's axes to the angle, counted from the traced graph. What depends "
            "on tuning alone is worked out once before; equal operations count once. Decisions stand for what the "
            "paper leaves out: missing samples, the beginning at the sensor's angle, a difference within half a turn.",
        ),
    )
    samples = to_and_fro(SEEDS.of(STEP_COST, 1)[0], 0.5 if effort.quick else 2.0).samples
    rows, counts = [], {}
    for name, observer in observers().items():
        counts[name] = operation_count(observer)
        rows.append(_row(name, counts[name], nanoseconds(observer, samples)))
    yield Table(
        "Operations of a step: printed / counted",
        ("observer", "multiplications", "additions", "divisions, roots", "trigonometric", "decisions", "states", "ns"),
        tuple(rows),
        "Printed are multiplications, integrators (here under states), trigonometric functions with logic. The time is "
        "that of the fastest thousand samples on one core of whatever machine made this page.",
    )
    yield _bare(counts)
    yield from _claims(counts)


REASONS = {
    "Luenberger": "The observer is sampled exactly, so that T is part of its matrices; the direct axis is not needed.",
    "reduced Luenberger": "Printed are the coefficients of (32) worked out in every step; here they depend on tuning "
    "alone and are worked out once before.",
    "feedforward": "Beyond (46): the lag of the filter is taken back, half turns are distinguished, the back-EMF is "
    "carried on while samples are missing, and a standing motor is noticed.",
}
"""Reasons for the differences between the counts of the observers and those of their bare equations."""


def bare_observers() -> dict[str, Block]:
    """Bare equations of the paper by name of the observer that implements them."""
    return {"Luenberger": BareLuenberger(), "reduced Luenberger": BareReduced(), "feedforward": BareFeedforward()}


def _products(count: OperationCount) -> int:
    return count.multiplications + count.divisions


def _bare(counts: dict[str, OperationCount]) -> Table:
    bare = {name: operation_count(block) for name, block in bare_observers().items()}
    rows = tuple(
        (
            name,
            str(PRINTED[name].multiplications),
            str(_products(count)),
            str(_products(counts[name])),
            f"{PRINTED[name].integrators} / {count.states}",
            REASONS[name],
        )
        for name, count in bare.items()
    )
    return Table(
        "Multiplications and divisions of the bare equations, and of the observers",
        (
            "observer",
            "printed",
            "bare equations",
            "observer",
            "integrators, printed / bare",
            "why the observer differs",
        ),
        rows,
        "Bare: both Park transforms in full, Euler's method, no beginning and no missing samples.",
    )


def observers() -> dict[str, Block]:
    """Observers by name: as printed, then with load, then the others."""
    dq, fixed = parameters()
    makers: dict[str, Callable[..., Block]] = {
        "Luenberger": luenberger,
        "reduced Luenberger": reduced_luenberger,
        "Kalman filter": extended_kalman,
    }
    found: dict[str, Block] = {
        name: make(dq, SAMPLE_TIME, load=False, axes="measured") for name, make in makers.items()
    }
    found["feedforward"] = FeedforwardAngle(fixed)
    found |= {f"{name}, with load": make(dq, SAMPLE_TIME) for name, make in makers.items()}
    found["feedforward, with load"] = FeedforwardWithLoad.of(fixed)
    return found | {"flux observer": FluxObserver(fixed), "default": MotorAngleObserver(fixed)}


def nanoseconds(observer: Block, samples: np.ndarray) -> float:
    """Time of a step of the compiled block, from the fastest of many pieces [ns]."""
    runner = kernel(observer)
    outputs = np.empty((PIECE, len(runner.graph.output)))
    best = np.inf
    for _ in range(REPEATS):
        memory = initial_memory(observer)
        for first in range(0, len(samples) - PIECE + 1, PIECE):
            piece = samples[first : first + PIECE]
            start = time.perf_counter()
            runner.scan(memory, piece, outputs, 0)
            best = min(best, time.perf_counter() - start)
    return float(best) / PIECE * 1e9


def _row(name: str, count: OperationCount, took: float) -> tuple[str, ...]:
    printed = PRINTED.get(name)
    many, states, trigonometric = (f"{value} / " for value in printed) if printed else ("", "", "")
    return (
        name,
        f"{many}{count.multiplications}",
        f"{count.additions}",
        f"{count.divisions + count.functions}",
        f"{trigonometric}{count.trigonometric}",
        f"{count.decisions}",
        f"{states}{count.states}",
        f"{took:.0f}",
    )


def _claims(counts: dict[str, OperationCount]) -> Iterator[Claim]:
    for name, key, note in (
        ("Luenberger", "luenberger", "Park's transforms included."),
        (
            "Kalman filter",
            "kalman",
            "Park's transforms included; the covariance has six numbers here, nine in the paper.",
        ),
    ):
        printed, counted = PRINTED[name].multiplications, counts[name].multiplications
        yield Claim(
            f"motor-angle.table-one.{key}",
            f"Multiplications of a step of the {name} as printed",
            "Reinelt et al., Table 1",
            printed,
            counted,
            between(round(0.75 * printed), round(1.25 * printed)),
            "",
            note,
        )
    for name, key in (("Luenberger", "luenberger"), ("reduced Luenberger", "reduced"), ("feedforward", "feedforward")):
        printed = PRINTED[name].multiplications
        yield Claim(
            f"motor-angle.table-one.bare-{key}",
            f"Multiplications and divisions of the bare equations of the {name}",
            "Reinelt et al., Table 1",
            printed,
            _products(operation_count(bare_observers()[name])),
            between(printed - 1.0, printed + 1.0),
        )
    for name, key in (("reduced Luenberger", "reduced"), ("feedforward", "feedforward")):
        printed = PRINTED[name].multiplications
        yield Claim(
            f"motor-angle.table-one.{key}",
            f"Multiplications of a step of the {name} observer, no more than printed",
            "Reinelt et al., Table 1",
            printed,
            counts[name].multiplications,
            at_most(printed),
            "",
            REASONS[name],
            cause=f"The bare equations take {_products(operation_count(bare_observers()[name])):g}. {REASONS[name]} "
            "Leaving that out would mend the count, and lose the angle at low speed.",
        )
    yield Claim(
        "motor-angle.table-one.order",
        "The Kalman filter is the dearest of the four, the other three are alike",
        "Reinelt et al., below Table 1",
        None,
        counts["Kalman filter"].multiplications
        / max(counts[name].multiplications for name in ("Luenberger", "reduced Luenberger", "feedforward")),
        between(2.0, 20.0),
        "",
        "Multiplications over those of the dearest of the others.",
    )
