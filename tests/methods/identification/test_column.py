"""The column on a bench: recordings, the sampled model, what is found."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from methods.identification.bench import FREE, LOCKED, RAMPS, SINES, TRUTH, changed, recordings, row, turned
from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.methods.identification.bench_recording import BenchParameters, SampledColumn
from tierod.methods.identification.column import identify_column
from tierod.methods.identification.column_fit import FRICTION, search_of
from tierod.methods.identification.column_misfit import refuse_slips
from tierod.methods.identification.maximum_likelihood import Simulation
from tierod.models.steering_column import ColumnInput, ColumnWithFriction
from tierod.vehicles import load


@pytest.mark.parametrize(("name", "locked"), [(FREE, False), (LOCKED, True), (RAMPS, True), (SINES, False)])
def test_it_sees_whether_the_wheel_is_locked_and_how_noisy_the_sensors_are(name, locked):
    found = row(name)
    assert found.locked is locked
    assert found.sample_time == pytest.approx(1e-3)
    assert found.deviation == pytest.approx((math.radians(0.05), math.radians(0.2), 0.02), rel=0.1)
    assert found.remarks == ()


def test_missing_channels_are_named_with_what_is_needed():
    channels = dict(recordings()[FREE].channels)
    del channels["motor_torque"], channels["driver_torque"]
    with pytest.raises(InputError, match=r"lacks driver_torque and motor_torque.*channel map"):
        row(FREE, Recording(channels))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"motor_torque": lambda t, v: (t, np.full_like(v, 0.1))}, "'motor_torque' is constant at 0.1"),
        ({"driver_torque": lambda t, v: (t, np.full_like(v, 0.5))}, "'driver_torque' is constant"),
        ({"motor_angle_mechanical": lambda t, v: (t, v * 1e-6 + 1e-3 * np.cos(t * 7e3))}, "does not excite"),
        ({"motor_torque": lambda t, v: (t[::10], v[::10])}, "10 ms apart; a column swings"),
        ({"motor_torque": lambda t, v: (1e3 * t, v)}, "in milliseconds"),
        ({"driver_torque": lambda t, v: (t[:1500], v[:1500])}, "holds 1.5 s"),
        ({"motor_torque": lambda t, v: (t, np.where((t > 1.0) & (t < 2.0), np.nan, v))}, "is missing in"),
        ({"driver_torque": lambda t, v: (t, np.where(t > 0.2, np.nan, v))}, "'driver_torque' is missing in 9"),
        ({"steering_wheel_angle": lambda t, v: (t, np.full_like(v, np.nan))}, "is missing in 100 %"),
    ],
)
def test_recordings_that_cannot_be_used(change, words):
    with pytest.raises(InputError, match=words):
        row(FREE, changed(recordings()[FREE], **change))


@pytest.mark.parametrize("name", [FREE, RAMPS])
@pytest.mark.parametrize("channels", [("motor_torque",), ("motor_angle_mechanical",), ("driver_torque",)])
def test_a_sign_the_wrong_way_round_is_named(name, channels):
    wrong = row(name, turned(recordings()[name], *channels))
    with pytest.raises(InputError, match=rf"{name}: the sign of {channels[0]} cannot be right"):
        refuse_slips(wrong, search_of(TRUTH, FRICTION, [wrong], widened=True))


@pytest.mark.parametrize("name", [FREE, LOCKED, RAMPS, SINES])
@pytest.mark.parametrize("factor", [0.6, 1.0, 1.6])
def test_a_fault_free_recording_passes_also_with_rough_parameters(name, factor):
    rough = replace(TRUTH, motor_friction=TRUTH.motor_friction * factor, motor_damping=TRUTH.motor_damping / factor)
    found = row(name)
    refuse_slips(found, search_of(rough, FRICTION, [found], widened=True))


ROUGH = replace(TRUTH, motor_damping=1.3 * TRUTH.motor_damping, motor_friction=0.07, motor_friction_stiffness=1.4)


@pytest.fixture(scope="module")
def result():
    return identify_column(
        ROUGH, {name: recordings()[name] for name in (FREE, LOCKED)}, deviations={"motor_damping": 1.0}
    )


def test_it_finds_damping_and_friction(result):
    found = {each.name: each for each in result.found}
    assert list(found) == ["steering_wheel_damping", "motor_damping", "motor_friction", "motor_friction_stiffness"]
    for name, limit in zip(found, (0.005, 0.02, 0.02, 0.05), strict=True):
        right = getattr(TRUTH, name)
        assert found[name].value == pytest.approx(right, rel=limit)
        assert found[name].value == pytest.approx(right, abs=5.0 * found[name].deviation)
        assert found[name].low < found[name].value < found[name].high
    assert found["motor_damping"].before_deviation == 1.0
    assert found["motor_damping"].change == pytest.approx(1.0 / 1.3 - 1.0, abs=0.01)
    assert [each.method for each in result.found] == ["instruments", *["likelihood"] * 3]


def test_slow_ramps_alone_do_not_identify_the_damping():
    with pytest.raises(InputError, match=r"do not excite motor_damping.*sweep or steps with the wheel free"):
        identify_column(replace(ROUGH, motor_damping=1e-5), {RAMPS: recordings()[RAMPS]}, ("motor_damping",))


def test_friction_that_is_held_and_wrong_is_named():
    wrong = replace(TRUTH, motor_friction=0.25, motor_friction_stiffness=5.0)
    with pytest.raises(InputError, match=r"motor_friction, held at 0\.25 .* near 0\.(09|1)[0-9]* .*--free"):
        identify_column(wrong, {SINES: recordings()[SINES]}, ("motor_damping", "gear_stiffness"))


BENCH = load("column-bench").parameters_for(BenchParameters)


def simulated(parameters, torque):
    return scan(Simulation(SampledColumn, parameters, (0.0,) * 7), torque[:, None]).values[:, :3]


def test_with_friction_it_follows_a_fine_integration_of_the_continuous_model():
    count = 400
    torque = 0.4 * np.sin(2.0 * np.pi * 4.0 * np.arange(count) * 1e-3)

    def slope(now, state):
        given = torque[min(int(now * 1e3 + 1e-9), count - 1)]
        return list(
            ColumnWithFriction.derivative(ColumnWithFriction.State(*state), ColumnInput(given, 0.0, 0.0), BENCH)
        )

    fine = solve_ivp(slope, (0.0, (count - 1) * 1e-3), [0.0] * 7, t_eval=np.arange(count) * 1e-3, max_step=2e-4)
    ours = simulated(BENCH, torque)
    assert np.max(np.abs(ours[:, 1] - fine.y[4])) < 1e-3 * np.ptp(fine.y[4])
    assert np.max(np.abs(ours[:, 0] - fine.y[3])) < 1e-3 * np.ptp(fine.y[3])
