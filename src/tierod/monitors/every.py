"""Every monitor that can run on a recording, by the check that an inspection makes; the others say why not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from tierod.core.recording import Recording
from tierod.io.derive import complete, ingredients
from tierod.monitors.harness.acceptance import Readiness, refusals, unable
from tierod.monitors.harness.session import Monitor
from tierod.monitors.registry import MONITORS
from tierod.monitors.together import Chosen, Concluded, Together
from tierod.vehicles import Vehicle


def read_by_any() -> tuple[str, ...]:
    """The channels that any monitor reads."""
    names = (name for each in MONITORS.values() for name in _signals(each))
    return ingredients(dict.fromkeys(names))


class Look(NamedTuple):
    """Beginning of a recording, and whether that is all of it."""

    recording: Recording
    whole: bool


class Every:
    """Every monitor that can run; those that must be chosen only find out whether they could.

    Args:
        car: as which the recording is judged
        look: at its beginning; None where it can be read only once, so that nothing is known of it
        spread: whether the spread of the parameters is carried into bands and verdict

    `refused` says why the others do not run, by monitor.
    """

    def __init__(self, car: Vehicle, look: Look | None, spread: bool):
        self._car, self._look = car, look
        self.refused: dict[str, str] = {}
        self._usual = Together(car, [Chosen(each.name) for each in MONITORS.values() if each.default], spread)
        for name in [each.name for each in MONITORS.values() if each.default]:
            self._decide(name)
        self._tried = {each.name: self._trials(each) for each in MONITORS.values() if not each.default}

    def _decide(self, name: str) -> None:
        """Leave a monitor out that cannot run, or take another of its variants."""
        monitor = MONITORS[name]
        if self._look is None or not (name in self._usual.refused or self._refuses(monitor, *self._look)):
            return
        ready = Readiness(monitor, refusals(monitor, self._car, *self._look))
        if not ready.variants:
            self._usual.refuse(name, ready.reason)
        elif ready.variants[0] != monitor.default:
            self._usual.begin(Chosen(name, ready.variants[0]))

    def _refuses(self, monitor: Monitor, recording: Recording, whole: bool) -> bool:
        """Whether the default variant, which opens at the usual rate, refuses this recording."""
        default = replace(monitor, variants={str(monitor.default): monitor.variants[str(monitor.default)]})
        there = complete(recording, [*monitor.required, *monitor.optional])
        # At the usual rate it is open already, and opening it again takes time.
        at_usual_rate = default.suited_to(there).rate == monitor.rate
        return any(refusals(default, None if at_usual_rate else self._car, recording, whole).values())

    def _trials(self, monitor: Monitor) -> dict[str, Together]:
        """Runs of a monitor that must be chosen, by variant; none where it is known already that it cannot run."""
        variants = tuple(monitor.variants)
        if self._look is not None:
            ready = Readiness(monitor, refusals(monitor, self._car, self._look.recording, whole=False))
            if not ready.variants:
                self.refused[monitor.name] = ready.reason
            variants = ready.variants
        chosen = {name: [Chosen(monitor.name, name)] for name in variants}
        return {name: Together(self._car, each, spread=False, signals_shown=False) for name, each in chosen.items()}

    def _all(self) -> tuple[Together, ...]:
        return (self._usual, *(each for trials in self._tried.values() for each in trials.values()))

    @property
    def needs(self) -> tuple[str, ...]:
        """The channels that any of them reads."""
        return tuple(dict.fromkeys(name for each in self._all() for name in each.needs))

    def add(self, piece: Recording) -> None:
        """The next piece of the recording.

        Raises:
            InputError: the piece holds no samples
        """
        for each in self._all():
            each.add(piece)

    def refuse_all(self, reason: str) -> None:
        """Leave all out that are still at work."""
        for name in MONITORS:
            if name not in self.refused and name not in self._usual.refused:
                self._usual.refuse(name, reason)
        self._tried = {}

    def concluded(self, command: str = "") -> Iterator[tuple[str, Concluded]]:
        """(monitor, finding) of those that could judge; afterwards `refused` holds why the others could not.

        Args:
            command: that asked for it, for the report
        """
        for name, found in self._usual.concluded(command):
            finding = found.diagnosis.findings[0]
            if self._look and (reason := unable(MONITORS[name], finding, self._look.recording)):
                self._usual.refuse(name, reason)
            else:
                yield name, found
        self.refused |= self._usual.refused
        for name, trials in self._tried.items():
            if name not in self.refused:
                self.refused[name] = self._of_trials(MONITORS[name], trials)

    def _of_trials(self, monitor: Monitor, trials: dict[str, Together]) -> str:
        """Why a monitor that must be chosen did not run: it cannot, or how to choose it."""
        for each in trials.values():
            list(each.concluded())
        ready = Readiness(monitor, {name: each.refused.get(monitor.name, "") for name, each in trials.items()})
        return ready.reason or f"can run{ready.choice}, with --monitor {monitor.name}"


def _signals(monitor: Monitor) -> tuple[str, ...]:
    """What any of its variants reads."""
    own = (monitor.needing(each).required for each in monitor.variants.values())
    return tuple(dict.fromkeys((*monitor.required, *(name for each in own for name in each), *monitor.optional)))
