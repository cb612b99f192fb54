"""Whether the default observer's errors are as large as it says, on the very model it believes in."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.claims import Claim, between
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.experiments.effort import Effort
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.linear import LinearSystem
from tierod.monitors.driver_torque.design import design, process_noises
from tierod.monitors.driver_torque.tuning import ColumnTuning
from tierod.papers.column.observers_compared import GOAL, believed

SAMPLE_TIME = 1e-3
TEXT = (
    "Drawn from the observer's own model: its noises, and changes between them as often as it expects. The means of "
    "the normalised innovation and error squared are 1 where a filter is as sure as it should be. Gains that are "
    "settled at every instant are those of a filter that knows since when a jump lasts; here that costs some percent.",
)


def items(effort: Effort) -> Iterator[Item]:
    """NIS and NEES of one filter, and of the bank."""
    rows, bank_nis = [], float("nan")
    for name, tuning in (
        ("one filter, smooth hands", ColumnTuning(hand_torque_walk=0.0, reversal_walk=0.0)),
        ("bank: jumps and reversals", ColumnTuning()),
    ):
        nis, hand, disturbance = _figures(tuning, 10_000 if effort.quick else 200_000)
        rows.append((name, f"{nis:.3f}", f"{hand:.2f}", f"{disturbance:.2f}"))
        bank_nis = nis
    yield Heading("Consistency on its own model", TEXT)
    header = ("observer", "NIS per output", "NEES of the hands' torque", "NEES of the disturbance torque")
    yield Table("Normalised innovation and error squared, mean", header, tuple(rows))
    yield Claim(
        "torque.consistent",
        "Innovations of the default observer on its own model are as large as it says.",
        GOAL,
        None,
        bank_nis,
        between(0.9, 1.1),
        "",
        "Mean normalised innovation squared per output.",
    )


def _figures(tuning: ColumnTuning, count: int) -> tuple[float, float, float]:
    made = design(believed(), SAMPLE_TIME, tuning)
    system = made.observation.discrete
    noises = process_noises(system.states, believed(), SAMPLE_TIME, tuning)
    truth, measured = _drawn(system, made.bank, noises, tuning, count)
    given = np.column_stack([np.zeros(count), measured])
    found = scan(made.bank, given)
    errors = []
    for name in ("hand_torque", "disturbance_torque"):
        away = found[f"mean.{name}"] - truth[:, system.states.index(name)]
        errors.append(float(np.mean(away**2 / found[f"variance.{name}"])))
    return float(np.mean(found["nis"])) / len(system.C), errors[0], errors[1]


def _drawn(
    system: LinearSystem, bank: StationaryBank, noises: tuple[np.ndarray, ...], tuning: ColumnTuning, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """States and measurements of the model, in modes that change by the bank's switching."""
    random = np.random.default_rng(5)
    chances = np.cumsum(np.array(bank.switching), axis=1)
    draws, modes, mode = random.uniform(size=count), np.zeros(count, int), 0
    for k in range(count):
        mode = min(int(np.searchsorted(chances[mode], draws[k])), len(chances) - 1)
        modes[k] = mode
    shaken = random.normal(size=(count, len(system.A))) * np.sqrt(np.array(noises))[modes]
    states = np.zeros((count, len(system.A)))
    now = np.zeros(len(system.A))
    for k in range(count):
        now = system.A @ now + shaken[k]
        states[k] = now
    noise = random.normal(size=(count, len(system.C))) * np.sqrt(tuning.variances())
    return states, states @ system.C.T + noise
