"""Charts of studies: curves over a common axis, in one field or several."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from tierod.core.content import Chart, Lines, Mark, Panel

Curves = Mapping[str, tuple[np.ndarray, np.ndarray]]  # Places and values of every curve, by its name


def chart(
    name: str,
    title: str,
    note: str,
    said: str,
    fields: Mapping[tuple[str, str], Curves],
    along: str = "time (s)",
    every: int = 1,
    dashed: Collection[str] = (),
    marks: Collection[Mark] = (),
    logarithmic_along: bool = False,
) -> Chart:
    """A chart of curves.

    Args:
        note, said: what it shows, for a reader who sees it and for one who cannot
        fields: curves of every field, by its title and the text of its upright axis
        along: text of the common axis
        every: decimation of the curves
        dashed: names of the curves that are dashed
        marks: bands and points that are added to the first field
    """
    panels = []
    for number, ((head, unit), curves) in enumerate(fields.items()):
        lines = [Lines(label, x[::every], y[::every], label in dashed) for label, (x, y) in curves.items()]
        shown = (*lines, *(marks if number == 0 else ()))
        panels.append(Panel(head, along, unit, shown, logarithmic_along=logarithmic_along))
    return Chart(name, title, note, said, tuple(panels))
