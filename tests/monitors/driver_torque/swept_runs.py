"""Short runs of the swept bench, kept for the tests of the observers."""

from functools import lru_cache

import numpy as np

from tierod_lab.papers.column.benches import samples, swept


@lru_cache(maxsize=8)
def run(hands="ramps", seed=3, seconds=40.0):
    """What is measured, (n, 4), and all columns."""
    columns = swept(hands, seconds, seed)
    return samples(columns), columns


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))
