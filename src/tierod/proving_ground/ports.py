"""Signals and actuators inside the car's own loops, where a fault can reach them."""

from __future__ import annotations

from functools import cache
from typing import Any

from tierod.core.block import named_tuple
from tierod.core.graph.maths import where
from tierod.proving_ground.parts import Port


@cache
def ports_type(names: tuple[str, ...]) -> type:
    """The NamedTuple class with one `Port` per name."""
    return named_tuple("Ports", [(name, Port) for name in names])


def pass_through(port: Port, held: Any, value: Any) -> tuple[Any, Any]:
    """What comes out of a port, as (value to hold from now on, output).

    Args:
        port: the fault, `SOUND` for none
        held: value of the step before
        value: what goes in
    """
    kept = where(port.held > 0.5, held, value)
    return kept, port.gain * kept + port.offset
