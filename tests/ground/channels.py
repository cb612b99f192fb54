"""Run a block of the proving ground without sensors, and read its signals by name."""

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import scan
from tierod_lab.ground.recorder import channel_names

ONES = ("road.adhesion_left", "road.adhesion_right", "road.support", "demand.grip")
"""What is one unless said otherwise, as are the gains of ports; all else is zero."""


class Run:
    """A block's outputs over `count` steps; sub-sampled signals are interleaved.

    Args:
        block: to be run
        count: of steps
        state: to begin with; the block's own where None
        inputs: a number or an array of `count` each; `demand__x` names the column demand.x
    """

    def __init__(self, block, count, state=None, **inputs):
        names = [name for name, _ in leaves(skeleton(block.Sample))]
        inputs = {name.replace("__", "."): value for name, value in inputs.items()}
        assert inputs.keys() <= set(names), sorted(inputs.keys() - set(names))
        samples = np.zeros((count, len(names)))
        for column, name in enumerate(names):
            samples[:, column] = inputs.get(name, 1.0 if name in ONES or name.endswith(".gain") else 0.0)
        self.result = scan(block, samples, state)
        self.columns = channel_names(block)

    def __getitem__(self, name):
        return self.result.values[:, self.columns[name]].reshape(-1)
