"""Robustness of a verdict: wider bands by uncertain parameters, and whether the verdict is another one within them."""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.facts import GUESSES, Fact, Verdict
from tierod.core.findings import Element, Estimate, ParameterEffect, Status
from tierod.core.shown import in_words as value_in_words
from tierod.core.shown import shown, written
from tierod.monitors.session import Conclusion
from tierod.monitors.uncertainty import SMALLEST, Effects
from tierod.vehicles.classes import may_move
from tierod.vehicles.vehicle import SHIPPED, Vehicle

REACH = 2.0  # Standard deviations from an estimate to the end of its 95 % band [-]

MOST = 0.8  # Share of the squared change that the parameters named as deciding have together, at least [-]

FAULT = "fault"
LIMITS = ("rising", FAULT)  # Names of the references beyond which an estimate raises an alarm

PLACEHOLDER, BASELINE_FILE = "FAULT_FREE_DRIVE", "my-car.json"
"""Names of a recording and of a baseline in a command that is to be adapted."""


class Turn(NamedTuple):
    """Another verdict for a vehicle within the spread of the parameters."""

    status: Status  # status for that vehicle
    # parameters that decide, the most important first; empty where the scatter of the estimate does
    names: tuple[str, ...] = ()
    elements: tuple[Element, ...] = ()  # states of sensors and actuators for that vehicle


class Robust(NamedTuple):
    """Conclusion including the spread of the parameters, and the effects of these, the largest first."""

    conclusion: Conclusion
    effects: tuple[ParameterEffect, ...]


def robust(conclusion: Conclusion, found: Effects | None, vehicle: Vehicle, may_turn: bool, learns: bool) -> Robust:
    """Conclusion for a vehicle whose parameters are uncertain.

    Args:
        found: what the lanes show; None if no parameter was perturbed
        may_turn: whether the verdict depends on the parameters; with a baseline it does not, since the baseline has the
            same errors
        learns: whether the monitor learns a baseline, which would then decide
    """
    verdict, included = conclusion.verdict, conclusion.parameter_variance
    rows = () if found is None else _rows(found, verdict.estimate, vehicle, included)
    if may_turn:
        turn = _in_a_lane(conclusion, found) if found is not None else None
        turn = turn or _beyond_its_limit(verdict, rows, vehicle)
        turn = turn or hidden_fault(verdict, 0.0 if included is not None else _variance(rows), rows)
    else:
        turn = _beyond_its_limit(verdict, (), vehicle)
    if found is not None and rows:
        conclusion = _widened(conclusion, found, rows, vehicle, advising=turn is None)
    if turn is not None:
        return Robust(_turned(conclusion, turn, vehicle, learns and may_turn), rows)
    # A verdict with a doubt of its own keeps the level that the user's word may make a baseline.
    doubtful = verdict.status is Status.SUSPECT
    return Robust(conclusion if doubtful else replace(conclusion, unproven=None), rows)


def exact(conclusion: Conclusion, vehicle: Vehicle, may_turn: bool, learns: bool) -> Conclusion:
    """Conclusion for exact parameters: not healthy where the interval of the estimate contains a fault."""
    turn = hidden_fault(conclusion.verdict) if may_turn else None
    return conclusion if turn is None else _turned(conclusion, turn, vehicle, learns)


def _rows(
    found: Effects, estimate: Estimate | None, vehicle: Vehicle, included: float | None
) -> tuple[ParameterEffect, ...]:
    """Effects of the parameters on an estimate, or on the main result over time where there is none."""
    sizes, own, unit = dict(found.sizes), found.own, found.unit or ""
    if estimate is not None:
        if included is not None:
            total = math.hypot(*sizes.values())
            sizes = {name: size * math.sqrt(included) / (total or 1.0) for name, size in sizes.items()}
            own = math.sqrt(max(estimate.standard_deviation**2 - included, 0.0))
        else:
            sizes = (sizes if found.unit == estimate.unit else {}) | _moves(found, estimate)
            own = estimate.standard_deviation
        unit = estimate.unit
    counted = sorted((name for name in sizes if abs(sizes[name]) > SMALLEST * own), key=lambda name: -abs(sizes[name]))
    total = sum(size * size for size in sizes.values())
    rows = []
    for name in counted:
        each, size = vehicle.parameters[name], sizes[name]
        deviation = each.standard_deviation or 0.0
        rows.append(ParameterEffect(name, each.value, deviation, each.unit, size, unit, size * size / total))
    return tuple(rows)


def _variance(rows: Sequence[ParameterEffect]) -> float:
    """Variance that all parameters add to a result, those included that are too small to be listed."""
    return rows[0].effect ** 2 / rows[0].share if rows else 0.0


def _moves(found: Effects, estimate: Estimate) -> dict[str, float]:
    """Change of the estimate by one standard deviation of each parameter."""
    base = estimate if found.reference is None else found.reference.verdict.estimate
    if base is None:
        return {}
    slopes: dict[str, list[float]] = {}
    for (name, side), lane in found.lanes.items():
        other = lane.verdict.estimate
        alike = other is not None and (other.unit, other.quantity) == (base.unit, base.quantity)
        if other is not None and alike and math.isfinite(other.value):
            slopes.setdefault(name, []).append((other.value - base.value) / side)
    return {name: math.copysign(math.hypot(*each) / math.sqrt(len(each)), sum(each)) for name, each in slopes.items()}


def _widened(
    conclusion: Conclusion, found: Effects, rows: Sequence[ParameterEffect], vehicle: Vehicle, advising: bool
) -> Conclusion:
    """Conclusion with the standard deviation of its estimate widened by the parameters."""
    verdict, estimate = conclusion.verdict, conclusion.verdict.estimate
    evidence, facts = dict(verdict.evidence), verdict.facts
    if estimate is not None:
        variance, own = _variance(rows), estimate.standard_deviation
        deviation = own if conclusion.parameter_variance is not None else math.sqrt(own**2 + variance)
        share = evidence["variance_from_parameters_share"] = variance / deviation**2 if deviation > 0.0 else 0.0
        estimate, first = replace(estimate, standard_deviation=deviation), first_to_measure(rows)
        if share > 0.5 and first is not None:
            cause = f"{spread_of(vehicle, first.name)} shifts it by {moves_by(first)}"
            facts = (*facts, Fact("parameter", f"{cause}{'; measure it first' if advising else ''}"))
    if found.within is not None and "truth_within_band_share" in evidence:
        evidence["truth_within_wider_band_share"] = found.within
    histograms = f"Estimates with the parameters of the vehicle file; an error of {rows[0].name} shifts them all."
    return replace(
        conclusion,
        verdict=replace(verdict, estimate=estimate, evidence=evidence, facts=facts),
        remarks={**conclusion.remarks, "histograms": histograms},
    )


def _in_a_lane(conclusion: Conclusion, found: Effects) -> Turn | None:
    """Another verdict in a lane, the one of the most important parameter; None if the verdict is robust.

    An alarm turns if such a vehicle is healthy, or if other sensors or actuators are at fault for it. A healthy verdict
    turns if such a vehicle raises an alarm by an estimate beyond its reference. An alarm from signals that are
    inconsistent with the parameters turns nothing, since the recording then contradicts that vehicle.
    """
    reference = found.reference or conclusion
    own, faulty = conclusion.verdict.status, at_fault(conclusion.elements)
    if reference.verdict.status is not own or at_fault(reference.elements) != faulty:
        return None  # on the grid of the lanes the verdict is another one, which compares with nothing
    for (name, _), lane in sorted(found.lanes.items(), key=lambda each: -found.sizes.get(each[0][0], 0.0)):
        other, estimate = lane.verdict.status, lane.verdict.estimate
        if own.alarm:
            turns = other.quiet or (bool(faulty) and faulty.isdisjoint(at_fault(lane.elements)))
        else:
            turns = own.quiet and other in (Status.FAULT, Status.RISING) and bool(estimate and estimate.reference)
        if turns:
            return Turn(other, (name,), lane.elements)
    return None


def _beyond_its_limit(verdict: Verdict, rows: Sequence[ParameterEffect], vehicle: Vehicle) -> Turn | None:
    """Turn of a verdict by its estimate alone: two standard deviations of the parameters reach across the lowest limit.

    For an alarm that rests on a limit of the vehicle file, the variance of that limit, such as that of a class of cars,
    and those of the sensors' gains are added, and the limit counts without the margin from which it acts. For a
    healthy verdict both are ignored: otherwise a car that is typical of its class could never be healthy.
    """
    estimate = verdict.estimate
    limits = [] if estimate is None else [estimate.reference[name] for name in LIMITS if name in estimate.reference]
    if estimate is None or not limits:
        return None
    parts, variance, lowest = {each.name: each.effect**2 for each in rows}, _variance(rows), min(limits)
    if verdict.status.alarm and estimate.limits:
        behind = [vehicle.parameters[name] for name in estimate.limits]
        own = {each.name: (each.standard_deviation or 0.0) ** 2 for each in behind}
        own |= {name: size**2 for name, size in estimate.by_sensors.items()}
        parts, variance = parts | own, variance + sum(own.values())
        lowest = min(each.value for each in behind)
    reach = REACH * math.sqrt(variance)
    if verdict.status is Status.HEALTHY and estimate.value + reach > lowest > estimate.value:
        return Turn(Status.FAULT if len(limits) == 1 else Status.RISING, _most_of(parts))
    if verdict.status.alarm and estimate.value - reach < lowest < estimate.value:
        return Turn(Status.HEALTHY, _most_of(parts))
    return None


def hidden_fault(verdict: Verdict, added: float = 0.0, rows: Sequence[ParameterEffect] = ()) -> Turn | None:
    """Turn of a healthy verdict whose 95 % interval contains the limit of a fault.

    The interval is that of scatter, parameters and assumptions on the sensors together.

    Args:
        added: variance that the parameters add to the deviation of its estimate [unit squared]
    """
    estimate = verdict.estimate
    if verdict.status is not Status.HEALTHY or estimate is None or FAULT not in estimate.reference:
        return None
    limit, own = _fault_from(estimate), estimate.standard_deviation**2
    if not estimate.value < limit < estimate.value + REACH * math.sqrt(own + added):
        return None
    inside = {name: size**2 for name, size in (estimate.by_sensors | estimate.held).items()}
    scatter = math.sqrt(max(own - sum(inside.values()), 0.0))
    by_scatter = estimate.value + REACH * scatter > limit
    names = () if by_scatter else _most_of({each.name: each.effect**2 for each in rows} | inside)
    return Turn(Status.FAULT, names)


def _fault_from(estimate: Estimate) -> float:
    """Value from which an estimate is a fault, without the margin of the alarm [unit]."""
    return estimate.reference[FAULT] if estimate.fault_from is None else estimate.fault_from


def at_fault(elements: Sequence[Element]) -> set[str]:
    """Names of the sensors and actuators with an alarm."""
    return {each.name for each in elements if each.status.alarm}


def _most_of(parts: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the largest parts that together have the share `MOST`, three at most."""
    ordered = sorted(parts, key=lambda name: -parts[name])
    total = sum(parts.values())
    needed = next((n for n in (1, 2) if sum(parts[name] for name in ordered[:n]) >= MOST * total), 3)
    return tuple(ordered[:needed])


def _turned(conclusion: Conclusion, turn: Turn, vehicle: Vehicle, learns: bool) -> Conclusion:
    """Conclusion with the fact that the verdict is not robust: no baseline by itself, no course of a fault memory."""
    verdict = conclusion.verdict
    fact = _decided_by_guesses(verdict, turn, vehicle, learns) if turn.names else _scatter(verdict.estimate)
    faulty = {each.name for each in turn.elements if each.status is Status.FAULT}
    elements = tuple(
        replace(each, status=Status.SUSPECT) if each.status is Status.FAULT and each.name not in faulty else each
        for each in conclusion.elements
    )
    return replace(
        conclusion,
        verdict=replace(verdict, facts=(fact, *verdict.facts)),
        elements=elements if turn.names else conclusion.elements,
        unproven=conclusion.baseline or conclusion.unproven,
        baseline=None,
        course=(),
        code_courses={},
    )


def _decided_by_guesses(verdict: Verdict, turn: Turn, vehicle: Vehicle, learns: bool) -> Fact:
    """Fact that parameters decide: an alarm becomes suspect, healthy becomes not identifiable."""
    estimate, names = verdict.estimate, turn.names
    spreads = []
    for name in names:
        by_sensors = estimate is not None and name in estimate.by_sensors
        gain = f"{name} {estimate.by_sensors[name] / abs(estimate.value):.2g}" if estimate and by_sensors else ""
        spreads.append(gain or spread_of(vehicle, name))
    others = tuple(sorted(each.replace("_", " ") for each in at_fault(turn.elements)))
    other = f"a fault of {in_words(others)}" if others and turn.status.alarm else str(turn.status)
    assumed = [name for name in names if estimate is not None and name in estimate.assumed]
    return Fact(
        GUESSES,
        f"the verdict depends on {in_words(names)}: within the spread ({'; '.join(spreads)}) it is {other}",
        f"{names[0]} decides the verdict" if len(names) == 1 else "parameters decide the verdict",
        cure(names, assumed, baseline_command(verdict.monitor, vehicle) if learns else ""),
        allows=Status.NOT_IDENTIFIABLE,
        doubts=True,
    )


def _scatter(estimate: Estimate | None) -> Fact:
    """Fact that the scatter of a healthy estimate may hide a fault."""
    assert estimate is not None
    reached = estimate.value + REACH * estimate.standard_deviation
    highest, limit = (value_in_words(each, estimate.unit) for each in (reached, _fault_from(estimate)))
    cause = f"the scatter of the estimate may hide a fault: its interval reaches {highest}, a fault begins at {limit}"
    action = "record again, for longer and with less noise"
    return Fact(GUESSES, cause, "scatter may hide a fault", action, allows=Status.NOT_IDENTIFIABLE)


def spread_of(vehicle: Vehicle, name: str) -> str:
    """Parameter with its standard deviation, in words: "rear_distance ±0.2 m"."""
    parameter = vehicle.parameters[name]
    return f"{name} ±{parameter.standard_deviation or 0.0:.3g} {written(parameter.unit)}".rstrip()


def moves_by(each: ParameterEffect) -> str:
    """Change of the result by one standard deviation, in words: "±2.6 degrees"."""
    factor, label = shown(each.effect_unit)
    label = " degrees" if label == "°" else f" {label}" if label else " of the threshold"
    return f"±{abs(each.effect) * factor:.2g}{label}"


def in_words(names: Sequence[str]) -> str:
    """Names, at least one, as part of a sentence."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def first_to_measure(rows: Sequence[ParameterEffect]) -> ParameterEffect | None:
    """First effect of a parameter that a measurement makes more certain: of no chosen limit and no whole number."""
    return next((each for each in rows if may_move(each.name)), None)


def baseline_command(monitor: str, vehicle: Vehicle) -> str:
    """Command that learns the baseline of a car from a recording that the user knows to be fault-free."""
    name, _, variant = monitor.partition(", ")
    car = vehicle.name if vehicle.path.parent == SHIPPED else str(vehicle.path)
    return (
        f"tierod diagnose {PLACEHOLDER} --vehicle {shlex.quote(car)} --monitor {name} --variant {variant} "
        f"--baseline {BASELINE_FILE} --fault-free"
    )


def cure(names: Sequence[str], assumed: Sequence[str], baseline: str) -> str:
    """What decides a verdict that depends on guesses: only what a user can do, the surest way first."""
    ways = []
    if baseline:
        ways.append(
            f"give a fault-free drive of this car as baseline: '{baseline}', and judge this recording with --baseline "
            f"{BASELINE_FILE}"
        )
    if assumed:
        ways.append(f"calibrate driver_torque and motor_torque, and enter {in_words(assumed)} in the vehicle file")
    if known := [name for name in names if name not in assumed and may_move(name)]:
        ways.append(
            f"measure {in_words(known)} first, enter value and standard_deviation in the vehicle file, and judge again"
        )
    return "; or ".join(ways)
