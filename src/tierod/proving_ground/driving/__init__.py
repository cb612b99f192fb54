"""Whoever drives the virtual car: eyes, arms and foot, or their automatic stand-ins."""

from tierod.proving_ground.driving.driver import HumanDriver, Pedals

__all__ = ["HumanDriver", "Pedals"]
