"""Torque of the driver's hands: the observers of the paper compared with tierod's own, and their consistency."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tierod.core.block import Block
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Table
from tierod.core.graph import scan
from tierod.methods.analysis.consistency import normalised_error_squared
from tierod.methods.estimators.stationary_bank import StationaryBank
from tierod.models.linear import LinearSystem
from tierod.monitors.driver_torque.design import ColumnTuning, design, process_noises
from tierod.monitors.driver_torque.observer import ColumnObserver, DelayedHandTorque
from tierod.vehicles import load
from tierod_lab.papers.column.column_friction import ColumnFrictionObserver, FrictionTuning
from tierod_lab.papers.column.observer_sensitivity import elsewhere, with_wrong_parameters
from tierod_lab.papers.column.printed import COLUMNS, PrintedObserver
from tierod_lab.papers.column.reported import MODEL, SEEDS
from tierod_lab.papers.column.swept_bench import DELAY, GOAL, Errors, driven, errors, known_column, over_hands, samples
from tierod_lab.studies.effort import Effort

TEXT = (
    "The motor of the simulated bench sweeps the column by ±30° from 0.1 to 3 Hz, as in figure 10 of the paper, every "
    "octave in the same time. The hands first pull by a sine of 1.5 N·m, then twice by 2 N·m for 4 s: four edges in "
    "40 s, as steps or as ramps of 100 ms. Noise of 0.05° on the wheel's angle, 0.2° on the motor's, 0.02 N·m on the "
    "bar's torque; 1 kHz. Friction at the motor is 0.1 N·m by Dahl's law, of which the observers know nothing unless "
    "it is said. Tuned on two runs with a linear sweep, reported on five others.",
    "The paper gives neither noises nor figures. A step weighs heavily: within the 15 ms until it stands out from "
    "noise the error is 2 N·m, so that the error over a run depends on how many steps it has.",
)


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("Torque of the driver's hands", TEXT)
    yield from _compared(effort)
    yield from with_wrong_parameters(effort)
    yield from elsewhere(effort)
    yield from _consistency(effort)


OWN = "Raffone, section 5, with noises of our own"


def observers() -> dict[str, tuple[Block, int]]:
    """Every compared observer with its lag in samples."""
    known = known_column()
    found: dict[str, tuple[Block, int]] = {
        f"paper: {column}": (PrintedObserver.of_column(known, column), 0) for column in COLUMNS
    }
    found["tierod: default"] = (ColumnObserver.of_parameters(known), 0)
    found["tierod: 20 ms later"] = (DelayedHandTorque.of_parameters(known), DELAY)
    found["tierod: friction known by its law"] = (ColumnFrictionObserver.of_vehicle(load("column-bench")), 0)
    return found


def _compared(effort: Effort) -> Iterator[Item]:
    found = {name: over_hands(block, effort, delay) for name, (block, delay) in observers().items()}
    header = ("observer", "steps", "ramps", "no hands", "disturbance torque")
    rows = [(name, *_cells(each)) for name, each in found.items()]
    note = (
        "The last column is the error of the torque of friction at the motor, of 0.1 N·m; the others are errors of the "
        "torque of the hands. The observer that knows Dahl's law has one filter for all that hands may do."
    )
    yield Table("Root mean square errors (N·m)", header, tuple(rows), note)
    yield from _paper_claims(found)
    yield from _own_claims(found, effort)
    yield _chart(effort)


def _cells(each: dict[str, Errors]) -> tuple[str, ...]:
    torques = [f"{each[hands].hand_torque:.3f}" for hands in ("steps", "ramps", "free")]
    disturbance = each["ramps"].disturbance_torque
    return (*torques, "" if np.isnan(disturbance) else f"{disturbance:.4f}")


def _paper_claims(found: dict[str, dict[str, Errors]]) -> Iterator[Claim]:
    printed = {name: each["steps"].hand_torque for name, each in found.items() if name.startswith("paper")}
    full = printed["paper: full"]
    yield Claim(
        "torque.paper-full",
        "Error of the paper's observer on the full column, hands that jump.",
        OWN,
        None,
        full,
        between(0.11, 0.13),
        "N*m",
        "A scaled Kalman filter of all eight states works: the reduction is not needed for observability.",
    )
    yield Claim(
        "torque.paper-reduced",
        "Both reductions, with any spring and with or without feed-through, are as good as the full column.",
        OWN,
        None,
        max(abs(value / full - 1.0) for value in printed.values()),
        at_most(0.05),
        "",
        "Largest relative difference between the errors of the six observers and that of the full one.",
    )


def _own_claims(found: dict[str, dict[str, Errors]], effort: Effort) -> Iterator[Claim]:
    default, later = found["tierod: default"], found["tierod: 20 ms later"]
    cases = (
        ("default-steps", "hands that jump", default["steps"].hand_torque, 0.07),
        ("default-ramps", "hands that pull within 100 ms", default["ramps"].hand_torque, 0.04),
        ("later-steps", "20 ms later, hands that jump", later["steps"].hand_torque, 0.04),
        ("later-ramps", "20 ms later, hands that pull within 100 ms", later["ramps"].hand_torque, 0.015),
    )
    for name, what, value, goal in cases:
        yield Claim(
            f"torque.{name}", f"Error of the default observer, {what}.", GOAL, None, value, at_most(goal), "N*m"
        )
    yield Claim(
        "torque.disturbance",
        "Error of the disturbance torque, friction unknown.",
        GOAL,
        None,
        default["ramps"].disturbance_torque,
        at_most(0.018),
        "N*m",
    )
    known = known_column()
    for name, what, level, angle, limit in (
        ("friction", "by its law, level known", 0.1, 0.05, at_most(0.004)),
        ("friction-level", "by its law, level half of the true one at the start", 0.05, 0.05, at_most(0.004)),
        ("friction-angle", "by its law with twice the true angle, level half", 0.05, 0.1, None),
    ):
        block = ColumnFrictionObserver.of_parameters(known, angle, friction=FrictionTuning(level=level))
        value = errors(block, driven("ramps", effort)).disturbance_torque
        claim = f"Error of the disturbance torque, friction {what}."
        yield Claim(f"torque.{name}", claim, GOAL, None, value, limit, "N*m")


_SHOWN = ("paper: series spring", "paper: balanced", "tierod: default", "tierod: 20 ms later")
"""Observers in the chart."""


def _chart(effort: Effort) -> Chart:
    run = driven("steps", effort)[0]
    time = run["time"]
    window = (time > 21.0) & (time < 29.0)
    thin = np.flatnonzero(window)[::5]
    marks = []
    for name in _SHOWN:
        block, delay = observers()[name]
        torque = scan(block, samples(run))["hand_torque"]
        marks.append(Lines(name, time[thin] - 1e-3 * delay, torque[thin]))
    marks.append(Lines("true", time[thin], run["hand_torque"][thin], dashed=True))
    angle = np.degrees(run["steering_wheel_angle"][thin])
    return Chart(
        "column-hand-torque",
        "A pull of 2 N·m during the sweep",
        "The estimate with a lag is drawn where it belongs, 20 ms before it is known.",
        "Angle of the steering wheel swinging by 30 degrees; below, the torque of the hands rising to 2 N·m and back, "
        "with noise of 0.1 N·m for the paper's observers and next to none for tierod's.",
        (
            Panel("Steering wheel", "time (s)", "angle (°)", (Lines("steering wheel", time[thin], angle),)),
            Panel("Torque of the hands", "time (s)", "torque (N·m)", tuple(marks)),
        ),
    )


SAMPLE_TIME = 1e-3
"""Sampling interval [s]."""
CONSISTENCY_TEXT = (
    "Drawn from the observer's own model: its noises, and changes between them as often as it expects. The means of "
    "the normalised innovation and error squared are 1 where a filter is as sure as it should be. Gains that are "
    "settled at every instant are those of a filter that knows since when a jump lasts; here that costs some percent.",
)


def _consistency(effort: Effort) -> Iterator[Item]:
    rows, bank_nis = [], float("nan")
    for name, tuning in (
        ("one filter, smooth hands", ColumnTuning(hand_torque_walk=0.0, reversal_walk=0.0)),
        ("bank: jumps and reversals", ColumnTuning()),
    ):
        nis, hand, disturbance = _figures(tuning, 10_000 if effort.quick else 200_000)
        rows.append((name, f"{nis:.3f}", f"{hand:.2f}", f"{disturbance:.2f}"))
        bank_nis = nis
    yield Heading("Consistency on its own model", CONSISTENCY_TEXT)
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
    made = design(known_column(), SAMPLE_TIME, tuning)
    system = made.observation.discrete
    noises = process_noises(system.states, known_column(), SAMPLE_TIME, tuning)
    truth, measured = _drawn(system, made.bank, noises, tuning, count)
    given = np.column_stack([np.zeros(count), measured])
    found = scan(made.bank, given)
    nees = []
    for name in ("hand_torque", "disturbance_torque"):
        away = found[f"mean.{name}"] - truth[:, system.states.index(name)]
        nees.append(float(np.mean(normalised_error_squared(away[:, None], found[f"variance.{name}"][:, None]))))
    return float(np.mean(found["nis"])) / len(system.C), nees[0], nees[1]


def _drawn(
    system: LinearSystem, bank: StationaryBank, noises: tuple[np.ndarray, ...], tuning: ColumnTuning, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """States and measurements drawn from the model, whose modes switch with the transition matrix of the bank."""
    random = np.random.default_rng(SEEDS.of(MODEL, 1)[0])
    chances = np.cumsum(np.array(bank.switching), axis=1)
    draws, modes, mode = random.uniform(size=count), np.zeros(count, int), 0
    for k in range(count):
        # Rounding can leave the last cumulative probability just below one.
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
