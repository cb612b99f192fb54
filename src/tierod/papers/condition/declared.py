"""What a diagnosis says of one drive, sample by sample: the one form in which all variants are scored."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

NOTHING: Mapping[str, np.ndarray] = {}


class Declared(NamedTuple):
    """A diagnosis over time; elements that a mapping lacks are as if nothing were ever said of them.

    Args:
        time: of the samples
        faulty: by element, whether it is declared faulty, and nothing else could be it
        candidates: by element, whether it is one of several that are named together as "one of these"
        not_testable: by element, whether it is said that its state cannot be told now
        kind: by element, the kind that is named, "" for none; meaningful while it is faulty
        size: by element, the size that is named, in the unit of `faults.Injected`; NaN for none
        value: by sensor, what is given in its place, in its unit
        deviation: by element, the standard deviation of the size that is told with it
    """

    time: Annotated[Any, "s"]
    faulty: Mapping[str, np.ndarray]
    candidates: Mapping[str, np.ndarray] = NOTHING
    not_testable: Mapping[str, np.ndarray] = NOTHING
    kind: Mapping[str, np.ndarray] = NOTHING
    size: Mapping[str, np.ndarray] = NOTHING
    value: Mapping[str, np.ndarray] = NOTHING
    deviation: Mapping[str, np.ndarray] = NOTHING

    def since(self, place: int) -> Declared:
        """What is said from one sample on."""
        parts = (getattr(self, name) for name in self._fields[1:])
        return Declared(self.time[place:], *({key: each[place:] for key, each in part.items()} for part in parts))

    def said(self, which: str, element: str) -> np.ndarray:
        """One of the mappings of truth values for one element; false everywhere where it is lacking."""
        found = getattr(self, which).get(element)
        return np.zeros(len(self.time), bool) if found is None else np.asarray(found, bool)
