from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from tierod.core.block import leaves, skeleton
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod_lab.ground.integration import Varied


@dataclass(frozen=True)
class Spring:
    stiffness: Annotated[float, "N/m"] = 3.0
    damping: Annotated[float, "N*s/m"] = 0.5

    @property
    def half(self):
        return 0.5 * self.stiffness


@dataclass(frozen=True)
class Mass:
    spring: Spring = field(default_factory=Spring)
    mass: Annotated[float, "kg"] = 2.0

    class Sample(NamedTuple):
        push: Annotated[float, "N"]

    def init(self):
        return (0.0, 0.0)

    def step(self, state: Any, sample: Any):
        place, speed = state
        force = sample.push - 2.0 * self.spring.half * place - self.spring.damping * speed
        speed = speed + 0.01 * force / self.mass
        return (place + 0.01 * speed, speed), place


def test_constant_parameters_change_nothing():
    push = np.sin(np.arange(300) * 0.05)
    varied = Varied(Mass(), ("spring.stiffness", "mass"))
    names = [path for path, _ in leaves(skeleton(varied.Sample))]
    assert names == ["push", "parameters.mass", "parameters.spring.stiffness"]
    samples = np.column_stack([push, np.full(300, 2.0), np.full(300, 3.0)])
    assert np.array_equal(scan(varied, samples).values, scan(Mass(), push[:, None]).values)


def test_a_parameter_changes_in_mid_run_as_if_another_block_went_on():
    push = np.ones((400, 1))
    stiff = np.where(np.arange(400) < 200, 3.0, 12.0)
    result = scan(Varied(Mass(Spring(999.0)), ("spring.stiffness",)), np.column_stack([push, stiff]))
    first = scan(Mass(Spring(3.0)), push[:200])
    second = scan(Mass(Spring(12.0)), push[200:], first.state)
    assert np.allclose(result.values, np.concatenate([first.values, second.values]), rtol=1e-13, atol=0.0)


def test_a_wrong_name_is_refused_with_the_nearest():
    with pytest.raises(ParameterError, match=r"no parameter 'spring.stifness'.*spring.stiffness"):
        Varied(Mass(), ("spring.stifness",))
