"""Several monitors over one recording that is read only once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated

from tierod.core.block import Block
from tierod.core.errors import InputError, ParameterError
from tierod.core.findings import Diagnosis
from tierod.core.recording import Recording
from tierod.monitors.diagnose import find
from tierod.monitors.harness.pieces import OVERLAP
from tierod.monitors.harness.quality_over_chunks import Shared
from tierod.monitors.registry import MONITORS
from tierod.monitors.run import Run
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Chosen:
    """Choice of a monitor and its variant.

    Args:
        monitor: name of the monitor
        variant: name of the variant; "" takes the default, or the first variant whose signals the recording has
    """

    monitor: str
    variant: str = ""

    @classmethod
    def parse(cls, text: str) -> Chosen:
        """Choice as typed by the user: "friction", or with a variant "hysteresis:hoist".

        Raises:
            ParameterError: no such monitor or variant, or no variant where there is no default
        """
        monitor, _, variant = text.partition(":")
        find(monitor, variant or None)
        return cls(monitor, variant)


def usual() -> tuple[Chosen, ...]:
    """Monitors that run without an explicit request: with a default variant, and without a required condition."""
    return tuple(Chosen(name) for name, each in MONITORS.items() if each.default is not None and not each.condition)


@dataclass(frozen=True)
class Concluded:
    """Conclusion of a monitor on the part of a recording that it has received.

    Args:
        diagnosis: result as of `diagnose`
        variant: name of the variant
        estimates: names of the traces that the monitor computes, in contrast to the signals that it reads
    """

    diagnosis: Diagnosis
    variant: str
    estimates: tuple[str, ...]


class Together:
    """Several monitors that receive the same pieces; a monitor that cannot run does not affect the others.

    Args:
        car: vehicle whose parameters are used
        chosen: monitors and their variants
        spread: whether the spread of the parameters is carried into bands and verdict
        signals_shown: see `Run`

    `refused` holds the reason for each monitor that does not run, `span` the time span received so far [s], and
    `metadata` the metadata of the recording.
    """

    def __init__(self, car: Vehicle, chosen: Sequence[Chosen], spread: bool = True, signals_shown: bool = True):
        self.car = car
        self.refused: dict[str, str] = {}
        self.span: Annotated[tuple[float, float], "s"] | None = None
        self.metadata: Mapping[str, object] = {}
        self._before: Recording | None = None
        self._runs: dict[str, Run] = {}
        self._asked: dict[str, str] = {}
        self._spread, self._signals_shown = spread, signals_shown
        for each in chosen:
            self.begin(each)

    def begin(self, chosen: Chosen) -> None:
        """Add a monitor before the first piece; this lifts the refusal of another of its variants.

        Args:
            chosen: monitor and variant
        """
        self.refused.pop(chosen.monitor, None)
        self._asked[chosen.monitor] = chosen.variant
        with self._refusing(chosen.monitor):
            definition, variant = find(chosen.monitor, chosen.variant or None)
            self._runs[chosen.monitor] = Run(
                definition, variant, self.car, uncertain=self._spread, signals_shown=self._signals_shown
            )

    @property
    def needs(self) -> tuple[str, ...]:
        """Channels that at least one of the monitors reads."""
        return tuple(dict.fromkeys(name for run in self._runs.values() for name in run.needs))

    @property
    def blocks(self) -> tuple[Block, ...]:
        """Blocks of the monitors that have one, so that their kernels can be compiled before workers start."""
        found = (getattr(run.session, "block", None) for run in self._runs.values())
        return tuple(block for block in found if block is not None)

    @property
    def running(self) -> bool:
        """Whether at least one monitor is still running."""
        return bool(self._runs)

    def add(self, piece: Recording) -> None:
        """Feed the next piece of the recording to all monitors.

        Raises:
            InputError: the piece holds no samples
        """
        begin, end = piece.span
        first = self.span is None
        self.span = (begin if self.span is None else self.span[0], end)
        self.metadata = piece.metadata
        shared, self._before = Shared(self._before, piece), piece.slice(end - OVERLAP)
        for name in list(self._runs):
            with self._refusing(name):
                if first:
                    self._runs[name] = self._runs[name].fitted(piece, bool(self._asked[name]))
                self._runs[name].add(piece, shared)

    def concluded(self, command: str = "") -> Iterator[tuple[str, Concluded]]:
        """Names and conclusions of the monitors up to now; one that cannot conclude is refused.

        A sensor that one of them declares faulty contradicts the statements of all others that rest on it.

        Args:
            command: command line as typed by the user, for the report
        """
        found = {}
        for name in list(self._runs):
            with self._refusing(name):
                found[name] = self._runs[name].conclude()
        for name, own in found.items():
            with self._refusing(name):
                run, others = self._runs[name], [each for other, each in found.items() if other != name]
                yield name, Concluded(run.finish(command, others, own), run.variant.name, tuple(run.session.traces))

    def _refusing(self, name: str) -> _Refusing:
        return _Refusing(self, name)

    def refuse(self, name: str, reason: str) -> None:
        """Stop a monitor and keep the reason."""
        self._runs.pop(name, None)
        self.refused[name] = reason

    def refuse_all(self, reason: str) -> None:
        """Refuse all monitors that are still running, for one reason."""
        for name in list(self._runs):
            self.refuse(name, reason)


class _Refusing:
    """Context manager that turns the errors of one monitor into its refusal."""

    def __init__(self, together: Together, name: str):
        self._together, self._name = together, name

    def __enter__(self) -> None:
        return None

    def __exit__(self, _: object, error: BaseException | None, __: object) -> bool:
        if not isinstance(error, InputError | ParameterError):
            return False
        self._together.refuse(self._name, " ".join(str(error).split()))
        return True
