"""Sensitivity of residuals to faults by their equations and as measured, and the disagreements of both."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from tierod.core.content import Table
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod_lab.papers.condition.drives import ACTUATORS, SENSORS, TARGETS, Drive
from tierod_lab.papers.condition.rules.all_residuals import AllResiduals
from tierod_lab.papers.condition.rules.fit import samples_of
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, SENSOR_RESIDUALS
from tierod_lab.papers.condition.rules.readings import Excitation
from tierod_lab.papers.condition.rules.rule_monitor import RuleMonitor

SEEN, UNSEEN = 0.05, 0.01
"""Shares of a fault's time beyond the threshold: a residual counts as sensitive from the first on, and as insensitive
up to the second [-]."""
BEHIND = {
    "steering_motor_1": "target_steering_wheel_angle",
    "steering_motor_2": "target_steering_wheel_angle",
    "drive_left": "target_vehicle_speed",
    "drive_right": "target_vehicle_speed",
}
"""Actuator -> target that it follows, beside its commanded torque."""
_FILTERED = "the two-stage filter leaves a wheel out that differs from the other"
_SCRUB = "a drive on one side alone turns the front wheels about their axes, which the equation leaves out"
ASIDE = {
    ("r1", "steering_wheel_angle"): "its filter follows the sensor that it should watch; only jumps remain",
    ("r10", "wheel_speed_rear_right"): _FILTERED,
    ("r14", "wheel_speed_rear_left"): _FILTERED,
    **{(name, drive): _SCRUB for name in ("r3", "r19") for drive in ("drive_left", "drive_right")},
}
"""Residual and element -> known reason of a disagreement; elsewhere it is the size against the threshold."""


class Seen(NamedTuple):
    """Response of a residual to a fault."""

    share: float  # share of the fault's time in which the residual is beyond its threshold [-]
    reach: float  # ratio of the residual to its threshold that is exceeded in 5 % of the fault's time [-]


Signatures = Mapping[tuple[str, str], Mapping[str, Seen]]  # Element and kind of a fault -> residual -> its response


def signatures(tests: Sequence[Drive], recordings: Sequence[Recording], monitor: RuleMonitor) -> Signatures:
    """Responses of every residual to the faults of some drives, as means by element and kind."""
    block = AllResiduals(monitor.sensors, monitor.actuators)
    thresholds = monitor.thresholds
    found: dict[tuple[str, str], list[dict[str, Seen]]] = {}
    for drive, recording in zip(tests, recordings, strict=True):
        result, fault = scan(block, samples_of(recording)), drive.injected[0]
        lively = Excitation(*(result[f"excitation.{name}"] for name in Excitation._fields))  # type: ignore[arg-type]
        time = recording["yaw_rate"].time
        during = (time >= fault.start) & (time < fault.end)
        ratios = {
            name: np.abs(threshold.ratio(result[f"residuals.{name}"], lively))[during]  # type: ignore[arg-type]  # arrays
            for name, threshold in thresholds.items()
        }
        seen = {
            name: Seen(float(np.mean(each >= 1.0)), float(np.quantile(each, 0.95))) for name, each in ratios.items()
        }
        found.setdefault((fault.element, fault.kind), []).append(seen)
    return {
        key: {name: Seen(*np.mean([each[name] for each in several], axis=0).tolist()) for name in thresholds}
        for key, several in found.items()
    }


def uses(residual: str, element: str) -> bool:
    """Whether the fault of an element enters a residual by its equation.

    The fault of a sensor enters with its reading, that of an actuator with its commanded torque or with the target that
    the actuator follows.
    """
    signals = RESIDUALS[residual].signals
    return element in signals if element in SENSORS else bool({TARGETS[element], BEHIND[element]} & set(signals))


def of_kinds(seen: Signatures) -> Table:
    """Table with the share of every fault's time in which each residual of the sensors is beyond its threshold."""
    names = tuple(each.name for each in SENSOR_RESIDUALS)
    rows = tuple(
        (f"{sensor} {kind}", *(_share(found[name].share) for name in names))
        for (sensor, kind), found in seen.items()
        if sensor in SENSORS
    )
    note = "Mean over both signs and both rounds; empty below .005."
    return Table("Share of the fault's time beyond the threshold", ("fault", *names), rows, note)


def theory_and_measurement(seen: Signatures) -> Table:
    """Table of residuals against elements: sensitivity by equation, and the largest measured share over all kinds."""
    elements = [each for each in (*SENSORS, *ACTUATORS) if any(element == each for element, _ in seen)]
    rows = tuple(
        (name, *(_cell(name, element, _largest(seen, name, element)) for element in elements)) for name in RESIDUALS
    )
    note = (
        "A number: the equation has it, and this share of the fault's time is beyond the threshold, in the kind of "
        "fault that is seen best. “unseen”: the equation has it, and less than .05 is. “!”: the equation does not have "
        "it, and yet more than .01 is. Empty: neither."
    )
    title = "Sensitivity of residuals to faults: equations and measurement"
    return Table(title, ("residual", *(each.replace("_", " ") for each in elements)), rows, note)


def disagreements(seen: Signatures) -> Table:
    """Table of residuals that are insensitive to a fault in their equation or sensitive to another, with the reason."""
    rows = tuple(_disagreements(seen)) or (("none", "", "", "", ""),)
    title = "Where equations and measurement disagree on residuals"
    return Table(title, ("residual", "fault of", "by its equation", "measured", "why"), rows)


def _disagreements(seen: Signatures) -> Iterator[tuple[str, ...]]:
    for name in RESIDUALS:
        alike: dict[tuple[str, str, str], list[str]] = {}
        for element in dict.fromkeys(element for element, _ in seen):
            best = _largest(seen, name, element)
            if uses(name, element) and best.share < SEEN:
                why = ASIDE.get((name, element), _too_small(element, best))
                alike.setdefault(("sees it", f"{best.share:.2f} of the time", why), []).append(element)
            elif not uses(name, element) and best.share > UNSEEN:
                measured = f"{best.share:.2f} of the time"
                why = ASIDE.get((name, element), "the vehicle moves otherwise, and the filters follow it too late")
                alike.setdefault(("does not", measured, why), []).append(element)
        for (theory, measured, why), elements in alike.items():
            yield name, ", ".join(elements).replace("_", " "), theory, measured, why


def _too_small(element: str, best: Seen) -> str:
    reach = f"in 5 % of the time it is beyond {best.reach:.1f} thresholds at most: "
    control = "the control makes up for what is lost" if element in ACTUATORS else "too small beside fault-free driving"
    return reach + control


def _largest(seen: Signatures, residual: str, element: str) -> Seen:
    of = [found[residual] for (name, _), found in seen.items() if name == element]
    return max(of, key=lambda each: (each.share, each.reach))


def _cell(residual: str, element: str, best: Seen) -> str:
    if uses(residual, element):
        return f"{best.share:.2f}" if best.share >= SEEN else "unseen"
    return f"! {best.share:.2f}" if best.share > UNSEEN else ""


def _share(value: float) -> str:
    return f"{value:.2f}" if value >= 0.005 else ""
