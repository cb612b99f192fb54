"""Laws of friction on an imposed sine beside their differential equations, and the level over side and angle."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tierod.core.graph import scan
from tierod.physics.friction import dahl_slope
from tierod_lab.ground.laws import lugre_bristle_rate, lugre_torque, stribeck_level
from tierod_lab.ground.steering.friction import Dahl, DahlPower, DryFriction, Law, LuGre, Stribeck

LAWS = [Dahl(), DahlPower(exponent=2.0), Stribeck(), LuGre()]
IDS = [f"{type(law).__name__}-{getattr(law, 'exponent', '')}".rstrip("-") for law in LAWS]
AMPLITUDE, STEP = 0.5, 1e-3


@dataclass(frozen=True)
class Dragged:
    law: Law

    class Sample(NamedTuple):
        turned: Annotated[float, "rad"]
        rate: Annotated[float, "rad/s"]

    def init(self) -> Any:
        return self.law.remembered()

    def step(self, memory, sample):
        return self.law.advance(memory, *sample), self.law.share(memory, *sample)


def sine(rate, cycles=2):
    speed = rate / AMPLITUDE
    time = np.arange(0.0, cycles * 2.0 * math.pi / speed, STEP)
    return time, AMPLITUDE * np.sin(speed * time), rate * np.cos(speed * time)


def sampled(law, angle, rate):
    return scan(Dragged(law), np.column_stack([np.diff(angle), rate[1:]])).values[:, 0]


def solved(slope, time, rates):
    speed = math.pi / time[np.argmin(rates)]
    peak = rates[0]

    def derivative(now, state):
        return [slope(state[0], peak * math.cos(speed * now))]

    period = 2.0 * math.pi / speed
    out = solve_ivp(
        derivative, (0.0, time[-1]), [0.0], t_eval=time, rtol=1e-8, atol=1e-10, max_step=period / 400.0, method="LSODA"
    )
    return out.y[0]


def published(law, time, angle, rate):
    """Friction share by the published equations."""
    if isinstance(law, LuGre):
        steady = lambda w: stribeck_level(w, 1.0 + law.excess, 1.0, law.rate)  # noqa: E731
        stiffness = 1.0 / law.angle
        z = solved(lambda z, w: lugre_bristle_rate(z, w, stiffness, steady(w)), time, rate)
        pairs = zip(z.tolist(), rate.tolist(), strict=True)
        return np.array(
            [
                lugre_torque(
                    z, lugre_bristle_rate(z, w, stiffness, steady(w)), w, stiffness, law.micro_time * stiffness, 0
                )
                for z, w in pairs
            ]
        )
    exponent = getattr(law, "exponent", 1.0)
    share = solved(lambda h, w: w * dahl_slope(h, math.copysign(1.0, w), law.angle, exponent), time, rate)
    return share * stribeck_level(rate, 1.0 + law.excess, 1.0, law.rate) if isinstance(law, Stribeck) else share


@pytest.mark.parametrize("peak", [0.2, pytest.param(1.0, marks=pytest.mark.slow), 5.0])
@pytest.mark.parametrize("law", LAWS, ids=IDS)
def test_law_is_its_differential_equation_and_its_loop_the_friction_work(law, peak):
    time, angle, rate = sine(peak)
    ours, expected = sampled(law, angle, rate), published(law, time, angle, rate)
    error = ours - expected[1:]
    assert np.sqrt(np.mean(error**2)) < 0.01
    cycle = len(time) // 2
    middle = 0.5 * (ours[cycle:] + ours[cycle - 1 : -1])
    area = float(np.sum(middle * np.diff(angle)[cycle:]))
    fine = np.trapezoid(expected[cycle:] * rate[cycle:], time[cycle:])
    assert area == pytest.approx(fine, rel=0.01)


def sliding(friction, direction, angle=0.0, load=1.0):
    memory = friction.advance(friction.remembered(), direction * 3.0, direction * 2.0, load, angle)
    return friction.torque(memory, 0.0, direction * 2.0, load, angle)


def test_one_side_may_rub_more():
    friction = DryFriction(4.0, left_excess=2.0)
    assert sliding(friction, 1.0) == pytest.approx(6.0)
    assert sliding(friction, -1.0) == pytest.approx(-4.0)
    assert friction.sliding_level(0.0) == 5.0


def test_a_bump_is_where_it_is_and_as_wide_as_said():
    friction = DryFriction(4.0, bump=3.0, bump_angle=1.0, bump_width=0.2)
    assert sliding(friction, 1.0, angle=1.0) == pytest.approx(7.0)
    assert friction.sliding_level(1.0) == 7.0
    assert 4.0 < sliding(friction, 1.0, angle=1.1) < 7.0
    assert sliding(friction, 1.0, angle=1.2) == pytest.approx(4.0)
    assert sliding(friction, 1.0, angle=-1.0) == pytest.approx(4.0)
