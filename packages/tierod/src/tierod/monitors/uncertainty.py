"""Effects of a vehicle's uncertain parameters on one monitor: every parameter is a lane beside the vehicle of the file.

A lane is a session of the monitor for a vehicle with one parameter in error: by one standard deviation or, where the
monitor accuses sensors, by two to either side, since a fault may be explained by one side alone. It runs over all
samples of the recording, on the slowest grid that the monitor accepts: differences between vehicles are smooth. There
its results are compared with those of a reference lane for the unperturbed vehicle. The parameters are independent, so
the variance that they add to a result is the sum of the squared differences. Nothing depends on how a recording is cut.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from typing import NamedTuple, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np

from tierod.core.errors import TierodError
from tierod.core.findings import Estimate
from tierod.core.graph.runtime import FEWEST, SideBySide
from tierod.core.graph.trace import LANES, Interface
from tierod.core.recording import Aligned
from tierod.monitors.baseline import Baseline
from tierod.monitors.decision import Decision
from tierod.monitors.session import BlockSession, Conclusion, Monitor, Session, Variant, opened
from tierod.vehicles.classes import BOUND, FREE, WatchedParameters, bound_distance, may_move, moved, with_spread
from tierod.vehicles.vehicle import Vehicle

REFUSALS = (TierodError, ArithmeticError, np.linalg.LinAlgError)
"""Exceptions by which a monitor refuses to run with a vehicle."""

Lane: TypeAlias = tuple[str, float]  # Parameter, and its error in standard deviations

REFERENCE: Lane = ("", 0.0)  # Lane for the unperturbed vehicle

ONE_SIDE, BOTH_SIDES = (1.0,), (2.0, -2.0)  # Errors of a parameter in its lanes, in standard deviations [-]

AFTER, BEFORE = "_standard_deviation", "deviation_of_"
"""A trace is a result with a band where another one has its name with one of these around it."""

SMALLEST = 0.1
"""Least change of a result for a parameter to count, in standard deviations of the result [-]: less adds half a per
cent to the band."""

ABREAST_FROM, AT_ONCE = 400_000, 2_000
"""Steps of lanes in this process from which they run in one kernel, and least samples of a piece for that: another
kernel must be compiled, which a short recording or a live drive must not wait for. No result depends on them."""

_STEPS: WeakKeyDictionary[Interface, int] = WeakKeyDictionary()
"""Steps of lanes in this process so far, by the graph of their block."""


class Main(NamedTuple):
    """Result on which the effect of every parameter is measured."""

    value: str  # name of its trace
    # name of the trace with its standard deviation; "" for a statistic that is compared with a threshold
    deviation: str
    level: float  # magnitude of that threshold; 0 for a result with a standard deviation
    unit: str  # unit of an effect; "" for one in multiples of the threshold

    @classmethod
    def of(cls, session: Session, decisions: Iterable[Decision]) -> Main | None:
        """First result of a session with a band, or else the statistic of its first decision; None without either."""
        for name, unit in session.traces.items():
            if f"{name}{AFTER}" in session.traces:
                return cls(name, f"{name}{AFTER}", 0.0, unit)
        for each in decisions:
            level = abs(each.levels[0]) if each.levels and each.statistic in session.traces else 0.0
            if 0.0 < level < math.inf:
                return cls(each.statistic, "", level, "")
        return None

    def scale(self, traces: Mapping[str, np.ndarray]) -> np.ndarray:
        """Own standard deviation of the result, or its threshold, (n,); NaN where there is no result."""
        value = traces[self.value]
        scale = traces[self.deviation] if self.deviation else np.full(len(value), self.level)
        enabled = traces["enabled"] > 0.5 if "enabled" in traces else np.ones(len(value), bool)
        return np.where(enabled & np.isfinite(value) & (scale > 0.0), scale, np.nan)


class Effects(NamedTuple):
    """What the lanes show over a recording."""

    # conclusion for each perturbed vehicle whose main result changes, by name of the parameter
    lanes: Mapping[Lane, Conclusion]
    # conclusion for the unperturbed vehicle on the grid of the lanes; None where it is that of the monitor
    reference: Conclusion | None
    sizes: Mapping[str, float]  # root mean square of the change of the main result, by name of the parameter [unit]
    # root mean square of the result's own standard deviation; 1 for a result in multiples of a threshold [unit]
    own: float
    unit: str | None  # unit of the main result; None without one
    # share of the samples with a recorded true value that the wider band contains; None without true values
    within: float | None


class Uncertain:
    """Opens the session of a monitor for a vehicle, and determines which uncertain parameters it reads.

    Limits of the vehicle file that were designed on its own fault-free drives already contain the error of its
    parameters: a monitor with such limits has no lanes. Neither has a parameter whose spread the monitor includes in
    its own band (`tierod.vehicles.classes.held_deviation`).

    Args:
        vehicle: vehicle of the file; parameters without a standard deviation get that of their class
        baseline: baseline from earlier recordings; None without one

    Raises:
        ParameterError: the variant cannot run with this vehicle

    `session` is the session for the unperturbed vehicle, `names` are the uncertain parameters, and `of_class` those of
    them with the spread of their class.
    """

    def __init__(self, monitor: Monitor, variant: Variant, vehicle: Vehicle, baseline: Baseline | None):
        self.monitor, self.variant, self.baseline = monitor, variant, baseline
        watched = WatchedParameters(vehicle.parameters)
        self.session = opened(monitor, variant, dataclasses.replace(vehicle, parameters=watched), baseline)
        self.vehicle, filled = with_spread(vehicle)
        read = () if monitor.name in vehicle.thresholds else watched.read
        held = watched.held.keys() | ({BOUND} if bound_distance(self.vehicle) and FREE in read else set())
        self.names = tuple(
            name
            for name in read
            if name not in held and may_move(name) and self.vehicle.parameters[name].standard_deviation
        )
        self.of_class = tuple(name for name in filled if name in self.names)

    def lanes(self) -> Lanes | None:
        """Lanes for a recording; None if the monitor reads no uncertain parameter."""
        return Lanes(self) if self.names else None


class Lanes:
    """Sessions for the perturbed vehicles, beside the session for the unperturbed one."""

    def __init__(self, uncertain: Uncertain):
        self._session, self._vehicle = uncertain.session, uncertain.vehicle
        self._main = Main.of(self._session, uncertain.variant.decisions)
        names = self._session.traces
        self._bands = {name: f"{name}{AFTER}" for name in names if f"{name}{AFTER}" in names}
        self._bands |= {name: f"{BEFORE}{name}" for name in names if f"{BEFORE}{name}" in names}
        monitor = uncertain.monitor
        self._every = max(int(monitor.rate / (monitor.lane_rate or (monitor.rate, *monitor.slower)[-1]) + 1e-6), 1)
        self._sides = BOTH_SIDES if monitor.subjects else ONE_SIDE
        self._running = self._opened(uncertain)
        while REFERENCE not in self._running and self._every > 1:  # too slow for this vehicle
            self._every //= 2
            self._running = self._opened(uncertain)
        self._abreast = SideBySide()
        self._seen = 0
        self._variance = dict.fromkeys(self._bands, 0.0)
        # Sums of squares: of the changes by each parameter, and of the result's own deviation.
        self._sums, self._known = np.zeros(len(uncertain.names) + 1), 0
        self._names = uncertain.names
        self._within = self._compared = 0

    def _opened(self, uncertain: Uncertain) -> dict[Lane, Session]:
        """Sessions by lane, without those that the monitor refuses."""
        monitor = dataclasses.replace(uncertain.monitor, rate=uncertain.monitor.rate / self._every)
        wanted = [(name, side) for side in self._sides for name in uncertain.names]
        main = () if self._main is None else (self._main.value, self._main.deviation, "enabled")
        compared, lanes = {*self._bands, *main}, dict[Lane, Session]()
        for lane in wanted if self._every == 1 else (REFERENCE, *wanted):
            vehicle = self._vehicle if lane == REFERENCE else moved(self._vehicle, dict((lane,)))
            with suppress(*REFUSALS):
                lanes[lane] = session = opened(monitor, uncertain.variant, vehicle, uncertain.baseline)
                if isinstance(session, BlockSession):
                    session.beside(compared)
        return lanes

    def absorb(self, aligned: Aligned, shown: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Process one more piece and return its traces with wider bands."""
        if not self._seen and isinstance(self._session, BlockSession) and self._session.fitted is not None:
            self._fit(self._session.fitted)
        first = -self._seen % self._every
        self._seen += len(aligned.time)
        samples = Aligned(aligned.time[first :: self._every], aligned.values[first :: self._every], aligned.names)
        traces = dict(self._absorbed(samples)) if len(samples.time) else {}
        reference = shown if self._every == 1 else traces.pop(REFERENCE, None)
        changes = {} if reference is None else self._changes(reference, traces)
        places = (np.arange(len(aligned.time)) - first) // self._every + 1
        wide = dict(shown)
        for value, band in self._bands.items():
            variance = sum((each**2 for each in changes.get(value, ())), np.zeros(len(samples.time)))
            held = np.append(self._variance[value], variance)
            self._variance[value] = held[-1]
            wide[band] = np.sqrt(shown[band] ** 2 + held[places])
        self._compare(wide)
        return wide

    def _fit(self, fitted: object) -> None:
        """Fit the lanes to the data that the unperturbed session was fitted to: only parameters may differ."""
        for name, session in list(self._running.items()):
            del self._running[name]
            with suppress(*REFUSALS):
                assert isinstance(session, BlockSession)
                session.refit(fitted)
                self._running[name] = session

    def _absorbed(self, samples: Aligned) -> Iterator[tuple[Lane, Mapping[str, np.ndarray]]]:
        """Traces of every lane over a piece; a lane that the monitor refuses ends."""
        groups: dict[object, list[Lane]] = {}
        for name, session in self._running.items():
            graph = session.stepped if isinstance(session, BlockSession) and len(samples.time) >= AT_ONCE else None
            if graph is not None:
                _STEPS[graph] = _STEPS.get(graph, 0) + len(samples.time)
            groups.setdefault(name if graph is None or _STEPS[graph] < ABREAST_FROM else graph, []).append(name)
        for names in groups.values():
            for at in range(0, len(names), LANES):
                part = {name: self._running.pop(name) for name in names[at : at + LANES]}
                run = self._in_one_kernel if len(part) >= FEWEST else _one_by_one
                for name, traces in run(part, samples):
                    self._running[name] = part[name]
                    yield name, traces

    def _in_one_kernel(
        self, lanes: Mapping[Lane, Session], samples: Aligned
    ) -> Iterator[tuple[Lane, Mapping[str, np.ndarray]]]:
        """Run lanes side by side; the result is that of `_one_by_one`, to the last bit."""
        ready: dict[Lane, tuple[BlockSession, Aligned]] = {}
        for name, session in lanes.items():
            assert isinstance(session, BlockSession)
            with suppress(*REFUSALS):
                ready[name] = session, session.prepared(samples)
        sessions, given = [each for each, _ in ready.values()], [each for _, each in ready.values()]
        results = self._abreast.scan([each.block for each in sessions], given, [each.memory for each in sessions])
        for (name, (session, piece)), result in zip(ready.items(), results, strict=True):
            with suppress(*REFUSALS):
                yield name, session.taken(piece, result)

    def _changes(
        self, reference: Mapping[str, np.ndarray], traces: Mapping[Lane, Mapping[str, np.ndarray]]
    ) -> dict[str, list[np.ndarray]]:
        """Change of every result by each parameter, (n,) each; 0 where a result or a lane is missing."""
        results = dict.fromkeys((*self._bands, *((self._main.value,) if self._main else ())))
        changes = {
            result: [
                per_deviation(
                    {side: traces[name, side][result] for side in self._sides if (name, side) in traces}, base
                )
                for name in self._names
            ]
            for result, base in ((each, reference[each]) for each in results)
        }
        if self._main is not None:
            scale = self._main.scale(reference)
            known = np.isfinite(scale)
            squares = np.array([*changes[self._main.value], scale])[:, known] ** 2
            # One after the other, so that no cut of the recording changes the sum.
            self._sums = np.add.accumulate(np.column_stack([self._sums, squares]), axis=1)[:, -1]
            self._known += int(known.sum())
        return changes

    def _compare(self, wide: Mapping[str, np.ndarray]) -> None:
        """Count how often the wider band of the main result contains its true value."""
        if self._main is None or f"true_{self._main.value}" not in wide or not self._main.deviation:
            return
        error = np.abs(wide[self._main.value] - wide[f"true_{self._main.value}"])
        deviation = wide[self._main.deviation]
        self._compared += int(np.sum(np.isfinite(error) & np.isfinite(deviation)))
        self._within += int(np.sum(error <= 1.96 * deviation))

    def conclude(self, estimate: Estimate | None = None) -> Effects:
        """What the lanes show over all pieces, beside the estimate for the unperturbed vehicle."""
        main = self._main
        found = np.sqrt(self._sums / max(self._known, 1)) / ((main.level if main else 0.0) or 1.0)
        own, sizes = float(found[-1]), dict(zip(self._names, found.tolist(), strict=False))
        same = main is not None and estimate is not None and estimate.unit == main.unit
        least = SMALLEST * min(own, estimate.standard_deviation if same and estimate else own)
        concluded: dict[Lane, Conclusion] = {}
        for lane, session in self._running.items():
            # Some conclusions take a tenth of a second: a lane without an effect on the result needs none.
            if main is None or not sizes.get(lane[0], math.inf) < least:
                with suppress(*REFUSALS):
                    concluded[lane] = session.conclude()
        reference = concluded.pop(REFERENCE, None)
        if reference is None and self._every > 1:
            concluded = {}
        return Effects(
            concluded,
            reference,
            sizes,
            own,
            main.unit if main else None,
            self._within / self._compared if self._compared else None,
        )


def per_deviation(sides: Mapping[float, np.ndarray], base: np.ndarray) -> np.ndarray:
    """Size of the change of a result by one standard deviation of a parameter; 0 without results to compare.

    It is the root mean square of the sides: a change of either side to the same direction must not cancel.

    Args:
        sides: result by the error of the parameter in standard deviations, (n,) each
        base: result for the unperturbed vehicle, (n,)
    """
    squares, count = np.zeros(np.shape(base)), np.zeros(np.shape(base))
    for side, each in sides.items():
        slope = (each - base) / side
        known = np.isfinite(slope)
        squares, count = squares + np.where(known, slope, 0.0) ** 2, count + known
    return np.sqrt(squares / np.maximum(count, 1.0))


def _one_by_one(lanes: Mapping[Lane, Session], samples: Aligned) -> Iterator[tuple[Lane, Mapping[str, np.ndarray]]]:
    for name, session in lanes.items():
        with suppress(*REFUSALS):
            yield name, session.absorb(samples)
