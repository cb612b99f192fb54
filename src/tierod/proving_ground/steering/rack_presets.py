"""Parameter sets of racks from the literature."""

from __future__ import annotations

import math

from tierod.proving_ground.steering.friction import DryFriction
from tierod.proving_ground.steering.friction_laws import Dahl
from tierod.proving_ground.steering.linkage import Linkage
from tierod.proving_ground.steering.rack_eps import Mesh, RackEps


def demonstrator_rack() -> RackEps:
    """Rack and pinion of the demonstrator of Li, Frey and Gauterin, without its motors, which turn the column.

    Source: Table A1 of the paper, without steering wheel and torsion bar. The inertia is printed as 45 kg*m**2 and
    taken as 0.045, shared between `wheel_inertia` and `pinion_inertia`, of which only the sum counts. The ratio is
    printed as the reciprocal of what eqs (1) to (5) need. The build-up angle of friction is assumed.
    """
    return RackEps(
        wheel_inertia=0.040,
        wheel_damping=0.0,
        pinion_inertia=0.005,
        pinion_damping=0.0,
        rack_mass=3.0,
        rack_damping=22867.0,
        centring=31227.0,
        mesh=Mesh(1e8, 1e3),
        friction=DryFriction(level=1.11, law=Dahl(math.radians(1.0))),
        friction_on_rack=False,
        motor=None,
        linkage=Linkage(
            ratio=1.0 / 19.7,
            ackermann_gain=0.0,
            rack_ratio=1.0 / 146.12,
            road_wheel_inertia=0.0,
            friction=DryFriction(level=0.0),
        ),
        torsion_bar=None,
    )
