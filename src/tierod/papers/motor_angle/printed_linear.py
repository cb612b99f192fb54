"""Luenberger observers of a motor's speed, full and reduced, as parts of an observer of its angle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, NamedTuple

import numpy as np

from tierod.core.block import named_tuple, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph.maths import both, present, where
from tierod.models.linear import LinearSystem, Matrices, as_model, sampled
from tierod.papers.motor_angle.reduced_observer import INPUTS
from tierod.physics.clarke_park import RotorVector


class LinearMemory(NamedTuple):
    """States of the observer, its last speed and load, and the current of the sample before."""

    x: Any
    estimate: Any
    current: Any


@dataclass(frozen=True)
class LinearSpeed:
    """A linear observer, sampled exactly: the voltage is a mean over the sample, the current the mean of its ends.

    So its steady errors are those of the continuous one.

    Args:
        model, parameters: of the sampled observer
        tells: what it tells besides the speed
    """

    model: Any
    parameters: Matrices
    tells: tuple[str, ...]

    @classmethod
    def of(cls, observer: LinearSystem, sample_time: float) -> LinearSpeed:
        """From a design.

        Args:
            observer: of `full_observer` or `reduced_observer`
            sample_time: [s]

        Raises:
            ParameterError: it diverges
        """
        fastest = np.linalg.eigvals(observer.A).real.max()
        if not fastest < 0.0:
            raise ParameterError(f"the observer diverges with {fastest:+.3g} 1/s; give poles below zero")
        classes = [_numbers(names) for names in (observer.states, INPUTS, observer.outputs)]
        model, parameters = as_model(sampled(observer, sample_time), *classes)
        return cls(model, parameters, ("motor_load_torque",) if "load_torque" in observer.outputs else ())

    def start(self) -> LinearMemory:
        """At rest."""
        return LinearMemory(skeleton(self.model.State), skeleton(self.model.Output), 0.0)

    def advance(self, before: LinearMemory, voltage: RotorVector, current: RotorVector) -> tuple[LinearMemory, Any]:
        """One sample on: (memory, (speed, load)); without voltage or current everything stays."""
        whole = both(present(voltage.q), present(current.q))
        mean = self.model.Input(voltage.q, 0.5 * (before.current + current.q))
        x = self.model.transition(before.x, mean, self.parameters)
        estimate = self.model.output(x, self.model.Input(voltage.q, current.q), self.parameters)
        kept = where(present(current.q), current.q, before.current)
        after = LinearMemory(_chosen(whole, x, before.x), _chosen(whole, estimate, before.estimate), kept)
        return after, tuple(after.estimate)


@lru_cache(maxsize=32)
def _numbers(names: tuple[str, ...]) -> type:
    return named_tuple("Numbers", [(name, Annotated[float, ""]) for name in names])


def _chosen(condition: Any, taken: Any, otherwise: Any) -> Any:
    return type(taken)(*(where(condition, a, b) for a, b in zip(taken, otherwise, strict=True)))
