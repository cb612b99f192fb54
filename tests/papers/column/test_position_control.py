"""References, the motion that follows them, and the control on a linear column with a known state and on the bench."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest

from tierod.core.errors import ParameterError
from tierod.core.graph import scan
from tierod.export.c_export import interface_of, monitor_files
from tierod.export.interface import Options
from tierod.export.subject import subject_of_block
from tierod.models.linear import linearise, zero_order_hold
from tierod.models.steering_column import (
    ColumnInput,
    ColumnParameters,
    SteeringColumn,
    TwoInertiaColumn,
    without_gear,
)
from tierod.vehicles import load
from tierod_lab.papers.column.hand_datasets import loops, sweep, tracking
from tierod_lab.papers.column.position_control import (
    ObservedColumn,
    ObservedPositionControl,
    PositionControl,
    TorqueLimits,
)
from tierod_lab.papers.column.reference import Reference, Sweep, advanced, motion_for

STEP, BAR = 1e-3, 140.0
COLUMN = ColumnParameters(0.035, 0.2286, BAR, 18.0, 7.26, 5.517e-3, 1.4486e-4, 1.484e-3)
BELIEF = without_gear(COLUMN)
PLANT = zero_order_hold(SteeringColumn, COLUMN, STEP, (0.0,) * 6, (0.0,) * 3)
CONTROL = PositionControl.design(BELIEF, BAR)


@pytest.mark.parametrize("source", [Sweep(duration=10.0), Sweep(start=2.0, stop=2.0)])
def test_every_derivative_is_that_of_the_one_before_and_the_future_that_of_the_taylor_series(source):
    time = np.arange(0.0, 12.0, 1e-3)
    reference = source.at(time)
    for below, above in pairwise(reference):
        slope = (below[2:] - below[:-2]) / 2e-3
        inside = np.abs(time[1:-1, None] - [10.0]).min(axis=1) > 1.5e-3
        np.testing.assert_allclose(slope[inside], above[1:-1][inside], atol=2e-4 * np.abs(above).max())
    assert all(value[0] == 0.0 for value in reference)
    assert np.abs(reference.angle).max() == pytest.approx(math.radians(30.0), rel=1e-3)
    part = slice(2000, 9000)
    ahead = advanced(Reference(*(each[part] for each in reference)), 1.5e-3)
    np.testing.assert_allclose(ahead.angle, source.at(time[part] + 1.5e-3).angle, atol=2e-9)


@pytest.mark.parametrize(("frequency", "tolerance"), [(0.1, 1e-6), (3.0, 1.2e-2)])
@pytest.mark.parametrize("output_stiffness", [BAR, BELIEF.stiffness])
def test_the_motion_is_that_of_the_linear_column(frequency, tolerance, output_stiffness):
    system = linearise(TwoInertiaColumn, BELIEF, (0.0,) * 4, (0.0,) * 3)
    s = 2j * math.pi * frequency
    states = np.linalg.solve(s * np.eye(4) - system.A, system.B[:, 0])
    share = BELIEF.stiffness / output_stiffness
    shaft = states[2] + share * (states[3] / BELIEF.motor_ratio - states[2])
    for phase in (0.0, 1.0, 2.5):
        turned = np.exp(1j * phase) / 1j
        exact = [*(states / shaft * turned).real, (turned / shaft).real]
        sizes = [*np.abs(states / shaft), abs(1.0 / shaft)]
        given = Reference(*(float((s**order * turned).real) for order in range(5)))
        found = np.array(motion_for(given, BELIEF, output_stiffness))
        np.testing.assert_allclose(found / sizes, np.array(exact) / sizes, atol=tolerance)


class Seen(NamedTuple):
    gear_angle: Annotated[float, "rad"]
    control: PositionControl.Output


class Driven(NamedTuple):
    reference: Reference
    enabled: Annotated[float, ""]
    disturbance_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class Rig:
    """A linear column under control, its state known; the torque found from one state acts from the next sample on."""

    control: PositionControl = CONTROL
    parameters: Any = PLANT.parameters

    Sample = Driven

    def init(self):
        return SteeringColumn.State(*[0.0] * 6), 0.0, self.control.init()

    def step(self, state, sample):
        column, torque, memory = state
        observed = ObservedColumn(*(getattr(column, name) for name in ObservedColumn._fields))
        memory, output = self.control.step(memory, PositionControl.Sample(observed, sample.reference, sample.enabled))
        acting = ColumnInput(torque, 0.0, sample.disturbance_torque)
        after = PLANT.model.transition(column, acting, self.parameters)
        return (after, output.motor_torque, memory), Seen(column.gear_angle, output)


def turn(angle, seconds, enabled=1.0, disturbance=0.0, **changes):
    """Signals of a run to an angle, a jump at half a second or a reference; `changes` are fields of the control."""
    time = np.arange(round(seconds / STEP)) * STEP
    jump = Reference(np.where(time >= 0.5, angle, 0.0), *[np.zeros(len(time))] * 4) if np.isscalar(angle) else None
    columns = [
        *(jump or angle.at(time)),
        np.broadcast_to(enabled, time.shape),
        np.broadcast_to(disturbance, time.shape),
    ]
    return time, scan(Rig(replace(CONTROL, **changes)), np.column_stack(columns))


def test_the_shaft_follows_a_sine_and_the_integral_takes_up_a_constant_torque():
    source = Sweep(start=3.0, stop=3.0)
    time, result = turn(source, 6.0)
    error = np.degrees(result["gear_angle"] - source.at(time).angle)[time > 3.0]
    assert np.sqrt((error**2).mean()) < 0.05
    _, held = turn(0.3, 4.0, disturbance=0.2)
    assert abs(held["gear_angle"][-1] - 0.3) < 1e-4
    assert held["control.motor_torque"][-1] == pytest.approx(0.2, abs=2e-3)


@pytest.mark.parametrize(("limit", "overshoot"), [(0.3, 0.1), (1.0, 0.2)])
def test_a_large_step_that_saturates_the_motor_does_not_wind_up(limit, overshoot):
    time, result = turn(math.radians(90.0), 8.0, limits=TorqueLimits(torque=limit))
    torque = result["control.motor_torque"]
    assert np.abs(torque).max() == pytest.approx(limit)
    assert result["control.limited"].any()
    assert result["gear_angle"].max() < (1.0 + overshoot) * math.radians(90.0)
    assert np.abs(result["gear_angle"][time > 2.0] - math.radians(90.0)).max() < math.radians(1.0)
    assert np.abs(np.diff(torque)).max() <= TorqueLimits().rate * STEP * (1.0 + 1e-9)


def test_control_takes_hold_and_lets_go_without_a_blow_also_where_numbers_are_missing():
    enabled = np.where((np.arange(4000) >= 600) & (np.arange(4000) < 2500), 1.0, 0.0)
    enabled[3000:] = 1.0
    enabled[3500:3700] = np.nan
    time, result = turn(0.4, 4.0, enabled=enabled)
    torque, hold = result["control.motor_torque"], result["control.hold"]
    assert not torque[:600].any()
    assert np.abs(np.diff(torque)[:610]).max() < 0.05
    assert not torque[(time > 2.61) & (time < 3.0)].any()
    released = np.nonzero(hold[2500:] <= 0.0)[0][0] * STEP
    assert released == pytest.approx(CONTROL.limits.releasing, abs=2.0 * STEP)
    assert not torque[3610:3700].any()
    assert np.isfinite(result.values).all()


@pytest.mark.parametrize(
    ("made", "says"),
    [
        (lambda: TorqueLimits(torque=0.0), "torque"),
        (lambda: replace(CONTROL, friction=-0.1), "friction"),
        (lambda: PositionControl.design(BELIEF, BAR, weights={"shaft": -1.0}), "is -1.0"),
        (lambda: PositionControl.design(BELIEF, BAR, weights={"shafts": 1.0}), "weight of shafts"),
        (lambda: PositionControl.design(BELIEF, BAR, weights={"shaft": 1.0}), "weigh the shaft and its integral"),
        (lambda: PositionControl.design(BELIEF, BAR, smoothing=-1.0), "smoothing is -1.0"),
        (lambda: PositionControl.design(BELIEF, 0.0), "torsion_bar_stiffness is 0.0"),
        (lambda: PositionControl.design(replace(BELIEF, motor_inertia=0.0), BAR), "motor_inertia is 0.0"),
    ],
)
def test_wrong_numbers_are_refused(made, says):
    with pytest.raises(ParameterError, match=says):
        made()


def test_on_the_bench_a_torque_acts_from_the_next_sample_on_and_the_shaft_follows():
    done = sweep(loops()["printed, mechanical"], 1, quick=True)
    asked, acting = done.signals["controller.motor_torque"], done.signals["plant.motor_target_torque"]
    np.testing.assert_array_equal(acting[1:], asked[:-1])
    (row,) = tracking(("printed, balanced", True))
    assert 0.0 < row["rms"] < 0.05


def test_observer_and_control_are_one_block_of_a_vehicle_that_is_exported_as_c():
    block = ObservedPositionControl.of_vehicle(load("column-bench"))
    subject = subject_of_block("position_control", block, 1000.0, "Position control")
    texts = monitor_files(interface_of(subject, Options()))
    assert "motor_torque" in texts["tierod_position_control.h"]
