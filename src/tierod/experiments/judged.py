"""What a monitor made of one drive, as figures that JSON and tables hold."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from tierod.experiments.figures import Moments


@dataclass(frozen=True)
class Judged:
    """What a monitor made of one drive; every figure of a campaign is made from these.

    Args:
        status: of the final finding
        headline, cause: of the final finding
        value, deviation: of the final estimate, in its unit; NaN where it is withheld
        unit: of the estimate
        ratio: to the own level at the end, NaN where the monitor has none
        outcome: of a drive with a fault: "found", "missed", "early" (an alarm stood already when the fault came) or
            "not judged"; of a sound one: "quiet", "false alarm" or "not judged"
        detection_s, detection_enabled_s: from the fault's start to the first alarm; infinite where there was none
        fault_s, fault_enabled_s: the same to the first verdict "fault"
        false_alarms: alarms that began while no fault had acted yet
        seconds, enabled_s, judged_s: of the drive, in which the monitor learnt, and in which it judged
        sound_s, sound_judged_s: before the fault; judged of these
        truth_sound, truth_faulty: mean of the truth in both phases
        errors_sound, errors_faulty: estimate less truth in both phases, settled; see `Phase`
        area: under the ROC curve between estimates before and in the fault, of this drive
        estimates_sound, estimates_faulty: settled estimates, one every few seconds
    """

    status: str
    headline: str
    cause: str
    value: float
    deviation: float
    unit: str
    ratio: float
    outcome: str
    detection_s: float
    detection_enabled_s: float
    fault_s: float
    fault_enabled_s: float
    false_alarms: int
    seconds: float
    enabled_s: float
    judged_s: float
    sound_s: float
    sound_judged_s: float
    truth_sound: float
    truth_faulty: float
    errors_sound: Moments
    errors_faulty: Moments
    area: float
    estimates_sound: tuple[float, ...]
    estimates_faulty: tuple[float, ...]


def plain(judged: Judged) -> dict[str, Any]:
    """As JSON holds it: NaN is null, infinity the text "inf"."""
    return _plain(dataclasses.asdict(judged))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(entry) for entry in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None if math.isnan(value) else "inf"
    return value


def from_plain(content: Mapping[str, Any]) -> Judged:
    """What `plain` wrote.

    Raises:
        KeyError, TypeError, ValueError: something else
    """
    values: dict[str, Any] = {}
    for field in dataclasses.fields(Judged):
        value = content[field.name]
        if field.type == "float":
            value = math.nan if value is None else float(value)
        elif field.type == "Moments":
            mean = value["mean"]
            value = Moments(int(value["count"]), math.nan if mean is None else float(mean), float(value["squares"]))
        elif field.type == "tuple[float, ...]":
            value = tuple(map(float, value))
        values[field.name] = value
    return Judged(**values)
