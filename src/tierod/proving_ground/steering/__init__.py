"""Steering systems of the virtual cars, from the steering wheel to the road wheels."""

from tierod.proving_ground.steering.column_eps import ColumnEps, WormGear
from tierod.proving_ground.steering.friction import DryFriction, Wave
from tierod.proving_ground.steering.friction_laws import (
    Coulomb,
    Dahl,
    DahlPower,
    LuGre,
    MaxwellSlip,
    Stribeck,
)
from tierod.proving_ground.steering.linkage import EndStop, Linkage
from tierod.proving_ground.steering.rack_eps import Mesh, RackEps
from tierod.proving_ground.steering.shaft import Motor, Ripple, SpeedLimit, TorsionBar

__all__ = [
    "ColumnEps",
    "Coulomb",
    "Dahl",
    "DahlPower",
    "DryFriction",
    "EndStop",
    "Linkage",
    "LuGre",
    "MaxwellSlip",
    "Mesh",
    "Motor",
    "RackEps",
    "Ripple",
    "SpeedLimit",
    "Stribeck",
    "TorsionBar",
    "Wave",
    "WormGear",
]
