"""Steering systems of the virtual cars, from the steering wheel to the road wheels."""

from tierod_lab.ground.steering.column_eps import ColumnEps, WormGear
from tierod_lab.ground.steering.friction import (
    Coulomb,
    Dahl,
    DahlPower,
    DryFriction,
    LuGre,
    MaxwellSlip,
    Stribeck,
    Wave,
)
from tierod_lab.ground.steering.linkage import EndStop, Linkage
from tierod_lab.ground.steering.rack_eps import Mesh, RackEps
from tierod_lab.ground.steering.shaft import Motor, Ripple, SpeedLimit, TorsionBar

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
