"""One or several monitors over one recording that is read only once, from a file, a bus or a fleet."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.core import plugins as lab
from tierod.core.block import Block
from tierod.core.errors import InputError, ParameterError, nearest
from tierod.core.findings import Diagnosis
from tierod.core.recording import Recording
from tierod.monitors.acceptance import Readiness, refusals, unable
from tierod.monitors.pieces import OVERLAP, Shared, share_read
from tierod.monitors.registry import MONITORS, obstacle
from tierod.monitors.run import Run, channels_of
from tierod.monitors.session import Monitor, Variant, opened
from tierod.vehicles import Vehicle


def find(monitor: str | Monitor | Variant, variant: str | Variant | None = None) -> tuple[Monitor, Variant]:
    """Find a monitor and its variant by name; objects are checked and passed through.

    Args:
        monitor: name, a monitor, or a variant of a registered monitor
        variant: name, or a variant, which need not be one of those that the monitor lists; None takes the default of
            the monitor

    Returns:
        the monitor with the required signals of the variant, and the variant

    Raises:
        ParameterError: no such name, and the message gives the nearest; no variant given where there is no default; or
            an object lacks an attribute
    """
    if isinstance(monitor, Variant):
        variant = variant or monitor
        monitor = _monitor_of(monitor)
    definition = MONITORS.required(monitor) if isinstance(monitor, str) else monitor
    if why := obstacle(definition):
        raise ParameterError(f"the monitor '{getattr(definition, 'name', definition)}' {why}")
    chosen = variant if isinstance(variant, Variant) else _variant_of(definition, variant)
    return definition.needing(chosen), chosen


def _variant_of(monitor: Monitor, name: str | None) -> Variant:
    name = monitor.default if name is None else name
    if name is None:
        choices = " or ".join(f"'{each.name}' ({each.summary.rstrip('.')})" for each in monitor.variants.values())
        raise ParameterError(
            f"the monitor '{monitor.name}' has no default variant, since the wrong one gives a wrong verdict; "
            f"choose with --variant (in Python: variant=...) {choices}"
        )
    if name not in monitor.variants:
        more = "" if lab.installed() else f" Those of the papers are in the package {lab.PACKAGE}"
        raise ParameterError(f"'{monitor.name}' has no variant '{name}'{nearest(name, monitor.variants)}{more}")
    return monitor.variants[name]


def _monitor_of(variant: Variant) -> Monitor:
    """Registered monitor that lists this variant."""
    for monitor in MONITORS.values():
        if monitor.variants.get(variant.name) is variant:
            return monitor
    raise ParameterError(
        f"the variant '{variant.name}' belongs to no registered monitor, so its sampling rate is unknown; give "
        "monitor=tierod.Monitor(...) with it in its variants, or the name of a monitor and variant=..."
    )


@dataclass(frozen=True)
class Chosen:
    """Choice of a monitor and its variant."""

    monitor: str  # name of the monitor
    variant: str = ""  # name of the variant; "" takes the default, or the first variant whose signals the recording has

    @classmethod
    def parse(cls, text: str) -> Chosen:
        """Choice as typed by the user: "friction", or with a variant "hysteresis:hoist"."""
        monitor, _, variant = text.partition(":")
        find(monitor, variant or None)
        return cls(monitor, variant)


def usual() -> tuple[Chosen, ...]:
    """Monitors that run without an explicit request: with a default variant, and without a required condition."""
    return tuple(Chosen(name) for name, each in MONITORS.items() if each.default is not None and not each.condition)


def read_by_any() -> tuple[str, ...]:
    """Channels that at least one variant of a monitor reads."""
    variants = (each.needing(variant) for each in MONITORS.values() for variant in each.variants.values())
    return tuple(dict.fromkeys(name for each in variants for name in channels_of(each)))


@dataclass(frozen=True)
class Concluded:
    """Conclusion of a monitor on the part of a recording that it has received."""

    diagnosis: Diagnosis  # result as of `diagnose`
    variant: str  # name of the variant
    # names of the traces that the monitor computes, in contrast to the signals that it reads
    estimates: tuple[str, ...]


class Runner:
    """Monitors that receive the same pieces; a monitor that cannot run does not affect the others.

    Args:
        chosen: monitors and their variants; None takes every monitor, in the first variant that can run. One without a
            default variant then only determines whether it could run
        spread: whether the spread of the parameters is carried into bands and verdict
        signals_shown: see `Run`

    `runs` holds the runs by name of the monitor, `refused` the reason for each monitor that does not run, `span` the
    time span received so far [s], and `metadata` the metadata of the recording.
    """

    def __init__(
        self, car: Vehicle, chosen: Sequence[Chosen] | None = None, spread: bool = True, signals_shown: bool = True
    ):
        self.car, self._every = car, chosen is None
        self.runs: dict[str, Run] = {}
        self.refused: dict[str, str] = {}
        self.span: Annotated[tuple[float, float], "s"] | None = None
        self.metadata: Mapping[str, object] = {}
        self._spread, self._signals_shown = spread, signals_shown
        self._before: Recording | None = None
        self._names: frozenset[str] = frozenset()
        self._trials: dict[str, dict[str, Run]] = {}
        self._tried: dict[str, dict[str, str]] = {}
        every = [Chosen(name) for name, each in MONITORS.items() if each.default] if chosen is None else chosen
        for each in every:
            with _Refusing(self, each.monitor):
                definition, variant = find(each.monitor, each.variant or None)
                self.runs[each.monitor] = self._run(definition, variant, free=not each.variant)
        for monitor in MONITORS.values() if chosen is None else ():
            if not monitor.default:
                self._tried[monitor.name] = {}
                self._trials[monitor.name] = {
                    name: Run(monitor.needing(each), each, car, signals_shown=False)
                    for name, each in monitor.variants.items()
                }

    def _run(self, definition: Monitor, variant: Variant, free: bool = False) -> Run:
        shown = self._signals_shown
        return Run(definition, variant, self.car, free=free, uncertain=self._spread, signals_shown=shown)

    @property
    def needs(self) -> tuple[str, ...]:
        """Channels that at least one of the monitors reads."""
        if self._every:
            return read_by_any()
        return tuple(dict.fromkeys(name for run in self.runs.values() for name in run.needs))

    def blocks(self) -> Iterator[Block]:
        """Blocks of the monitors that have one, so that their kernels can be compiled before workers start."""
        for name, run in list(self.runs.items()):
            with _Refusing(self, name):
                session = opened(run.monitor, run.variant, self.car)
                if (block := getattr(session, "block", None)) is not None:
                    yield block

    def add(self, piece: Recording) -> None:
        """Feed the next piece of the recording to all monitors."""
        begin, end = piece.span
        self._names |= frozenset(piece.names)
        self.span = (begin if self.span is None else self.span[0], end)
        self.metadata = piece.metadata
        shared, self._before = Shared(self._before, piece), piece.slice(end - OVERLAP)
        for name, run in list(self.runs.items()):
            with _Refusing(self, name, piece if self._every and not run.begun else None):
                run.add(piece, shared)
        for name, trials in self._trials.items():
            for variant, run in list(trials.items()):
                try:
                    run.add(piece, shared)
                except (InputError, ParameterError) as error:
                    self._tried[name][variant] = " ".join(str(error).split())
                    del trials[variant]

    def instead(self, name: str, piece: Recording) -> str:
        """Run the first variant that can judge a recording whose first piece the default refuses; why, if none can."""
        monitor = MONITORS[name]
        ready = Readiness(monitor, refusals(monitor, self.car, piece, share_read(piece) >= 1.0))
        if ready.variants:
            variant = monitor.variants[ready.variants[0]]
            self.runs[name] = self._run(monitor.needing(variant), variant)
            with _Refusing(self, name):
                self.runs[name].add(piece)
        return ready.reason

    def concluded(self, command: str = "") -> Iterator[tuple[str, Concluded]]:
        """Names and conclusions of the monitors up to now; one that cannot conclude is refused.

        A sensor that one of them declares faulty contradicts the statements of all others that rest on it.
        """
        for name, run in list(self.runs.items()):
            with _Refusing(self, name, run.beginning if self._every else None):
                run.settle()
        ended = {}
        for name, run in list(self.runs.items()):
            with _Refusing(self, name):
                ended[name] = run.conclude()
        for name, own in ended.items():
            with _Refusing(self, name):
                run, others = self.runs[name], [each for other, each in ended.items() if other != name]
                diagnosis = run.finish(command, others, own)
                if self._every and (reason := unable(MONITORS[name], diagnosis.findings[0], self._names)):
                    self.refuse(name, reason)
                else:
                    yield name, Concluded(diagnosis, run.variant.name, tuple(run.session.traces))
        for name, trials in self._trials.items():
            self._conclude_trials(MONITORS[name], trials)

    def _conclude_trials(self, monitor: Monitor, trials: Mapping[str, Run]) -> None:
        """Keep why a monitor without a default variant does not run, or which variants the user can choose."""
        reasons = self._tried[monitor.name]
        for variant, run in trials.items():
            try:
                run.finish()
                reasons[variant] = ""
            except (InputError, ParameterError) as error:
                reasons[variant] = " ".join(str(error).split())
        ready = Readiness(monitor, {name: reasons[name] for name in monitor.variants})
        self.refused[monitor.name] = ready.reason or f"can run{ready.choice}, with --monitor {monitor.name}"

    def refuse(self, name: str, reason: str) -> None:
        """Stop a monitor and keep the reason."""
        self.runs.pop(name, None)
        self.refused[name] = reason

    def refuse_all(self, reason: str) -> None:
        """Refuse all monitors that are still running, for one reason."""
        for name in (*self.runs, *self._trials):
            self.refuse(name, reason)
        self._trials = {}


class _Refusing:
    """Context manager that turns the errors of one monitor into its refusal, or lets another variant run on a piece."""

    def __init__(self, runner: Runner, name: str, piece: Recording | None = None):
        self._runner, self._name, self._piece = runner, name, piece

    def __enter__(self) -> None:
        return None

    def __exit__(self, _: object, error: BaseException | None, __: object) -> bool:
        if not isinstance(error, InputError | ParameterError):
            return False
        first = self._runner.runs[self._name].beginning if self._name in self._runner.runs else None
        reason = str(error) if self._piece is None else self._runner.instead(self._name, first or self._piece)
        if reason:
            self._runner.refuse(self._name, " ".join(reason.split()))
        return True
