"""Robustness of a verdict: whether it turns into another one within the spread of the vehicle's parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.facts import GUESSES, Fact, Verdict, shortened
from tierod.core.findings import Element, Estimate, ParameterEffect, Status
from tierod.core.shown import in_words as value_in_words
from tierod.core.shown import shown, written
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.advice import cure, in_words
from tierod.monitors.harness.spread.carried import REACH
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.points import Concluded
from tierod.vehicles.vehicle import Vehicle

FAULT = "fault"
LIMITS = ("rising", FAULT)
"""Names of the references beyond which an estimate raises an alarm."""

DECIDING = 0.8
"""Share of the squared change that the parameters named as deciding have together, at least [-]."""

MOST_NAMED = 3
"""Largest number of parameters that are named as deciding."""


class Turn(NamedTuple):
    """Another verdict for a vehicle within the spread of the parameters.

    Args:
        status: status for that vehicle
        names: parameters that decide, the most important first
        elements: states of sensors and actuators for that vehicle
    """

    status: Status
    names: tuple[str, ...]
    elements: tuple[Element, ...]


def turn(conclusion: Conclusion, outcome: Outcome) -> Turn | None:
    """Nearest vehicle within the spread with another verdict; None if the verdict is robust.

    An alarm turns if such a vehicle is healthy, or if other sensors or actuators are at fault for it. A healthy verdict
    turns if such a vehicle raises an alarm by an estimate beyond its reference. An alarm from signals that are
    inconsistent with the parameters turns nothing, since the recording then contradicts that vehicle.

    Args:
        conclusion: conclusion for the unperturbed vehicle
        outcome: results of the perturbed vehicles
    """
    points = [*outcome.alone.values()]
    if outcome.reference is None or _alike(conclusion, outcome.reference):
        points += [each for _, several in outcome.along for each in several]
    turning = [each for each in points if _turns(conclusion, each.conclusion)]
    if not turning:
        return None
    nearest = min(turning, key=lambda each: sum(by * by for by in each.by.values()))
    found = nearest.conclusion
    return Turn(found.verdict.status, _deciding(nearest), found.elements)


def turn_by_estimate(
    verdict: Verdict, variance: float, effects: Sequence[ParameterEffect], vehicle: Vehicle
) -> Turn | None:
    """Turn of a verdict by its estimate alone: two standard deviations of the parameters reach across the lowest limit.

    For an alarm that rests on a limit of the vehicle file, the variance of that limit, such as that of a class of cars,
    and those of the sensors' gains are added, and the limit counts without the margin from which it acts. For a
    healthy verdict both are ignored: otherwise a car that is typical of its class could never be healthy.

    Args:
        verdict: verdict for the unperturbed vehicle
        variance: variance that the parameters add to its estimate [unit squared]
        effects: effects of the parameters, the largest first
        vehicle: vehicle with the standard deviations of its parameters
    """
    estimate = verdict.estimate
    limits = [] if estimate is None else [estimate.reference[name] for name in LIMITS if name in estimate.reference]
    if estimate is None or not limits:
        return None
    parts, lowest = {each.name: each.effect**2 for each in effects}, min(limits)
    if verdict.status.alarm and estimate.limits:
        behind = [vehicle.parameters[name] for name in estimate.limits]
        own = {each.name: (each.standard_deviation or 0.0) ** 2 for each in behind}
        own |= {name: size**2 for name, size in estimate.by_sensors.items()}
        parts, variance = parts | own, variance + sum(own.values())
        lowest = min(each.value for each in behind)
    reach, names = REACH * math.sqrt(variance), _enough(parts)
    if verdict.status is Status.HEALTHY and estimate.value + reach > lowest > estimate.value:
        return Turn(Status.FAULT if len(limits) == 1 else Status.RISING, names, ())
    if verdict.status.alarm and estimate.value - reach < lowest < estimate.value:
        return Turn(Status.HEALTHY, names, ())
    return None


def hidden_fault(verdict: Verdict, added: float, effects: Sequence[ParameterEffect]) -> Turn | None:
    """Turn of a healthy verdict whose 95 % interval contains the limit of a fault.

    The interval is that of scatter, parameters and assumptions on the sensors together. The names are empty where the
    scatter alone reaches the limit, so that no parameter decides.

    Args:
        verdict: verdict for the unperturbed vehicle
        added: variance that the parameters add to the deviation of its estimate [unit squared]
        effects: effects of the parameters, the largest first
    """
    estimate = verdict.estimate
    if verdict.status is not Status.HEALTHY or estimate is None or FAULT not in estimate.reference:
        return None
    limit, own = _fault_from(estimate), estimate.standard_deviation**2
    if not estimate.value < limit < estimate.value + REACH * math.sqrt(own + added):
        return None
    inside = {name: size**2 for name, size in (estimate.by_sensors | estimate.held).items()}
    scatter = math.sqrt(max(own - sum(inside.values()), 0.0))
    names = _enough({each.name: each.effect**2 for each in effects} | inside)
    return Turn(Status.FAULT, () if estimate.value + REACH * scatter > limit else names, ())


def _fault_from(estimate: Estimate) -> float:
    """Value from which an estimate is a fault, without the margin of the alarm [unit]."""
    return estimate.reference[FAULT] if estimate.fault_from is None else estimate.fault_from


def _turns(conclusion: Conclusion, moved: Conclusion) -> bool:
    own, other = conclusion.verdict, moved.verdict
    if own.status.alarm:
        faulty = _at_fault(conclusion.elements)
        return other.status.quiet or (bool(faulty) and faulty.isdisjoint(_at_fault(moved.elements)))
    if not own.status.quiet or other.estimate is None or not other.estimate.reference:
        return False
    return other.status in (Status.FAULT, Status.RISING)


def _alike(conclusion: Conclusion, reference: Conclusion) -> bool:
    """Whether a session that began later has the same verdict; if not, it lacks the evidence for a comparison."""
    same = conclusion.verdict.status is reference.verdict.status
    return same and _at_fault(conclusion.elements) == _at_fault(reference.elements)


def _at_fault(elements: Sequence[Element]) -> set[str]:
    return {each.name for each in elements if each.status.alarm}


def _deciding(point: Concluded) -> tuple[str, ...]:
    """Parameters that make up most of a perturbation."""
    return _enough({name: by * by for name, by in point.by.items()})


def _enough(parts: Mapping[str, float]) -> tuple[str, ...]:
    """Names of the largest parts that together have the share `DECIDING`, `MOST_NAMED` at most."""
    ordered = sorted(parts, key=lambda name: -parts[name])
    total, held, names = sum(parts.values()), 0.0, []
    for name in ordered[:MOST_NAMED]:
        names.append(name)
        held += parts[name]
        if held >= DECIDING * total:
            break
    return tuple(names)


def turned(conclusion: Conclusion, found: Turn, vehicle: Vehicle, baseline: str = "") -> Conclusion:
    """Conclusion with a verdict that turns: an alarm becomes suspect, healthy becomes not identifiable.

    Args:
        conclusion: conclusion for the unperturbed vehicle
        found: verdict for the vehicle within the spread
        vehicle: vehicle with the standard deviations of its parameters
        baseline: command that learns a baseline, which would decide; "" where the monitor uses none
    """
    if not found.names:
        return _unseen(conclusion)
    verdict, names = conclusion.verdict, in_words(found.names)
    given = "; ".join(_spread_in_words(vehicle, name, verdict.estimate) for name in found.names)
    assumed = [name for name in found.names if verdict.estimate is not None and name in verdict.estimate.assumed]
    fact = Fact(
        GUESSES,
        f"the verdict depends on {names}: within the spread ({given}) it is {_as_found(found)}",
        f"{found.names[0]} decides the verdict" if len(found.names) == 1 else "parameters decide the verdict",
        cure(found.names, assumed, baseline),
        allows=Status.NOT_IDENTIFIABLE,
        doubts=True,
    )
    return replace(_not_robust(conclusion, fact), elements=_doubted(conclusion.elements, found.elements))


def _unseen(conclusion: Conclusion) -> Conclusion:
    """Conclusion on a healthy estimate whose scatter may hide a fault."""
    estimate = conclusion.verdict.estimate
    assert estimate is not None
    highest, limit = (
        value_in_words(each, estimate.unit)
        for each in (estimate.value + REACH * estimate.standard_deviation, _fault_from(estimate))
    )
    cause = f"the scatter of the estimate may hide a fault: its interval reaches {highest}, a fault begins at {limit}"
    action = "record again, for longer and with less noise"
    return _not_robust(conclusion, Fact(GUESSES, cause, shortened(cause), action, allows=Status.NOT_IDENTIFIABLE))


def _not_robust(conclusion: Conclusion, fact: Fact) -> Conclusion:
    """Conclusion with a verdict that is not robust: no baseline by itself, and no course of a fault memory."""
    verdict = replace(conclusion.verdict, facts=(fact, *conclusion.verdict.facts))
    unproven = conclusion.baseline or conclusion.unproven
    return replace(conclusion, verdict=verdict, baseline=None, unproven=unproven, course=(), code_courses={})


def _as_found(found: Turn) -> str:
    """Other verdict in words, with the elements at fault."""
    names = tuple(sorted(each.replace("_", " ") for each in _at_fault(found.elements)))
    return f"a fault of {in_words(names)}" if names and found.status.alarm else str(found.status)


def _doubted(elements: tuple[Element, ...], others: tuple[Element, ...]) -> tuple[Element, ...]:
    """Elements, of which those that are faulty for this vehicle but not for the other one become suspect."""
    faulty = {each.name for each in others if each.status is Status.FAULT}
    return tuple(
        replace(each, status=Status.SUSPECT) if each.status is Status.FAULT and each.name not in faulty else each
        for each in elements
    )


def _spread_in_words(vehicle: Vehicle, name: str, estimate: Estimate | None) -> str:
    """Parameter with its standard deviation, or a sensor's gain with the share of the estimate that it makes up."""
    if estimate is not None and name in estimate.by_sensors:
        return f"{name} {estimate.by_sensors[name] / abs(estimate.value):.2g}"
    return spread_of(vehicle, name)


def spread_of(vehicle: Vehicle, name: str) -> str:
    """Parameter with its standard deviation, in words: "rear_distance ±0.2 m".

    Args:
        vehicle: vehicle with the parameter
        name: name of the parameter
    """
    parameter = vehicle.parameters[name]
    return f"{name} ±{parameter.standard_deviation or 0.0:.3g} {written(parameter.unit)}".rstrip()


def most_important(each: ParameterEffect, vehicle: Vehicle) -> str:
    """Half-sentence on the effect of a parameter on the result.

    Args:
        each: effect of the parameter
        vehicle: vehicle with the parameter
    """
    return f"{spread_of(vehicle, each.name)} shifts it by {moves_by(each)}"


def moves_by(each: ParameterEffect) -> str:
    """Change of the result by one standard deviation, in words: "±2.6 degrees"."""
    factor, label = shown(each.effect_unit)
    label = " degrees" if label == "°" else f" {label}" if label else " of the threshold"
    return f"±{abs(each.effect) * factor:.2g}{label}"
