"""Every law on an imposed sine, sampled at 1 kHz, against its differential equation integrated by other means."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tierod.core.block import tuning
from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.physics.friction import (
    dahl_power_update,
    dahl_slope,
    dahl_update,
    lugre_bristle_rate,
    lugre_torque,
    stribeck_level,
)
from tierod_lab.ground.steering.friction import (
    Coulomb,
    Dahl,
    DahlPower,
    Law,
    LuGre,
    MaxwellSlip,
    Stribeck,
)

LAWS = [
    Coulomb(),
    Dahl(),
    DahlPower(exponent=0.5),
    DahlPower(exponent=2.0),
    MaxwellSlip(),
    Stribeck(),
    LuGre(),
]
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


def along(slope, angle, part=1e-4):
    parts = math.ceil(np.max(np.abs(np.diff(angle))) / part)
    fine = np.interp(np.arange((len(angle) - 1) * parts + 1) / parts, np.arange(len(angle)), angle)
    share, out = 0.0, [0.0]
    for turned in np.diff(fine).tolist():
        share = min(max(share + turned * slope(share, turned), -1.0), 1.0)
        out.append(share)
    return np.array(out[::parts])


def elastoplastic(angle, elastic):
    return along(lambda share, turned: 1.0 / elastic, angle)


def published(law, time, angle, rate):
    """Friction share by the published equations."""
    if isinstance(law, Coulomb):
        return elastoplastic(angle, law.angle)
    if isinstance(law, MaxwellSlip):
        return sum(share * elastoplastic(angle, each) for share, each in zip(law.shares, law.angles, strict=True))
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
    if exponent < 1.0:
        return along(lambda h, turned: dahl_slope(h, math.copysign(1.0, turned), law.angle, exponent), angle)
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


@pytest.mark.parametrize("law", LAWS, ids=IDS)
def test_level_is_reached_by_a_long_fast_stroke_both_ways(law):
    for direction in (1.0, -1.0):
        memory = law.remembered()
        for _ in range(2000):
            memory = law.advance(memory, direction * 2e-3, direction * 2.0)
        assert law.share(memory, 0.0, direction * 2.0) == pytest.approx(direction, rel=0.01)


@pytest.mark.parametrize("law", LAWS, ids=IDS)
def test_a_stroke_in_parts_is_the_stroke_as_a_whole(law):
    memory = law.advance(law.remembered(), -0.01, -0.7)
    parts = law.advance(law.advance(memory, 0.004, 0.7), 0.009, 0.7)
    whole = law.advance(memory, 0.013, 0.7)
    assert parts == pytest.approx(whole, abs=1e-12)
    assert law.share(memory, 0.013, 0.7) == pytest.approx(law.share(whole, 0.0, 0.7), abs=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=IDS)
@pytest.mark.parametrize("rate", [-0.05, 0.05])
def test_slope_is_the_growth_of_the_share_over_the_way_that_follows(law, rate):
    turned = math.copysign(1e-8, rate)
    for before in (-0.04, 0.003, 0.5):
        memory = law.advance(law.remembered(), before, rate)
        grown = (law.share(memory, turned, rate) - law.share(memory, 0.0, rate)) / turned
        damping = (
            1.0 - 2e-3 * abs(rate) / law.angle / law.advance(0.0, 9.0, abs(rate)) if isinstance(law, LuGre) else 1.0
        )
        assert damping * law.slope(memory, rate) == pytest.approx(grown, rel=1e-4, abs=1e-3)
        assert law.slope(memory, 0.0) > 0.0


def test_dahls_laws_are_the_formulas_of_physics():
    for memory, turned in ((-0.8, 0.004), (0.3, -0.02), (0.5, 0.0)):
        assert Dahl(0.02).advance(memory, turned, 1.0) == dahl_update(memory, turned, 0.02)
        assert DahlPower(0.02, 1.5).advance(memory, turned, 1.0) == dahl_power_update(memory, turned, 0.02, 1.5)
        assert DahlPower(0.02, 1.0).share(memory, turned, 1.0) == pytest.approx(Dahl(0.02).share(memory, turned, 1.0))


def test_steady_curve_falls_with_the_rate():
    for law in (Stribeck(excess=0.3, rate=0.1), LuGre(excess=0.3, rate=0.1)):
        for rate in (0.01, 0.1, 1.0):
            memory = law.advance(law.remembered(), 3.0, rate)
            assert law.share(memory, 0.0, rate) == pytest.approx(1.0 + 0.3 * math.exp(-((rate / 0.1) ** 2)), rel=1e-6)


def test_elements_need_a_share_each():
    with pytest.raises(ParameterError, match="one share per angle"):
        MaxwellSlip((0.01, 0.02), (0.5,))
    with pytest.raises(ParameterError, match="sum be 1"):
        replace(MaxwellSlip(), shares=(0.25, 0.25, 0.25, 0.3))
    assert len(dict(tuning(MaxwellSlip()))) == 8
