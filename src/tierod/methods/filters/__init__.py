"""Filters over several signals at once: blocks that treat them all alike and bridge short gaps."""

from tierod.methods.filters.butterworth import Butterworth
from tierod.methods.filters.delay import Delay
from tierod.methods.filters.first_order import Differentiator, FirstOrderLowPass
from tierod.methods.filters.hold import InputHold
from tierod.methods.filters.jump_gate import JumpGate
from tierod.methods.filters.play import Play

__all__ = ["Butterworth", "Delay", "Differentiator", "FirstOrderLowPass", "InputHold", "JumpGate", "Play"]
