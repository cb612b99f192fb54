"""What a block does decides its digest, and not what it is called."""

from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.analysis import graph_digest


class Sample(NamedTuple):
    torque: Annotated[Scalar, "N*m"]


@dataclass(frozen=True)
class Smooth:
    gain: Annotated[float, ""] = 0.1
    Sample = Sample

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Scalar]:
        value = state + self.gain * (sample.torque - state)
        return value, value


@dataclass(frozen=True)
class Renamed:
    """The same under other names."""

    share: Annotated[float, ""] = 0.1
    Sample = Sample

    def init(self) -> Scalar:
        return 0.0

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Scalar]:
        away = sample.torque - state
        after = state + self.share * away
        return after, after


@dataclass(frozen=True)
class Other(Smooth):
    """With a constant in its equation."""

    def step(self, state: Scalar, sample: Sample) -> tuple[Scalar, Scalar]:
        value = state + self.gain * (sample.torque - 1.0001 * state)
        return value, value


def test_names_and_places_of_code_do_not_count():
    assert graph_digest(Smooth()) == graph_digest(Renamed())


def test_a_threshold_and_a_constant_of_an_equation_count():
    digests = {
        graph_digest(each) for each in (Smooth(), replace(Smooth(), gain=0.11), Other(), replace(Other(), gain=0.2))
    }
    assert len(digests) == 4
    assert graph_digest(Smooth(), Other()) != graph_digest(Other(), Smooth())
