"""Subject of an export: a monitor as a block for one vehicle, with descriptions of inputs, outputs and parameters."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import Any

from tierod.core.block import Ring, tuning, values_of
from tierod.core.errors import ParameterError
from tierod.core.graph import trace
from tierod.core.graph.state import BankState
from tierod.core.version import __version__
from tierod.export.described import Described, described, of_signals
from tierod.export.members import identifier
from tierod.monitors.diagnose import find, usual_monitor
from tierod.monitors.harness.session import opened
from tierod.monitors.registry import MONITORS
from tierod.vehicles import Vehicle, load


@dataclass(frozen=True)
class Subject:
    """A monitor for one vehicle.

    Args:
        name: C identifier with which all names begin, without "tierod_"
        vehicle: name of the vehicle whose parameters are used
        rate: sampling rate [Hz]
        sample, state, output, tuning: descriptions of all numbers, in the order of the graph; for a bank the states of
            its judge
    """

    name: str
    title: str
    monitor: str
    variant: str
    vehicle: str
    rate: float
    block: Any
    graph: Any
    sample: tuple[Described, ...]
    state: tuple[Described, ...]
    output: tuple[Described, ...]
    tuning: tuple[Described, ...]
    values: tuple[float, ...]

    @property
    def sample_time(self) -> float:
        """Sampling interval [s]."""
        return 1.0 / self.rate

    @property
    def version(self) -> str:
        """Version of tierod, with monitor and variant."""
        return f"tierod {__version__}, {self.monitor}, {self.variant}"

    @property
    def digest(self) -> int:
        """32-bit hash of version, names and values of all parameters."""
        text = "\n".join(f"{each.path} {value!r}" for each, value in zip(self.tuning, self.values, strict=True))
        return int.from_bytes(hashlib.sha256(f"{self.version}\n{text}".encode()).digest()[:4], "big")


def subject_of(monitor: str | None, vehicle: Vehicle | str, variant: str | None = None) -> Subject:
    """The monitor of a vehicle, ready for export.

    Args:
        monitor: name; None for the usual one of the vehicle
        vehicle: parameter set, its name, or the path of its file
        variant: name; None for the monitor's default

    Raises:
        ParameterError: the monitor, variant or vehicle does not exist, the vehicle lacks a parameter, or the monitor
            evaluates recordings as a whole
    """
    car = vehicle if isinstance(vehicle, Vehicle) else load(vehicle)
    listed = MONITORS.required(monitor or usual_monitor(car))
    definition, chosen = find(listed.name, variant or listed.default or next(iter(listed.variants)))
    block = getattr(opened(definition, chosen, car), "block", None)
    if block is None:
        raise ParameterError(
            f"the monitor '{definition.name}', variant '{chosen.name}', judges a recording as a whole and cannot "
            "step from sample to sample; export one that can, for example friction"
        )
    if variant is None:
        # A monitor without a default variant requires a choice, but only a monitor that can be exported.
        find(listed.name)
    stem = definition.name if chosen.name == definition.default else f"{definition.name}_{chosen.name}"
    names = (definition.title, definition.name, chosen.name, car.name)
    return subject_of_block(identifier(stem), block, definition.rate, *names)


def subject_of_block(
    name: str, block: Any, rate: float, title: str = "", monitor: str = "", variant: str = "", vehicle: str = ""
) -> Subject:
    """A block, ready for export.

    Args:
        name: C identifier with which all names begin, without "tierod_"
        rate: sampling rate [Hz]
        monitor, variant, vehicle: names; "" where there is none

    Raises:
        TraceError: the block cannot be traced
    """
    graph, initial = trace(block), block.init()
    remembered = initial.judge if isinstance(initial, BankState) else initial
    leaves = zip(described(remembered), values_of(remembered), strict=True)
    pairs = list(tuning(block))
    known = {each.path: each for each in described(block)}
    return Subject(
        name=name,
        title=title or name,
        monitor=monitor,
        variant=variant,
        vehicle=vehicle,
        rate=rate,
        block=block,
        graph=graph,
        sample=of_signals(graph.sample, graph.sample_tree),
        state=tuple(each for each, leaf in leaves if not isinstance(leaf, Ring)),
        output=tuple(described(graph.output_tree)),
        tuning=tuple(known.get(path, Described(path)) for path, _ in pairs),
        values=tuple(value for _, value in pairs),
    )
