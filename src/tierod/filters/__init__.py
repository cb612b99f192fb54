"""Filters over several signals at once: blocks that treat them all alike and bridge short gaps."""

from tierod.filters.butterworth import Butterworth
from tierod.filters.delay import Delay
from tierod.filters.first_order import Differentiator, FirstOrderLowPass
from tierod.filters.hold import InputHold
from tierod.filters.jump_gate import JumpGate
from tierod.filters.play import Play

__all__ = ["Butterworth", "Delay", "Differentiator", "FirstOrderLowPass", "InputHold", "JumpGate", "Play"]
