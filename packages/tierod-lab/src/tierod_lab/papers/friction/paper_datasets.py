"""Drives on which the paper's claims are measured: its two sets, the angle's position, eq (19), and appendix A."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from tierod.core.recording import Aligned
from tierod.methods.identification.hysteresis import HysteresisIdentification, Support
from tierod_lab.campaign.figures import area_under_curve
from tierod_lab.ground import lock_to_lock
from tierod_lab.ground.chassis.tyres import TYRES
from tierod_lab.papers.friction import judging as named
from tierod_lab.papers.friction.cases import FAST, HEALTHY, RATIO_GROWTH, STATES, USUAL, VARIABLE_RATIO, Case, gear_of
from tierod_lab.papers.friction.judging import (
    BASELINES,
    BINS,
    FILTERS,
    RATE,
    READINGS,
    Course,
    aligned,
    best_accuracy,
    course,
    judged,
    overlap,
    reached,
    right_side,
    shares,
    windows,
    with_terms,
)
from tierod_lab.papers.friction.reported import DRIVES, SEEDS, TURNS, monitor, vehicle
from tierod_lab.studies.effort import Effort
from tierod_lab.studies.metrics import Row

WORST = "PWM 25%"

THRESHOLD = 7.5
"""Threshold half-way between the nominal friction, 4, and the least that a driver notices, 11 [N*m]; Table 1."""


class SetDrive(NamedTuple):
    """A drive of the paper's sets."""

    state: str  # health state
    part: str  # development, test, or further: fault-free and worst state on tyres that the paper's sets leave out
    case: Case
    reference: Case  # fault-free drive of the same car on other roads and tyres, which gives its baseline


class Seen(NamedTuple):
    """What the methods made of a drive of the paper's sets, by name of the method."""

    drive: SetDrive
    values: dict[str, np.ndarray]  # settled estimates [N*m] of a filter, variances [(N*m)**2] of the baseline
    enabled: dict[str, float]  # share of the drive in which it was enabled
    aligning: dict[str, float]  # error of the self-aligning torque over its spread, of filters
    early: bool  # whether the default monitor alarmed


def set_drives(effort: Effort) -> list[SetDrive]:
    """Table 2: 98 and 78 min fault-free in drives of 13 min (one of 7), one drive of 7 and 6 min for every fault."""
    healthy = ((4.0, 4.0), (4.0,)) if effort.quick else ((13.0,) * 7 + (7.0,), (13.0,) * 6)
    faulty = (4.0, 4.0) if effort.quick else (7.0, 6.0)
    found = []
    for which, part in enumerate(("development", "test")):
        for place, state in enumerate(STATES):
            for drive, minutes in enumerate(healthy[which] if state == "Healthy" else (faulty[which],)):
                found.append(
                    _set_drive(100 * (1 + which) + 20 * place + drive, state, minutes, 2 * which + drive, part)
                )
    for place, state in ((0, "Healthy"), (3, WORST)):
        driven = {each.case.tyres for each in found if each.state == state}
        for index in (index for index, tyres in enumerate(TYRES) if tyres not in driven and not effort.quick):
            found.append(_set_drive(300 + 20 * place + index, state, faulty[0], index, "further"))
    return found


def _set_drive(seed: int, state: str, minutes: float, turn: int, part: str) -> SetDrive:
    """A drive of a newly drawn car."""
    own, other = (list(TYRES)[place % len(TYRES)] for place in (turn, turn + 1))
    car = SEEDS.of(DRIVES, 1)[0] + seed
    reference = Case(car + 5000, HEALTHY, 7.0 if minutes > 5.0 else 5.0, car=car, tyres=other)
    return SetDrive(state, part, Case(car, STATES[state], minutes, car=car, tyres=own), reference)


def over_sets(drive: SetDrive) -> Seen:
    """Every drive has a car, sensors, tyres, a route and a driver of its own.

    The estimators assume the nominal car; the cars differ from it and from each other in tyres, trail, damping, inertia
    and in the gains and offsets of their sensors. The baseline is the variance over 15 s of the difference of two
    self-aligning torques, on the development set; with the printed sign of eq (1) a torque is compared with its own
    negative.
    """
    filters = {name: make() for name, make in FILTERS.items()}
    baselines = {name: make() for name, make in BASELINES.items()} if drive.part == "development" else {}
    samples = aligned(drive.case.recording(), monitor(), *filters.values(), *baselines.values())
    level = None
    if drive.state == "Healthy" and drive.part != "further":
        level = judged(aligned(drive.reference.recording(), monitor()))[1].level
    own, verdict = judged(samples, level)
    courses = {**{name: course(block, samples) for name, block in filters.items()}, named.DEFAULT: own}
    variances = {name: windows(block, samples) for name, block in baselines.items()}
    return Seen(
        drive,
        {name: each.settled for name, each in courses.items()} | {name: each[0] for name, each in variances.items()},
        {name: each.enabled[-1] / (60.0 * drive.case.minutes) for name, each in courses.items()}
        | {name: each[1] for name, each in variances.items()},
        {name: each.aligning_error for name, each in courses.items()},
        verdict.early,
    )


def distributions(seen: Sequence[Seen]) -> list[Row]:
    """A row for every method and health state, and one for every bar of Figures 3, 7 and 9."""
    rows: list[Row] = []
    paper = [each for each in seen if each.drive.part != "further"]
    for method in (*FILTERS, named.DEFAULT, *BASELINES):
        known = [each for each in paper if method in each.values]
        healthy = _pooled(known, method, "Healthy")
        for state in (*STATES, "all"):
            own = [each for each in known if state in ("all", each.drive.state)]
            values = _pooled(own, method)
            if not len(values):  # the printed gate leaves none
                values = np.full(1, np.nan)
            errors = np.concatenate([each.values[method] - STATES[each.drive.state] for each in own])
            minutes = np.array([each.drive.case.minutes for each in own])
            figures = {
                "mean": np.mean(values),
                "error": np.mean(errors) if len(errors) else math.nan,
                "deviation": np.std(values),
                "absolute": np.mean(np.abs(errors)) if len(errors) else math.nan,
                "aligning": np.mean([each.aligning.get(method, math.nan) for each in own]),
                "enabled": np.average([each.enabled[method] for each in own], weights=minutes),
                "accuracy": best_accuracy(healthy, values),
                "overlap": overlap(healthy, values, method in BASELINES) if np.isfinite(values).all() else math.nan,
                "area": area_under_curve(healthy, values),
                "tyres": _over_tyres(seen, method) if method in FILTERS and state == WORST else math.nan,
                "early": sum(each.early for each in own),
            }
            row = {name: float(value) for name, value in figures.items()}
            rows.append({"figure": "", "method": method, "state": state, **row})
    return [*rows, *_bars(seen)]


def _pooled(seen: Sequence[Seen], method: str, state: str = "", tyres: str = "") -> np.ndarray:
    chosen = (
        each.values[method] for each in seen if state in ("", each.drive.state) and tyres in ("", each.drive.case.tyres)
    )
    return np.concatenate([np.zeros(0), *chosen])


def _over_tyres(seen: Sequence[Seen], method: str) -> float:
    """Balanced accuracy of the worst pair of a healthy car on some tyres and a faulty car on any others."""
    healthy, faulty = (
        [values for tyres in TYRES if len(values := _pooled(seen, method, state, tyres))]
        for state in ("Healthy", WORST)
    )
    return min((best_accuracy(low, high) for low in healthy for high in faulty), default=math.nan)


def _bars(seen: Sequence[Seen]) -> Iterator[Row]:
    paper = [each for each in seen if each.drive.part != "further"]
    for name, chosen, method, tyres in (
        *((f"3, {each}", [one for one in paper if each in one.values], each, "") for each in BASELINES),
        ("7", paper, named.PRINTED, ""),
        *((f"9, {each}", list(seen), named.PRINTED, each) for each in TYRES),
    ):
        groups = {state: _pooled(chosen, method, state, tyres) for state in ("Healthy", WORST)}
        if not all(map(len, groups.values())):
            continue
        # The largest values would squeeze all others into a few bars.
        ends = [np.quantile(values, (0.005, 0.995)) for values in groups.values()]
        at = np.linspace(min(low for low, _ in ends), max(high for _, high in ends), BINS + 1)
        for group, values in groups.items():
            for low, high, share in zip(at[:-1], at[1:], shares(values, at), strict=True):
                yield {"figure": name, "group": group, "low": float(low), "high": float(high), "share": float(share)}


POSITIONS = ABOVE, TWIST, BELOW = "above the bar", "above the bar, less its twist", "below the bar"
STARTS = (6e-4, 1e-2, 1.0)  # P0 of friction, which is not printed [(N*m)**2]; it matters with Q as printed alone


class PositionDrives(NamedTuple):
    """Drives over which every reading, P0 and position of the angle's sensor are tried."""

    condition: str  # name in `CONDITIONS`
    routes: tuple[int, ...]
    minutes: float


def over_positions(drives: PositionDrives) -> list[Row]:
    """The paper does not print where angle and rate are measured, P0 of friction, nor how G is to be read.

    Between a steering wheel and friction lies the torsion bar: measured above it the wheel turns while the column still
    sticks; "less its twist" subtracts torque over stiffness. The filter starts at 3 N·m; times run until it has gone 80
    % of the way to the true 12.5 N·m. With l_p as the pneumatic trail alone, as the paper words it, the error does not
    grow with friction.
    """
    settings = [(reading, start) for reading in READINGS for start in (STARTS if reading == named.PRINTED else (1.0,))]
    blocks = {(reading, start): READINGS[reading](start) for reading, start in settings}
    driven = []
    for level in (HEALTHY, STATES[WORST]):
        for route in drives.routes:
            case = Case(route, level, drives.minutes, condition=drives.condition)
            recording = case.recording(with_motor=True)
            driven.append((case, aligned(recording, *blocks.values(), more=("pinion_angle", "motor_speed"))))
    rows: list[Row] = []
    for position in POSITIONS:
        seen = [(case.friction, _measured(samples, position, case)) for case, samples in driven]
        for (reading, start), block in blocks.items():
            healthy, faulty = (
                [course(block, samples) for friction, samples in seen if friction == level]
                for level in (HEALTHY, STATES[WORST])
            )
            setting: Row = {"condition": drives.condition, "position": position, "reading": reading, "start": start}
            rows.append({**setting, **_figures(healthy, faulty)})
    return rows


def _measured(samples: Aligned, position: str, case: Case) -> Aligned:
    """The samples with angle and rate of the steering wheel as measured at a position."""
    if position == ABOVE:
        return samples
    columns = dict(zip(samples.names, samples.values.T, strict=True))
    if position == BELOW:
        angle, rate = columns["pinion_angle"], columns["motor_speed"] / gear_of(case.setup().car)
    else:
        # Five samples: the derivative of a noisier torque would decide the sign of the rate.
        torque = np.convolve(columns["driver_torque"], np.ones(5) / 5.0, "same")
        twist = torque / vehicle()["torsion_bar_stiffness"]
        angle, rate = (
            columns["steering_wheel_angle"] - twist,
            columns["steering_wheel_rate"] - np.gradient(twist) * RATE,
        )
    changed = columns | {"steering_wheel_angle": angle, "steering_wheel_rate": rate}
    return replace(samples, values=np.column_stack(list(changed.values())))


def _figures(healthy: Sequence[Course], faulty: Sequence[Course]) -> dict[str, float]:
    low, high = (np.concatenate([each.settled for each in courses]) for courses in (healthy, faulty))
    enabled, total = np.mean([reached(each, STATES[WORST]) for each in faulty], axis=0).tolist()
    spreads = [float(np.std(values)) if len(values) else math.nan for values in (low, high)]
    scatters = all(1.5 <= each <= 2.2 for each in spreads)
    return {
        "enabled": enabled,
        "total": total,
        "reads": float(np.mean(high)) if len(high) else math.nan,
        "healthy": spreads[0],
        "faulty": spreads[1],
        "accuracy": right_side(low, high, THRESHOLD),
        "both": float(scatters and 30.0 <= enabled <= 75.0),
    }


def over_terms(task: tuple[str, float, tuple[int, ...], float]) -> list[Row]:
    """Eq (19) has two terms more than the filter that the paper runs: with the slope of the ratio, and Dirac's delta.

    Delta is twice as large as printed and here as wide as a sign smoothed over 0.02 rad/s. All filters have an open
    self-aligning torque and know the ratio's growth where they use it.
    """
    condition, level, routes, minutes = task
    blocks = {
        "paper": READINGS[named.OPEN](1.0),
        "ratio": with_terms(RATIO_GROWTH, 0.0, 0.0),
        "slope": with_terms(RATIO_GROWTH, 1.0, 0.0),
        "all": with_terms(RATIO_GROWTH, 1.0, 1.0),
    }
    drives = [aligned(Case(each, level, minutes, condition=condition).recording(), *blocks.values()) for each in routes]
    mean = {
        name: float(np.mean(np.concatenate([course(block, each).settled for each in drives])))
        for name, block in blocks.items()
    }
    road = f"grows by {100 * RATIO_GROWTH:g} % per rad²" if condition == VARIABLE_RATIO else "constant"
    moved = {
        "delta": abs(mean["all"] - mean["slope"]),
        "slope": abs(mean["slope"] - mean["ratio"]),
        "ratio": abs(mean["ratio"] - mean["paper"]),
    }
    return [{"steering ratio": road, "level": level, **moved}]


PWM = (0, 5, 10, 15, 20, 25, 30, 35)  # Duty cycles of the clutch brake [%]; appendix A
SUPPORTS: tuple[Support, ...] = ("hoist", "ground")
TABLE_1 = {15: (1.0, 2.0), 20: (3.0, 5.0), 25: (7.0, 10.0)}
"""Injected friction as printed in Table 1: PWM [%] -> range [N*m]."""

BRAKE_DEVIATION = 0.10
"""Relative standard deviation of the brake torque from trial to trial [-]; in line with printed ranges [assumed]."""


def brake_torque(pwm: float) -> float:
    """Friction that the clutch brake adds at the steering wheel axis [N*m], in agreement with Table 1.

    Args:
        pwm: duty cycle [%]

    Source: a power law with the exponent 3.4 meets the middles of the three printed ranges, 1.5, 4 and 8.5 N*m, within
    1 %; below and above them it is extrapolated [assumed].
    """
    return 1.5 * float((pwm / 15.0) ** 3.4)


def turns(quick: bool) -> list[Row]:
    """The work balance over a closed turn from lock to lock gives total friction, on the hoist and on the ground.

    What the brake added is the difference to the mean of the turns at 0 %. The virtual brake follows a law in kind with
    Table 1 and scatters by 10 % from trial to trial, as a slipping clutch does.
    """
    method = HysteresisIdentification.of_vehicle(vehicle())
    seeds = SEEDS.of(TURNS, 10_000)
    chance = np.random.default_rng(seeds[-1])
    rows: list[Row] = []
    for support in SUPPORTS:
        found = []
        for pwm in (0, 15, 25) if quick else PWM:
            for trial in range(1 if quick else 2):
                added = brake_torque(pwm) * math.exp(BRAKE_DEVIATION * chance.standard_normal())
                recording = lock_to_lock(HEALTHY + added, support == "hoist", seed=seeds[100 * pwm + trial])
                found.append((pwm, added, method.identify(recording, support).friction_torque))
        free = float(np.mean([total for pwm, _, total in found if pwm == 0]))
        rows += [
            {"support": support, "pwm": pwm, "total": total, "added": added, "increase": total - free,
             "miss": abs(total - free - added)}
            for pwm, added, total in found
        ]  # fmt: skip
    return rows


def position_drives(effort: Effort) -> list[PositionDrives]:
    """The drives in both styles."""
    first = SEEDS.of(DRIVES, 1)[0]
    routes, minutes = ((8201,), 6.0) if effort.quick else ((8201, 8202, 8203, 8204, 8205), 10.0)
    return [PositionDrives(condition, tuple(first + each for each in routes), minutes) for condition in (USUAL, FAST)]


def term_drives(effort: Effort) -> list[tuple[str, float, tuple[int, ...], float]]:
    """The drives on both ratios, at two levels."""
    first = SEEDS.of(DRIVES, 1)[0]
    routes, minutes = ((8101,), 4.0) if effort.quick else ((8101, 8102, 8103), 7.0)
    given = tuple(first + each for each in routes)
    return [(road, level, given, minutes) for road in (USUAL, VARIABLE_RATIO) for level in (HEALTHY, STATES[WORST])]
