"""Session of the condition monitor: runs its block over a recording, collects its statements, and concludes."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Block
from tierod.core.findings import Status
from tierod.core.graph import Memory, Scanner
from tierod.core.recording import Aligned
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.diagnosis.switchover import SubstitutionGraph
from tierod.methods.detectors.reversing import MIRRORED, TURN_FORWARD, Reversing
from tierod.models.automated_vehicle import AutomatedVehicle
from tierod.models.single_track import RollingCar
from tierod.monitors.condition.accelerations import BOUNDS, AccelerationCheck, TargetCheck
from tierod.monitors.condition.courses import FAULT, HEALTHY, SUSPECT, ElementCourse, StatementCourse
from tierod.monitors.condition.coverage import Constancy, Coverage, ImpossibleValues, Loss, TargetPace, stuck_readings
from tierod.monitors.condition.elements import (
    AFTER,
    REVERSED,
    SLIPPED,
    WHEEL_PLACES,
    Driven,
    acceleration_elements,
    code_courses,
    elements,
    is_moving,
    losses,
    mean_speed,
)
from tierod.monitors.condition.facts import UNCALIBRATED, Found
from tierod.monitors.condition.kinds import OFFSET
from tierod.monitors.condition.reaction import EVIDENCE
from tierod.monitors.condition.rolling_checks import AxleSlip, Slip, SteeringZero, slips_in_words
from tierod.monitors.condition.signals import (
    ACCELERATIONS,
    ACTUATORS,
    ALL_WHEELS,
    DRIVES,
    ELEMENTS,
    OF_AUTOMATED,
    SENSORS,
    TARGETS,
    CarParameters,
    ConditionSample,
    limitations,
    listed,
)
from tierod.monitors.condition.wiring import ClockLeap, Problem, Wiring
from tierod.monitors.session import Conclusion
from tierod.monitors.stuck import Stuck
from tierod.vehicles import Vehicle

SLICE = 60_000  # most samples that are judged at once, so that the outputs of a long piece need not all fit into memory
ALONE = 1.5  # longest time for which an unloaded wheel spins or skids alone [s]: drivers and brake control end it
SLIPPING = 5.0
"""Longest fault of one wheel while both wheels of its axle slip [s]; one that lasts is a fault of its sensor."""
BEFORE = 1.0
"""Time before the first sign of a failing acceleration in which it may already have disturbed the filters [s]."""
TRACED = {FAULT: 1.0, SUSPECT: 0.5, HEALTHY: 0.0}
"""Values of the traces of states, by status; NaN where nothing is judged."""
NOT_TESTABLE = 0.25  # value of the traces of states for all other statuses, such as not testable


class Car(NamedTuple):
    """Car without known torques: parameters of `RollingCar`, and warnings about the limits of its judgement."""

    parameters: RollingCar.Parameters
    notes: tuple[str, ...]


class ConditionSession:
    """Runs a variant over a recording, piece by piece.

    Args:
        block: block of the variant, whose output is a `ConditionOutput`
        graph: graph of the substitutes that the block supplies
        calibrated: whether the limits were designed on this individual vehicle
        decision: name of the decision that declares a fault
        multiples: smallest lasting change of each element that is seen, in standard deviations; empty states none
        car: car without known torques; None if the vehicle file describes the whole vehicle
    """

    def __init__(
        self,
        name: str,
        block: Block,
        graph: SubstitutionGraph,
        vehicle: Vehicle,
        rate: float,
        calibrated: bool,
        decision: str,
        multiples: Mapping[str, float],
        car: Car | None = None,
    ):
        self.name, self.block, self.vehicle, self.rate, self.calibrated = name, block, vehicle, rate, calibrated
        self.signals: tuple[str, ...] = ConditionSample._fields
        self.decision, self.graph, self.multiples = decision, graph, multiples
        self._elements = (*OF_AUTOMATED, *ACTUATORS) if car is None else ELEMENTS
        self._measured = (*(name for name in self._elements if name in SENSORS), *ACCELERATIONS)
        self.traces: Mapping[str, str] = {
            EVIDENCE: "",
            **{f"state_of_{each}": "" for each in self._elements},
            **{f"supplied_{each}": SIGNALS[each].unit for each in graph.sensors},
            **{f"deviation_of_supplied_{each}": SIGNALS[each].unit for each in graph.sensors},
        }
        self._car, whole = car, vehicle.parameters_for(AutomatedVehicle.Parameters) if car is None else None
        p: CarParameters = whole or car.parameters  # type: ignore[union-attr]
        self._wiring = Wiring(p, rate, calibrated)
        self._leap = ClockLeap(Wiring(p, rate, calibrated))
        self._coverage = Coverage(rate, asked=car is None)
        self._driven = Driven(1.0 / rate, asked=car is None)
        self._pace = TargetPace(rate) if whole is not None else None
        self._asked = TargetCheck(whole, rate) if whole is not None else None
        # The bank of a whole vehicle detects slow offsets itself; that of a car absorbs them as a state.
        self._zero = SteeringZero(car.parameters, rate) if car is not None else None
        self._slip = AxleSlip() if car is not None else None
        wheelbase = p.front_distance + p.rear_distance
        self._reversing = Reversing(rate, p.steering_ratio, wheelbase) if car is not None else None
        self._impossible, self._accelerations = ImpossibleValues(rate), AccelerationCheck(p, rate)
        self._read = np.zeros(len(self._measured), bool)
        self.stuck: tuple[Stuck, ...] = ()
        # Driver and road let a coarse steering angle repeat itself for ten seconds, but no noisy yaw rate or wheel.
        self._same = {"yaw_rate": Constancy(1.0 / rate)}
        self._same |= {name: Constancy(1.0 / rate, noisy=True) for name in ALL_WHEELS if name in self._measured}
        self._steers = p.steering_ratio / wheelbase
        self._courses = {each: ElementCourse(each, 1.0 / rate) for each in self._elements}
        self._anew = False
        self._memory: Memory | None = None
        self._steps = 0
        self._scanner: Scanner[Any, Any, Any] | None = None

    def refuse(self, aligned: Aligned) -> None:
        """Refuse nothing: the finding states what cannot be judged."""

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        time, values = aligned.time, aligned.values.copy()
        self._read |= np.isfinite(values[:, [self.signals.index(name) for name in self._measured]]).any(axis=0)
        # Sensors that the model of this vehicle does not have must not count for the coverage.
        values[:, [self.signals.index(name) for name in SENSORS if name not in self._measured]] = np.nan
        values, covered = self._coverage.add(self._impossible.add(values))
        reverses = self._sign_speeds(time, values)
        self._wiring.add(self._columns(values))
        self._driven.add(time, values, covered)
        self._follow_constant(aligned, is_moving(values))
        self._driven.leave_out(REVERSED, reverses & covered.judged)
        if self._pace is not None:
            self._pace.add(values)
        slips = np.zeros(len(time), bool)
        if self._slip is not None:
            slips = self._slip.add(time, values[:, WHEEL_PLACES])
            values[np.ix_(slips, WHEEL_PLACES)] = np.nan
        self._driven.leave_out(SLIPPED, slips & covered.judged & ~reverses)
        failures = self._drop_failed_accelerations(time, values)
        for check in (self._asked, self._zero):
            if check is not None:
                check.add(time, self._columns(values))
        # With too few sensors for any declaration the filters are not run: they take seconds to compile.
        watched = covered.judged & covered.enough & ~reverses & ~slips
        changes = (np.flatnonzero(np.diff(watched)) + 1).tolist()
        # An acceleration that fails with the last sample restarts the filters with the next piece.
        begins, self._anew = failures | ({0} if self._anew else set()), len(values) in failures
        starts = sorted({0, *changes, *(begins - {len(values)}), *range(0, len(values), SLICE)})
        parts = []
        for start, stop in zip(starts, [*starts[1:], len(values)], strict=True):
            part = slice(start, stop)
            piece = Aligned(time[part], values[part], aligned.names)
            parts.append(self._part(piece, covered.available[part], bool(watched[start]), start in begins))
        return {name: np.concatenate([part[name] for part in parts]) for name in self.traces}

    def _columns(self, values: np.ndarray) -> dict[str, np.ndarray]:
        return dict(zip(self.signals, values.T, strict=True))

    def _follow_constant(self, aligned: Aligned, moving: np.ndarray) -> None:
        readings, speed = self._columns(aligned.values), mean_speed(aligned.values)
        for name, same in self._same.items():
            others = self._steers * readings["steering_wheel_angle"] * speed if name == "yaw_rate" else speed
            same.add(aligned.time, readings[name], moving, others)

    def _sign_speeds(self, time: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Give wheel speeds a negative sign where the car is known to reverse; returns where, (n,)."""
        if self._reversing is None or not len(time):
            return np.zeros(len(time), bool)
        wheels, read = values[:, WHEEL_PLACES], self._columns(values)
        apart = wheels[:, 1] - wheels[:, 0]
        reverses = self._reversing.add(time, read["yaw_rate"], read["steering_wheel_angle"], mean_speed(values), apart)
        values[np.ix_(reverses, WHEEL_PLACES)] = -np.abs(wheels[reverses])
        return reverses

    def _drop_failed_accelerations(self, time: np.ndarray, values: np.ndarray) -> set[int]:
        """Remove failed accelerations; returns the samples from which one is left out."""
        gone = [name for name in ACCELERATIONS if self._accelerations.gone(name)]
        failed = self._accelerations.add(time, self._columns(values))
        for name, first in {**dict.fromkeys(gone, 0), **failed}.items():
            values[first:, self.signals.index(name)] = np.nan
        return {*failed.values()}

    def _part(self, aligned: Aligned, available: np.ndarray, judged: bool, anew: bool) -> dict[str, np.ndarray]:
        """Traces of samples that are either all judged or all not; without a judgement the filters restart afterwards.

        They also restart when an acceleration fails, which they have used until then. While nothing is judged no
        reading is trusted, and no signal is supplied.
        """
        if anew or not judged:
            self._memory, self._steps = None, 0
        count = len(aligned.time)
        stated, states = StatementCourse.unjudged(count), np.full((count, len(ELEMENTS)), np.nan)
        supplied = {name: states[:, 0] for name in self.traces if "supplied_" in name}
        # Missing wheel speeds are no evidence of a standstill.
        moving = is_moving(aligned.values) | np.isnan(aligned.values[:, WHEEL_PLACES]).all(axis=1)
        if judged:
            self._scanner = self._scanner or Scanner(self.block)
            result = self._scanner.scan(aligned, self._memory)
            self._memory = result.state
            stated = StatementCourse.of(result, aligned.time, np.arange(self._steps, self._steps + count) / self.rate)
            self._steps += count
            supplied = {
                f"{before}supplied_{name}": result[f"supplied.{name}.{part}"]
                for before, part in (("", "value"), ("deviation_of_", "deviation"))
                for name in self.graph.sensors
            }
            self._driven.add_sources(result, self.graph)
        stated = stated.where_available(available, moving)
        if judged:
            states = np.select([stated.status == code for code in TRACED], list(TRACED.values()), NOT_TESTABLE)
        for name, course in self._courses.items():
            course.add(aligned.time, stated, available[:, ELEMENTS.index(name)])
        self._driven.add_low_grip(aligned.time, stated.low_grip, aligned.values)
        self._leap.add(aligned.time, aligned.columns, stated.status == FAULT)
        return {
            EVIDENCE: stated.lead,
            **{f"state_of_{name}": states[:, place] for place, name in enumerate(ELEMENTS) if name in self._courses},
            **supplied,
        }

    def conclude(self) -> Conclusion:
        end, slipped = self._driven.end, () if self._slip is None else self._slip.found
        # In a slide the lateral acceleration is not that of the turn, so that a disagreement is no fault.
        disagreeing = {
            name: each
            for name, each in self._accelerations.found.items()
            if self._car is None or not self._slid_within(each.window - BEFORE, each.found, slipped)
        }
        turned = () if self._reversing is None else tuple(self._reversing.found)
        self._withdraw(
            [
                *((each.window - BEFORE, each.found) for each in disagreeing.values() if each.sure),
                # Until it was known that the car reversed, the filters took it for driving forward.
                *((each.start, each.found) for each in turned),
                # The filters took the beginning of a slip, which is smaller, for a fault.
                *((each.start - BEFORE, each.end) for each in slipped),
            ]
        )
        stuck, beside = self._stuck_readings()
        slid, shifted = self._slipped_wheels(), self._shift_of_zero()
        problems = self._problems()
        same = {name: loss for name, each in self._same.items() if (loss := each.loss()) is not None}
        # What stood still comes first: of causes at the same time the first one is named.
        lost = stuck | slid | beside | stuck | same | losses(self._courses, self._driven)
        states = elements(self._courses, self._driven, problems, self.graph, lost, self.multiples)
        if not problems:
            states = (*states, *acceleration_elements(disagreeing))
        found = Found(
            *(self.name, states, self._driven, self.decision, problems, lost, disagreeing, self._not_done()),
            *(shifted, self._coverage.interruptions, self._notes(bool(problems), slipped)),
        )
        own = {each.name for each in states if each.name in self.graph.sensors and not each.substitute}
        withheld = tuple(f"{what}{name}" for name in sorted(own) for what in ("supplied_", "deviation_of_supplied_"))
        # Wrong wiring is no fault of an element and must not enter a fault memory.
        courses = {} if problems else code_courses(self._courses, end)
        return Conclusion(found.verdict(), elements=states, code_courses=courses, withheld=withheld)

    def _problems(self) -> tuple[Problem, ...]:
        """Wrong wiring, scale or time of signals, and targets that come too rarely."""
        faults = [each for course in self._courses.values() for each in course.episodes(self._driven.end)]
        mirrored = self._reversing is not None and self._reversing.mirrored
        wired = (
            self._impossible.problems(self._measured)
            or self._wiring.problems()
            or ((Problem("sign", ("yaw_rate",), MIRRORED, TURN_FORWARD),) if mirrored else ())
            or self._late()
            or self._leap.problems([each for each in faults if not each.candidates])
        )
        return (*wired, *(() if self._pace is None else self._pace.problems()))

    def _late(self) -> tuple[Problem, ...]:
        """Problem that the longitudinal acceleration is late, where drives alone are suspected; empty if not."""
        suspected = {name for name, course in self._courses.items() if course.episodes(self._driven.end)}
        late = self._accelerations.late if suspected and suspected <= {*DRIVES} else None
        if late is None:
            return ()
        cause = f"longitudinal acceleration: {late:.2f} s late relative to the wheel speeds, so that drives look faulty"
        return (Problem("time", DRIVES, cause, "check the time stamps of the longitudinal acceleration"),)

    def _not_done(self) -> tuple[tuple[str, ...], ...]:
        """Inconsistent pairs of targets, without those of the drives if their reference acceleration has failed."""
        blind = self._accelerations.gone("longitudinal_acceleration")
        found = () if self._asked is None else self._asked.found
        return tuple(each for each in found if not (blind and each == TARGETS[2:]))

    def _slid_within(self, start: float, end: float, slipped: Iterable[Slip]) -> bool:
        """Whether the tyres slid at any time between two times [s], in a turn or with both wheels of an axle."""
        beside = any(each.start - BEFORE <= end and each.end >= start for each in slipped)
        return beside or self._driven.slid_within(start, end)

    def _stuck_readings(self) -> tuple[dict[str, Loss], dict[str, Loss]]:
        """Readings that stayed the same, and other elements whose faults they had caused, which are withdrawn."""
        stuck = stuck_readings(self.stuck)
        resting = [each for each in self.stuck if each.name in stuck]
        ends = [self._driven.end if each.end is None else each.end + BEFORE for each in resting]
        # A reading that stays the same in bends looks like a fault of the sensors that move.
        return stuck, self._withdraw([(each.start, end) for each, end in zip(resting, ends, strict=True)], stuck)

    def _slipped_wheels(self) -> dict[str, Loss]:
        """Withdraw brief faults of single wheels that slipped alone when pushed, or together with their axle."""
        found: dict[str, Loss] = {}
        slipped: list[tuple[float, float]] = []
        for axle, times in self._slip.alike.items() if self._slip is not None else ():
            together = [(start - BEFORE, end, 0.0) for start, end in times]
            with_axle = f"both wheels of the {axle} axle slipped, or two readings were wrong,"
            wheels = [name for name in ALL_WHEELS if axle in name and name in self._courses]
            pushed = "the wheel slipped alone, or its reading was wrong,"
            rules = (
                (SLIPPING, together, with_axle, ""),
                (ALONE, self._driven.pushed, pushed, " of hard acceleration or braking"),
            )
            for name, (longest, spans, who, when) in product(wheels, rules):
                for each in self._courses[name].brief(longest, spans, wheels):
                    cause = f"{who} from {each.onset:.2f} s to {each.supported:.2f} s{when}"
                    found.setdefault(name, Loss(Status.NOT_TESTABLE, cause, each.onset, each.supported))
                    slipped.append((each.onset, max(each.start, each.supported) + AFTER))
        self._withdraw(slipped)
        return found

    def _shift_of_zero(self) -> tuple[str, ...]:
        """Declare what has shifted the zero of the steering angle, unless the filters had declared anything by then."""
        shift, end = self._zero.found if self._zero is not None else None, self._driven.end
        declared = [each for course in self._courses.values() for each in course.episodes(end)]
        if shift is None or any(each.declared_at <= shift.found for each in declared):
            return ()
        span, size = (shift.start, shift.found, end if shift.end is None else shift.end), (shift.value, shift.deviation)
        for name in shift.suspects:
            self._courses[name].declare(span, OFFSET, size, {*shift.suspects} - {name})
        return shift.suspects

    def _withdraw(self, spans: Iterable[tuple[float, float]], but: Collection[str] = ()) -> dict[str, Loss]:
        """Withdraw what was declared in times [s] in which an input of the filters or their model was wrong.

        Returns the elements of which a fault was withdrawn, as not testable; `but` are the elements that explain it.
        """
        found: dict[str, Loss] = {}
        for start, end in spans:
            for name in self._courses.keys() - {*but}:
                if self._courses[name].forget(start, end):
                    cause = f"a sensor that stood still contradicted it from {start:.2f} s to {end:.2f} s"
                    found.setdefault(name, Loss(Status.NOT_TESTABLE, cause, start, end))
        return found

    def _notes(self, wired: bool, slipped: Collection[Slip]) -> tuple[str, ...]:
        """Remarks on what cannot be judged with the sensors that are read, on the accelerations, and on the drive."""
        notes = [] if self.calibrated or self._car is not None else [UNCALIBRATED]
        notes += () if self._car is None else self._car.notes
        missing = [name for name, read in zip(self._measured, self._read, strict=True) if not read]
        # Without any reading, or with all sensors, isolability needs no note.
        notes += limitations(self.vehicle, missing) if missing and self._read.any() else ()
        if (checked := [name for name in ACCELERATIONS if name not in missing]) and not wired:
            bound = in_words(BOUNDS.level, "m/s**2")
            notes.append(f"{listed(checked)}: compared with the motion only, an offset below {bound} is not seen")
        notes += (each for each in (getattr(self._reversing, "words", ""), slips_in_words(tuple(slipped))) if each)
        return (*notes, *self._impossible.notes())
