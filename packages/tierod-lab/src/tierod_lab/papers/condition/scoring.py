"""Declarations of a diagnosis against the injected faults: accuracy, delay, isolation, kind, size, and substitutes.

A fault is observable where the log-likelihood ratio of "faulty" against "fault-free" over `ALIKE` seconds exceeds that
of three standard deviations, if the true value is known with a given accuracy: mean squared deviation / (2 known**2).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.graph import Result
from tierod.core.recording import Recording
from tierod.core.statuses import Status, code_of
from tierod.monitors.condition.kinds import KINDS
from tierod.monitors.condition.signals import ACTUATORS
from tierod.monitors.condition.signals import SENSORS as ALL_SENSORS
from tierod.vehicles import load
from tierod_lab.papers.condition.drives import ASKED, GAIN, LOSS, OUTLIER, SENSORS, STUCK, TORQUES, Drive, Injected
from tierod_lab.papers.condition.recorded import RATE, fault_free
from tierod_lab.studies.metrics import Row

ELEMENTS = (*SENSORS, *ACTUATORS)  # All judged elements

KNOWN = dict(zip(ELEMENTS, (0.015, 0.015, 0.01, 0.1, 0.35, 45.0, 0.5, 0.5, 10.0, 10.0), strict=True))
"""Standard deviation with which all other signals estimate the true value of each element [unit of the signal; N*m].

For sensors it is the accuracy required of a reconfigured value; for actuators it is assumed.
"""

ALIKE = 0.1  # Correlation time of the estimation error [s]; samples within it count as one in a log-likelihood ratio
ENOUGH = 4.5  # Log-likelihood ratio from which a fault is observable [nat]: that of three standard deviations

NAMED_AFTER = 2.0
"""Time after the declaration at which kind and size are judged [s]; at the end of a fault that is shorter."""
GRACE = 2.0
"""Time after a fault in which its declaration is no false alarm [s]; the accuracy counts it as wrong at once."""
SETTLED = 0.5  # Time after a fault is first observable before its name counts [s]
INTERVAL = 1.96  # Half width of a 95 % interval in standard deviations

NOTHING: Mapping[str, np.ndarray] = {}


class Declared(NamedTuple):
    """Declarations of a diagnosis over time; an element that a mapping lacks is never declared."""

    time: Annotated[Any, "s"]
    faulty: Mapping[str, np.ndarray]  # by element, whether it is declared faulty
    candidates: Mapping[str, np.ndarray] = NOTHING  # by element, whether it is one of several candidates for a fault
    # by element, the named kind, "" for none; valid while the element is faulty
    kind: Mapping[str, np.ndarray] = NOTHING
    size: Mapping[str, np.ndarray] = NOTHING  # by element, the named size in the unit of `Injected`; NaN for none
    value: Mapping[str, np.ndarray] = NOTHING  # by sensor, its substitute value in its unit
    deviation: Mapping[str, np.ndarray] = NOTHING  # by element, the estimated standard deviation of the size

    def since(self, place: int) -> Declared:
        """The declarations from a sample on."""
        parts = (getattr(self, name) for name in self._fields[1:])
        return Declared(self.time[place:], *({key: each[place:] for key, each in part.items()} for part in parts))

    def said(self, which: str, element: str) -> np.ndarray:
        """Flags of one element in the mapping `which`; all false for an element that it lacks."""
        found = getattr(self, which).get(element)
        return np.zeros(len(self.time), bool) if found is None else np.asarray(found, bool)


def declared_of(result: Result, time: np.ndarray) -> Declared:
    """Declarations of any variant of the monitor."""
    # The last kind, an actuator's loss of torque, is called a loss by the faults of the study.
    names = np.array(["", *KINDS[:-1], "loss"])
    status, kind, magnitude, deviation = (
        {each: result[f"statements.{each}.{part}"] for each in (*ALL_SENSORS, *ACTUATORS)}
        for part in ("status", "kind", "magnitude", "deviation")
    )
    return Declared(
        time,
        {each: codes == code_of(Status.FAULT) for each, codes in status.items()},
        {each: codes == code_of(Status.SUSPECT) for each, codes in status.items()},
        {each: names[np.rint(numbers).astype(int)] for each, numbers in kind.items()},
        magnitude,
        {each: result[f"value.{each}"] for each in ALL_SENSORS},
        deviation,
    )


def where_shown(deviation: np.ndarray, faulty: np.ndarray, known: float) -> np.ndarray:
    """Whether a fault is observable at each sample.

    Args:
        deviation: deviation of the reading or torque from the fault-free value
        known: standard deviation of the estimate of the true value, in the same unit
    """
    count = round(ALIKE * RATE)
    # Infinite deviations, of faults that always show, would make the running sums below NaN.
    power = np.where(faulty, np.clip(np.asarray(deviation, float), -1e3 * known, 1e3 * known), 0.0) ** 2
    total = np.concatenate([[0.0], np.cumsum(power)])
    past = np.minimum(np.arange(1, len(power) + 1), count)
    # Divided by the full window at the start as well, where there is less evidence.
    mean = (total[1:] - total[1 + np.arange(len(power)) - past]) / count
    enough: np.ndarray = faulty & (mean / (2.0 * known**2) >= ENOUGH)
    return enough


class Truth(NamedTuple):
    """Ground truth for a diagnosis of a drive, on the samples of its recording."""

    # by faulty element: reading less that of a fault-free sensor without noise, or commanded less delivered torque
    off: Mapping[str, np.ndarray]
    # by faulty element: fault-free reading of a sensor, or commanded torque of an actuator [N*m]
    right: Mapping[str, np.ndarray]
    known: Mapping[str, float] = KNOWN  # standard deviation of the estimate of each true value
    # the same if motion and parameters are known; empty where there is no strict score
    noise: Mapping[str, float] = {}

    def would_be_off(self, each: Injected, time: np.ndarray) -> np.ndarray:
        """Deviation by a fault at each sample if it were always present; infinite for kinds that show at any value."""
        right = self.right[each.element]
        if each.element in TORQUES:
            return np.asarray(each.size * right)
        if each.kind == LOSS:
            return right
        if each.kind == STUCK:
            return right - float(right[min(int(np.searchsorted(time, each.start)), len(right) - 1)])
        return (each.size - 1.0) * right if each.kind in (GAIN, OUTLIER) else np.full(len(time), math.inf)


def truth_of(drive: Drive, recording: Recording) -> Truth:
    """The truth of a drive of the demonstrator, with the noise of its sensors for the strict score."""
    off, right = {}, {}
    for element in (each.element for each in drive.injected):
        if element in TORQUES:
            right[element] = recording[ASKED[element]].values
            off[element] = right[element] - recording[f"truth_{TORQUES[element]}"].values
        else:
            right[element] = fault_free(element, recording, drive.driven.sensors)
            off[element] = recording[element].values - right[element]
    return Truth(off, right, noise=_noises(drive))


def _noises(drive: Drive) -> dict[str, float]:
    """Standard deviation of each true value over `ALIKE` seconds if motion and all parameters are known.

    It is a lower bound for any test: only white noise and quantisation of the sensors are left. The lost torque of a
    motor shows in the shaft torque, that of a drive in the longitudinal acceleration.
    """
    sensors, nominal = drive.driven.sensors, load("smartload")

    def noise(name: str) -> float:
        return math.hypot(sensors[name].noise, sensors[name].quantum / math.sqrt(12.0)) / math.sqrt(ALIKE * RATE)

    driven = nominal["mass"] * nominal["wheel_radius"] * noise("longitudinal_acceleration")
    known = {name: noise(name) for name in SENSORS} | dict.fromkeys(ACTUATORS[:2], noise("steering_shaft_torque"))
    return known | dict.fromkeys(ACTUATORS[2:], driven)


def faulty_times(drive: Drive, time: np.ndarray) -> dict[str, np.ndarray]:
    """Element with an injected fault -> whether it is faulty at each sample."""
    found: dict[str, np.ndarray] = {}
    for each in drive.injected:
        found[each.element] = found.get(each.element, np.zeros(len(time), bool)) | _during(each, time)
    return found


def _during(each: Injected, time: np.ndarray) -> np.ndarray:
    # The tolerance absorbs the rounding of the sampling times.
    return (time >= each.start - 1e-9) & (time < each.end - 1e-9)


def scored(drive: Drive, truth: Truth, declared: Declared) -> list[Row]:
    """One row for each injected fault, or one for a fault-free drive.

    Columns of the fault: `accuracy` by eq (53), the share of samples at which the state of the element is right;
    `observable_accuracy` without wrong samples at which the present or past fault does not change the reading;
    `outcome`, found, missed or never (never observable nor declared); `delay` from its beginning, `delay_shown` from
    where it is first observable, `delay_excited` over the time in which it is observable, `suspected` until it is
    declared or one of several candidates [s]; `strict`, `strict_delay`: the same where it counts as observable if a
    likelihood-ratio test with true parameters and motion detects it; `kind_right`, `size_error`, `covered`; `replaced`,
    the error of the substitute over the accuracy asked.

    Columns of the drive: `named`, the elements declared most of the time once all faults have been observable, and
    `isolated`, what that is; `wrong`, the share of the time with faults in which a fault-free element is declared. In
    its first row `alarms`, declarations that begin without a fault, and `hours` without one.
    """
    time = declared.time
    step = float(time[1] - time[0])
    faulty = faulty_times(drive, time)
    nothing = np.zeros(len(time), bool)
    any_fault = np.logical_or.reduce([*faulty.values(), nothing])
    said = {name: declared.said("faulty", name) for name in ELEMENTS}
    wrong = np.logical_or.reduce([flags & ~faulty.get(name, nothing) for name, flags in said.items()])
    shown = {name: where_shown(truth.off[name], there, truth.known[name]) for name, there in faulty.items()}
    named, isolated = _named(declared, shown, step)
    alarms = sum(_alarms(flags, faulty.get(name, nothing), any_fault, time) for name, flags in said.items())
    first = {"alarms": float(alarms), "hours": float(np.sum(~any_fault)) * step / 3600.0}
    whole: Row = {
        "course": drive.course,
        "vehicle": float(drive.vehicle),
        "seconds": drive.seconds,
        "faults": " + ".join(name for name in ELEMENTS if name in faulty),
        "named": named,
        "isolated": isolated,
        "right": float(isolated == "right"),
        "wrong": float(np.mean(wrong[any_fault])) if any_fault.any() else 0.0,
        "not_misled": float(isolated in ("right", "ambiguous")),
    }
    rows = [{**whole, **_of_fault(each, truth, declared, faulty, shown, step)} for each in drive.injected]
    none = {"alarms": 0.0, "hours": 0.0}
    return [{**each, **(none if place else first)} for place, each in enumerate(rows or [whole])]


def _of_fault(
    each: Injected,
    truth: Truth,
    declared: Declared,
    faulty: Mapping[str, np.ndarray],
    shown: Mapping[str, np.ndarray],
    step: float,
) -> Row:
    time, there, name = declared.time, faulty[each.element], each.element
    here, said = _during(each, time), declared.said("faulty", name)
    first = _first(said & here)
    outcome, delay, accuracy = _graded(each, truth, declared, there, truth.known, here)
    row: dict[str, float | str] = {
        "element": name,
        "kind": each.kind,
        "size": 0.0 if math.isnan(each.size) else each.size,
        "accuracy": float(np.mean(said == there)),
        "outcome": outcome,
        "missed": float(outcome == "missed"),
        "observable_accuracy": accuracy,
        "delay": math.inf if first is None else float(time[first]) - each.start,
        "delay_shown": delay,
        "suspected": _excited(shown[name] & here, _first((said | declared.said("candidates", name)) & here), step),
        "delay_excited": _excited(shown[name] & here, first, step),
        "shown": float(np.sum(shown[name] & here)) * step,
    }
    if truth.noise:
        strict, delay, _ = _graded(each, truth, declared, there, truth.noise, here)
        row |= {"strict": strict, "strict_missed": float(strict == "missed"), "strict_delay": delay}
    if first is not None and name in declared.kind:
        row |= _kind(each, declared, first, here)
    value, held = declared.value.get(name), said & here
    if value is not None and name in truth.right and held.any():
        error = (value - truth.right[name])[held]
        row["replaced"] = float(np.sqrt(np.mean(error**2))) / KNOWN[name]
    return row


def _graded(
    each: Injected, truth: Truth, declared: Declared, there: np.ndarray, known: Mapping[str, float], here: np.ndarray
) -> tuple[str, float, float]:
    """Outcome, delay from where the fault is observable (or to its end), and accuracy without unobservable samples."""
    time, said = declared.time, declared.said("faulty", each.element)
    shown = where_shown(truth.off[each.element], there, known[each.element])
    always = where_shown(truth.would_be_off(each, time), np.ones(len(time), bool), known[each.element])
    gone = (time >= each.end) & ~there
    counted = (said == there) | ~((there & ~shown) | (gone & ~always))
    first, began = _first(said & here), _first(shown & here)
    accuracy = float(np.mean((said == there)[counted]))
    if first is None:
        return "never" if began is None else "missed", math.inf, accuracy
    last = int(np.flatnonzero(here)[-1])
    return "found", float(time[first] - time[last if began is None else began]), accuracy


def _kind(each: Injected, declared: Declared, first: int, here: np.ndarray) -> dict[str, float]:
    """Whether the kind is right, the relative error of the size, and whether its interval contains the true size."""
    last = int(np.flatnonzero(here)[-1])
    at = min(int(np.searchsorted(declared.time, declared.time[first] + NAMED_AFTER)), last)
    right = bool(declared.kind[each.element][at] == each.kind)
    row = {"kind_right": float(right)}
    sizes, deviations = declared.size.get(each.element), declared.deviation.get(each.element)
    if sizes is not None and not math.isnan(each.size):
        off = float(abs(sizes[at] - each.size))
        row["size_error"] = off / abs(each.size)
        if right and deviations is not None:
            row["covered"] = float(off <= INTERVAL * deviations[at])
    return row


def _named(declared: Declared, shown: Mapping[str, np.ndarray], step: float) -> tuple[str, str]:
    """Most frequent set of declared elements once all faults have been observable, and what it is.

    The second is right, partial, wrong, ambiguous (several are candidates), nothing, or never (observable).
    """
    settled = round(SETTLED / step)
    late = np.logical_and.reduce(
        [np.r_[np.zeros(settled, bool), np.logical_or.accumulate(each)][: len(each)] for each in shown.values()]
        or [np.zeros(1, bool)]
    )
    late = late & np.logical_or.reduce([*shown.values()] or [np.zeros(1, bool)])
    if not late.any():
        return "", "never"
    flags = np.array([declared.said("faulty", element)[late] for element in ELEMENTS])
    unsure = np.logical_or.reduce([declared.said("candidates", element)[late] for element in ELEMENTS])
    # One bit per element makes sets of elements countable.
    codes = (1 << np.arange(len(ELEMENTS))) @ flags
    (code, ambiguous), _ = Counter(zip(codes.tolist(), (unsure & (codes == 0)).tolist(), strict=True)).most_common(1)[0]
    names = {element for place, element in enumerate(ELEMENTS) if code >> place & 1}
    text = " + ".join(element for element in ELEMENTS if element in names)
    if not names:
        return text, "ambiguous" if ambiguous else "nothing"
    return text, "right" if names == set(shown) else "partial" if names < set(shown) else "wrong"


def _alarms(said: np.ndarray, faulty: np.ndarray, any_fault: np.ndarray, time: np.ndarray) -> int:
    """Number of declarations that begin outside all faults, except soon after the fault of the element itself."""
    begins = said & ~np.concatenate([[False], said[:-1]])
    last = np.maximum.accumulate(np.where(faulty, time, -math.inf))
    return int(np.sum(begins & ~any_fault & (time - last > GRACE)))


def _excited(shown: np.ndarray, first: int | None, step: float) -> float:
    """Observable time before a sample [s]; infinite without that sample."""
    return math.inf if first is None else float(np.sum(shown[:first])) * step


def _first(true: np.ndarray) -> int | None:
    return int(np.argmax(true)) if true.any() else None
