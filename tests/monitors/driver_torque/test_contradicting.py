"""Which signal of a torsion bar contradicts the other two."""

import numpy as np
import pytest

from tierod.monitors.driver_torque.column import SIGNALS, ContradictionOverDrive, described

RATIO, STIFFNESS, RATE = 18.0, 140.0, 100.0
TIME = np.arange(6000) / RATE


def signals():
    """A wheel that turns to and fro under hands that twist the bar."""
    noise = np.random.default_rng(1).normal(size=(3, len(TIME)))
    motor = np.sin(1.3 * TIME) + 0.4 * np.sin(2.9 * TIME + 1.0)
    bar = 2.0 * np.sin(1.9 * TIME) + np.sin(4.1 * TIME + 2.0)
    wheel = motor + bar / STIFFNESS
    return {
        "steering_wheel_angle": wheel + 1e-4 * noise[0],
        "motor_angle_mechanical": RATIO * (motor + 1e-4 * noise[1]),
        "driver_torque": bar + 0.01 * noise[2],
    }


def found(**changed):
    over = ContradictionOverDrive(RATIO, STIFFNESS, RATE)
    columns = signals() | changed
    for piece in np.array_split(np.arange(len(TIME)), 7):
        over.add(*(columns[name][piece] for name in SIGNALS))
    return over.found()


def late(values, seconds):
    return np.concatenate([np.full(round(seconds * RATE), values[0]), values])[: len(values)]


def test_signals_that_fit_contradict_nothing():
    assert found().names == ()


@pytest.mark.parametrize("name", SIGNALS)
def test_a_gain_a_delay_noise_and_a_standstill_are_found(name):
    values = signals()[name]
    for gain in (0.5, 2.0):
        contradiction = found(**{name: gain * values})
        assert contradiction.names == (name,)
        assert contradiction.gain == pytest.approx(gain, rel=0.02)
        assert f"when {name} is divided by" in described(contradiction)
    for seconds in (0.1, 0.5):
        contradiction = found(**{name: late(values, seconds)})
        assert contradiction.names == (name,)
        assert contradiction.delay == pytest.approx(seconds, abs=0.021)
        assert f"{name} is late" in described(contradiction)
    noise = np.random.default_rng(2).normal(size=len(values))
    assert name in found(**{name: values + np.std(values) * noise}).names
    stuck = np.where(TIME < 20.0, values, values[2000])
    assert found(**{name: stuck}).names == found(**{name: stuck * (1.0 + 1e-14 * noise)}).names == (name,)


def test_gaps_and_too_few_samples_say_nothing():
    gaps = np.where(np.arange(len(TIME)) % 4 == 0, signals()["driver_torque"], np.nan)
    assert found(driver_torque=gaps).names == ()
    assert found(driver_torque=np.full(len(TIME), np.nan)) is None


def creeping(values, gain=1.0, zero=0.0):
    """A signal whose gain and zero move evenly over the last two thirds."""
    share = np.clip((TIME / TIME[-1] - 1.0 / 3.0) * 1.5, 0.0, 1.0)
    return values * (1.0 + (gain - 1.0) * share) + zero * share


@pytest.mark.parametrize("name", SIGNALS)
def test_a_gain_that_creeps_is_found(name):
    contradiction = found(**{name: creeping(signals()[name], gain=2.0)})
    # Both angles turn alike: beside noise only their sum with the torque separates them.
    assert name in contradiction.names
    assert contradiction.creeps == "gain"
    others = " and ".join(each for each in SIGNALS if each not in contradiction.names)
    assert described(contradiction) == (
        f"the gain of {' or '.join(contradiction.names)} changes slowly relative to {others}"
    )


@pytest.mark.parametrize(("name", "size"), [("steering_wheel_angle", 2.0), ("motor_angle_mechanical", 2.0 * RATIO)])
def test_a_zero_that_creeps_further_than_the_bar_twists_is_that_of_an_angle(name, size):
    contradiction = found(**{name: creeping(signals()[name], zero=size)})
    assert contradiction.creeps == "zero"
    assert set(contradiction.names) == {"steering_wheel_angle", "motor_angle_mechanical"}


def test_a_zero_that_creeps_little_may_be_that_of_the_torque():
    contradiction = found(driver_torque=creeping(signals()["driver_torque"], zero=5.0))
    assert (contradiction.creeps, set(contradiction.names)) == ("zero", set(SIGNALS))


def test_a_wrong_sign_throughout_does_not_creep():
    assert found(driver_torque=-signals()["driver_torque"]).creeps == ""
