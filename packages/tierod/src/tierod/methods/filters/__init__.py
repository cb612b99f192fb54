"""Filters of several signals at once: blocks that filter all signals alike and bridge short gaps."""

from tierod.methods.filters.butterworth import Butterworth
from tierod.methods.filters.each import InputHold
from tierod.methods.filters.first_order import Differentiator, FirstOrderLowPass
from tierod.methods.filters.jump_gate import JumpGate

__all__ = ["Butterworth", "Differentiator", "FirstOrderLowPass", "InputHold", "JumpGate"]
