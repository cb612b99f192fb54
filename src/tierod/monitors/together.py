"""Several monitors over one recording, which is read once, as fleets and services run them."""

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
from tierod.monitors.harness.run import Run
from tierod.monitors.registry import MONITORS
from tierod.vehicles import Vehicle


@dataclass(frozen=True)
class Chosen:
    """A monitor that is to judge.

    Args:
        monitor: its name
        variant: its variant; the default, or what the recording has signals for, where empty
    """

    monitor: str
    variant: str = ""

    @classmethod
    def parse(cls, text: str) -> Chosen:
        """A choice as typed: "friction", or "hysteresis:hoist" with its variant.

        Raises:
            ParameterError: no such monitor or variant, or no variant where there is no default
        """
        monitor, _, variant = text.partition(":")
        find(monitor, variant or None)
        return cls(monitor, variant)


def usual() -> tuple[Chosen, ...]:
    """Every monitor that judges any recording without an explicit request."""
    return tuple(Chosen(name) for name, each in MONITORS.items() if each.default is not None and not each.condition)


@dataclass(frozen=True)
class Concluded:
    """Conclusion of a monitor up to some time of a recording.

    Args:
        diagnosis: as `diagnose` gives it
        variant: that judged
        estimates: names of the traces that the monitor made, beside the signals that it read
    """

    diagnosis: Diagnosis
    variant: str
    estimates: tuple[str, ...]


class Together:
    """Monitors that are fed the same pieces; one that cannot run leaves the others as they are.

    Args:
        car: as which the recording is judged
        chosen: the monitors
        spread: whether the spread of the parameters is carried into bands and verdict
        signals_shown: as of `Run`

    `refused` gives the reason for each monitor not run; `span` is the fed time [s]; `metadata` is of the recording.
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
        """Let a monitor judge too, before the first piece; it may have been refused as another variant.

        Args:
            chosen: the monitor
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
        """The channels that any of them reads."""
        return tuple(dict.fromkeys(name for run in self._runs.values() for name in run.needs))

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks of the monitors that run one, whose kernels are compiled before workers share them."""
        found = (getattr(run.session, "block", None) for run in self._runs.values())
        return tuple(block for block in found if block is not None)

    @property
    def running(self) -> bool:
        """Whether any monitor is still at work."""
        return bool(self._runs)

    def add(self, piece: Recording) -> None:
        """The next piece of the recording.

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
        """(monitor, finding) up to now; a monitor that finds that it cannot judge is refused.

        Args:
            command: that asked for it, for the report
        """
        for name in list(self._runs):
            with self._refusing(name):
                run = self._runs[name]
                yield name, Concluded(run.finish(command), run.variant.name, tuple(run.session.traces))

    def _refusing(self, name: str) -> _Refusing:
        return _Refusing(self, name)

    def refuse(self, name: str, reason: str) -> None:
        """Leave a monitor out from now on."""
        self._runs.pop(name, None)
        self.refused[name] = reason

    def refuse_all(self, reason: str) -> None:
        """Leave all out that are still at work."""
        for name in list(self._runs):
            self.refuse(name, reason)


class _Refusing:
    """A context in which a monitor may refuse to judge the recording."""

    def __init__(self, together: Together, name: str):
        self._together, self._name = together, name

    def __enter__(self) -> None:
        return None

    def __exit__(self, _: object, error: BaseException | None, __: object) -> bool:
        if not isinstance(error, InputError | ParameterError):
            return False
        self._together.refuse(self._name, " ".join(str(error).split()))
        return True
