"""What the implicit integration is told of dry friction, and what that makes of friction that sticks stiffly."""

import math
from dataclasses import replace

import numpy as np
import pytest

from proving_ground.steering.rig import STEP, Rig
from tierod.core.block import leaves, rebuild
from tierod.core.graph.derivatives import jacobian
from tierod.proving_ground.parts import Loads
from tierod.proving_ground.steering.active_front import ActiveFront
from tierod.proving_ground.steering.column_eps import ColumnEps, WormGear
from tierod.proving_ground.steering.demonstrator import Demonstrator
from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.friction_laws import Coulomb, Dahl, LuGre
from tierod.proving_ground.steering.linkage import Linkage
from tierod.proving_ground.steering.rack_eps import RackEps
from tierod.proving_ground.steering.steer_by_wire import SteerByWire

HAIR = 1e-7
RUBBING = Linkage(friction=DryFriction(20.0, Dahl(0.01)))
STEERINGS = {
    "column": ColumnEps(linkage=RUBBING),
    "rigid column with a worm": ColumnEps(torsion_bar=None, worm_gear=WormGear(), linkage=RUBBING),
    "rack": RackEps(linkage=RUBBING),
    "rack that rubs at the pinion": RackEps(friction_on_rack=False, motor_on_rack=False, linkage=RUBBING),
    "by wire": SteerByWire(),
    "superposed": ActiveFront(),
    "demonstrator": Demonstrator(),
}


@pytest.mark.parametrize("name", STEERINGS)
def test_friction_enters_as_its_derivative_by_the_angle(name):
    """Against the Jacobian of the whole, a hair ahead on the way to the left, with friction half built up."""
    steering = STEERINGS[name]
    memory = rebuild(steering.remembered(), [0.5 for _ in leaves(steering.remembered())])
    idle = Loads(0.0, 0.0, 0.0, (0.0,) * len(steering.actuators), 0.0, 0.0)
    start = steering.stiff()
    ahead = rebuild(start, [value + HAIR for _, value in leaves(start)])
    whole = np.array(jacobian(lambda at: steering.derivative(at, start, memory, idle), ahead), dtype=float)
    smooth = np.array(jacobian(lambda at: steering.derivative(at, at, memory, idle), ahead), dtype=float)
    entries = np.zeros_like(whole)
    place = [path for path, _ in leaves(start)].index
    for (rate, angle), entry in steering.sticking(ahead, memory).items():
        entries[place(rate), place(angle)] = entry
    assert np.min(entries) < -50.0
    np.testing.assert_allclose(whole - smooth, entries, rtol=1e-3, atol=1e-6 * np.max(np.abs(whole)))


@pytest.mark.parametrize(
    "steering",
    [
        ColumnEps(friction=DryFriction(12.5, Coulomb()), worm_gear=WormGear()),
        RackEps(friction=DryFriction(12.5, Coulomb()), friction_on_rack=False),
        RackEps(friction=DryFriction(12.5, Dahl(math.radians(0.1))), friction_on_rack=False),
        RackEps(friction=DryFriction(12.5, LuGre()), friction_on_rack=False),
    ],
    ids=["coulomb, worm", "coulomb at the pinion", "dahl at the pinion", "lugre at the pinion"],
)
def test_what_is_light_neither_chatters_where_it_sticks_nor_is_braked_where_it_slides(steering):
    """The motor turns the steering to and fro for 2 s and lets it stick, held against steps of 25 us."""

    def swing(size):
        return lambda time: size * np.sin(1.5 * time) * (time < 2.0)

    rig = Rig(steering, kingpin_stiffness=3000.0, arm_stiffness=60.0, arm_damping=2.0)
    told = {"hand_angle": swing(0.6), "motor_torque": swing(0.4)}
    _, coarse = rig.run(3.0, **told)
    _, fine = replace(rig, step_time=STEP / 40.0).run(3.0, **told)
    for name in ("steering_wheel_angle", "driver_torque", "pinion_angle"):
        error = coarse[name] - fine[name][::40]
        assert np.sqrt(np.mean(error**2)) < 0.01 * np.std(fine[name]), name
