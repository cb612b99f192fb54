"""Detection delay of a block for a shift that is added to fault-free residuals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tierod.core.block import Block
from tierod.core.errors import InputError
from tierod.core.graph import scan

TRIALS = 200


def delays_of(
    block: Block, records: Sequence[np.ndarray], shift: float, trials: int = TRIALS, seed: int = 0
) -> np.ndarray:
    """Samples from the start of a shift to the alarm, for many starts; infinite where the shift is not detected.

    Args:
        block: with an output `alarm`; it first runs over the residuals before the shift
        records: fault-free residuals, (n,) each; the longest one is used
        shift: added to the residual [its unit]

    A start at which the block already is in alarm is left out: that alarm is a false one. A shift that is not detected
    within half of the record, or within 20 000 samples, counts as not detected.

    Raises:
        InputError: records too short to add shifts, or the block is in alarm throughout
    """
    longest = max(records, key=len, default=np.zeros(0))
    if len(longest) < 200:
        raise InputError(f"the longest residual has {len(longest)} samples; expected 200 or more to insert shifts")
    random = np.random.default_rng(seed)
    reach = min(len(longest) // 2, 20_000)
    delays = []
    for start in random.integers(len(longest) // 10, len(longest) - reach, trials):
        before = scan(block, longest[max(start - reach, 0) : start])
        if before["alarm"][-1] > 0.5:
            continue
        alarms = np.flatnonzero(scan(block, longest[start : start + reach] + shift, before.state)["alarm"] > 0.5)
        delays.append(float(alarms[0] + 1) if len(alarms) else np.inf)
    if not delays:
        raise InputError("the detector is in alarm wherever a shift is inserted; allow fewer false alarms")
    return np.array(delays)
