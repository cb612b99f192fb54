"""Run every monitor that can judge a recording; the others report the reason why they cannot."""

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
    """Channels that at least one monitor reads."""
    names = (name for each in MONITORS.values() for name in _signals(each))
    return ingredients(dict.fromkeys(names))


class Look(NamedTuple):
    """First piece of a recording, and whether it is the whole recording."""

    recording: Recording
    whole: bool


class Every:
    """Every monitor that can run; a monitor without a default variant only determines whether it could run.

    Args:
        car: vehicle whose parameters are used
        look: first piece of the recording; None for a pipe, which can be read only once
        spread: whether the spread of the parameters is carried into bands and verdict

    `refused` holds the reason for every monitor that does not run, by name.
    """

    def __init__(self, car: Vehicle, look: Look | None, spread: bool):
        self._car, self._look = car, look
        self.refused: dict[str, str] = {}
        names = [each.name for each in MONITORS.values() if each.default]
        self._usual = Together(car, [Chosen(name) for name in names], spread)
        for name in names:
            self._decide(name)
        self._tried = {each.name: self._trials(each) for each in MONITORS.values() if not each.default}

    def _decide(self, name: str) -> None:
        """Refuse a monitor that cannot run, or select the first of its variants that can."""
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
        # `Together` has opened it at the usual rate already; opening it again would take time.
        at_usual_rate = default.suited_to(there).rate == monitor.rate
        return any(refusals(default, None if at_usual_rate else self._car, recording, whole).values())

    def _trials(self, monitor: Monitor) -> dict[str, Together]:
        """Trial runs of a monitor without a default variant, by variant; empty where the first piece rules it out."""
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
        """Channels that at least one of the monitors reads."""
        return tuple(dict.fromkeys(name for each in self._all() for name in each.needs))

    def add(self, piece: Recording) -> None:
        """Feed the next piece of the recording to all monitors.

        Raises:
            InputError: the piece holds no samples
        """
        for each in self._all():
            each.add(piece)

    def refuse_all(self, reason: str) -> None:
        """Refuse all monitors that are still running, for one reason."""
        for name in MONITORS:
            if name not in self.refused and name not in self._usual.refused:
                self._usual.refuse(name, reason)
        self._tried = {}

    def concluded(self, command: str = "") -> Iterator[tuple[str, Concluded]]:
        """Names and conclusions of the monitors that could judge; afterwards `refused` is complete.

        Args:
            command: command line as typed by the user, for the report
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
        """Reason for a monitor without a default variant: it cannot run, or which variants the user can choose."""
        for each in trials.values():
            # Some refusals come only with the conclusion: that a signal is constant throughout shows at the end.
            list(each.concluded())
        ready = Readiness(monitor, {name: each.refused.get(monitor.name, "") for name, each in trials.items()})
        return ready.reason or f"can run{ready.choice}, with --monitor {monitor.name}"


def _signals(monitor: Monitor) -> tuple[str, ...]:
    """Signals that at least one variant of a monitor reads."""
    own = (monitor.needing(each).required for each in monitor.variants.values())
    return tuple(dict.fromkeys((*monitor.required, *(name for each in own for name in each), *monitor.optional)))
