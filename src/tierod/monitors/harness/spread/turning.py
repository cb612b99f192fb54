"""Whether a verdict turns within the spread of the vehicle's parameters."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tierod.core.findings import CONSISTENT, INCONSISTENT, Element, Finding, ParameterEffect, Status
from tierod.core.shown import shown, written
from tierod.monitors.harness.session import Conclusion
from tierod.monitors.harness.spread.carried import REACH
from tierod.monitors.harness.spread.parameter_spread import Outcome
from tierod.monitors.harness.spread.points import Concluded
from tierod.vehicles.vehicle import Vehicle

ALARMS = (Status.FAULT, Status.RISING, Status.SUSPECT)

LIMITS = ("rising", "fault")
"""Names of references beyond which an estimate raises an alarm."""

DECIDING = 0.8
"""Share of a move that the parameters hold which are named as deciding."""

MOST_NAMED = 3


class Turn(NamedTuple):
    """A verdict that is another one for a car within the spread.

    Args:
        status: for that car
        names: of the parameters that decide, the most important first
        elements: sensors and actuators as judged for that car
    """

    status: Status
    names: tuple[str, ...]
    elements: tuple[Element, ...]


def turn(conclusion: Conclusion, outcome: Outcome) -> Turn | None:
    """The car within the spread for which the verdict is another one; None where there is none.

    An alarm turns where such a car is healthy, or where another sensor or actuator is at fault for it. Healthy turns
    where such a car raises an alarm by an estimate beyond its reference. An alarm that comes from signals and
    parameters that do not fit each other turns nothing: the recording then speaks against that car.

    Args:
        conclusion: for the vehicle as it is
        outcome: for the moved ones
    """
    points = [*outcome.alone.values()]
    if outcome.reference is None or _alike(conclusion, outcome.reference):
        points += [each for _, several in outcome.along for each in several]
    turning = [each for each in points if _turns(conclusion, each.conclusion)]
    if not turning:
        return None
    nearest = min(turning, key=lambda each: sum(by * by for by in each.by.values()))
    found = nearest.conclusion
    return Turn(found.finding.status, _deciding(nearest), found.elements)


def turn_by_estimate(
    finding: Finding, variance: float, effects: Sequence[ParameterEffect], vehicle: Vehicle
) -> Turn | None:
    """The same from the estimate alone: the other side of its lowest limit is within two deviations of the parameters.

    A limit that the vehicle file gives with a deviation of its own, such as that of a class of cars, counts with it
    where an alarm rests on it. It turns no healthy verdict: a car that is typical of its class would have none.

    Args:
        finding: for the vehicle as it is
        variance: that the parameters add to its estimate, in the unit squared
        effects: of the parameters, the one that moves it most first
        vehicle: with the standard deviation of its parameters
    """
    estimate = finding.estimate
    limits = [] if estimate is None else [estimate.reference[name] for name in LIMITS if name in estimate.reference]
    if estimate is None or not limits:
        return None
    parts, lowest = {each.name: each.effect**2 for each in effects}, min(limits)
    if finding.status in ALARMS:
        own = {name: (vehicle.parameters[name].standard_deviation or 0.0) ** 2 for name in estimate.limits}
        parts, variance = parts | own, variance + sum(own.values())
    reach, names = REACH * math.sqrt(variance), _enough(parts)
    if finding.status is Status.HEALTHY and estimate.value + reach > lowest > estimate.value:
        return Turn(Status.FAULT if len(limits) == 1 else Status.RISING, names, ())
    if finding.status in ALARMS and estimate.value - reach < lowest < estimate.value:
        return Turn(Status.HEALTHY, names, ())
    return None


def _turns(conclusion: Conclusion, moved: Conclusion) -> bool:
    finding, other = conclusion.finding, moved.finding
    if finding.status in ALARMS:
        faulty = _at_fault(conclusion.elements)
        return other.status is Status.HEALTHY or (bool(faulty) and faulty.isdisjoint(_at_fault(moved.elements)))
    if finding.status is not Status.HEALTHY or other.estimate is None or not other.estimate.reference:
        return False
    return other.status in (Status.FAULT, Status.RISING)


def _alike(conclusion: Conclusion, reference: Conclusion) -> bool:
    """Whether a session that began later came to the same verdict; else it lacks the grounds of the verdict."""
    same = conclusion.finding.status is reference.finding.status
    return same and _at_fault(conclusion.elements) == _at_fault(reference.elements)


def _at_fault(elements: Sequence[Element]) -> set[str]:
    return {each.name for each in elements if each.status in ALARMS}


def _deciding(point: Concluded) -> tuple[str, ...]:
    """The parameters that make most of a move."""
    return _enough({name: by * by for name, by in point.by.items()})


def _enough(parts: Mapping[str, float]) -> tuple[str, ...]:
    """The names of the largest parts that together make most of the whole."""
    ordered = sorted(parts, key=lambda name: -parts[name])
    total, held, names = sum(parts.values()), 0.0, []
    for name in ordered[:MOST_NAMED]:
        names.append(name)
        held += parts[name]
        if held >= DECIDING * total:
            break
    return tuple(names)


def turned(conclusion: Conclusion, found: Turn, vehicle: Vehicle) -> Conclusion:
    """The conclusion where its verdict turns: an alarm is suspect, healthy is not identifiable.

    Args:
        conclusion: for the vehicle as it is
        found: for which car it turns
        vehicle: with the standard deviation of its parameters
    """
    finding = conclusion.finding
    alarm = finding.status in ALARMS
    names = in_words(found.names)
    given = "; ".join(spread_of(vehicle, name) for name in found.names)
    other = _as_found(found, finding.confirmed is not None)
    cause = f"the verdict depends on parameters of the vehicle file: within their spread ({given}) it is {other}"
    action = f"measure {names} first, enter value and standard_deviation in the vehicle file, and judge anew"
    status = Status.SUSPECT if alarm else Status.NOT_IDENTIFIABLE
    headline = finding.headline.replace(f": {finding.status},", f": {status},", 1)
    it = "it" if len(found.names) == 1 else "them"
    as_given = f"as the file gives {it} this is {finding.status}, " if headline != finding.headline else ""
    finding = replace(
        finding.after(cause, action),
        status=status,
        headline=f"{headline} But {names} {_decide(found.names)}: {as_given}within the spread this is {other}.",
    )
    return replace(
        conclusion,
        finding=finding,
        elements=_doubted(conclusion.elements, found.elements),
        baseline=None,
        course=(),
        code_courses={},
    )


def _as_found(found: Turn, estimates: bool) -> str:
    """The other verdict in words, with who is at fault where that differs; an estimate is never healthy."""
    if estimates:
        return CONSISTENT if found.status is Status.HEALTHY else INCONSISTENT
    names = tuple(sorted(each.replace("_", " ") for each in _at_fault(found.elements)))
    return f"a fault of {in_words(names)}" if names and found.status in ALARMS else str(found.status)


def _doubted(elements: tuple[Element, ...], others: tuple[Element, ...]) -> tuple[Element, ...]:
    """Elements at fault that are not at fault for the other car, as suspect."""
    faulty = {each.name for each in others if each.status is Status.FAULT}
    return tuple(
        replace(each, status=Status.SUSPECT) if each.status is Status.FAULT and each.name not in faulty else each
        for each in elements
    )


def _decide(names: tuple[str, ...]) -> str:
    return "decides" if len(names) == 1 else "decide"


def in_words(names: tuple[str, ...]) -> str:
    """Names of parameters as a part of a sentence.

    Args:
        names: at least one
    """
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def spread_of(vehicle: Vehicle, name: str) -> str:
    """A parameter with its standard deviation, in words: "rear_distance ±0.2 m".

    Args:
        vehicle: with it
        name: of the parameter
    """
    parameter = vehicle.parameters[name]
    return f"{name} ±{parameter.standard_deviation or 0.0:.3g} {written(parameter.unit)}".rstrip()


def most_important(each: ParameterEffect, vehicle: Vehicle) -> str:
    """A sentence on the parameter that moves the result most.

    Args:
        each: the parameter's effect
        vehicle: with it
    """
    return f"{spread_of(vehicle, each.name)} moves it by {moves_by(each)}; measure it first"


def moves_by(each: ParameterEffect) -> str:
    """The move of the result in words: "±2.6 degrees"."""
    factor, label = shown(each.effect_unit)
    label = " degrees" if label == "°" else f" {label}" if label else " of the threshold"
    return f"±{abs(each.effect) * factor:.2g}{label}"
