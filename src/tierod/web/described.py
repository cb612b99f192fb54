"""Descriptions of the signals of a recording for the page: title, group, displayed unit, and meaning."""

from __future__ import annotations

from pathlib import Path

from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.report.display import words
from tierod.web.pyramid import Kept, SeriesReader
from tierod.web.shapes import SeriesShape, SignalShape

OTHERS, TRUTH = "Other channels", "Truth of a simulation"


def signal_shape(kept: Kept) -> SignalShape:
    """Description of a signal for the page.

    Args:
        kept: the stored signal
    """
    factor, label = shown(kept.unit)
    monitor, slash, estimate = kept.name.partition("/")
    known = SIGNALS.get(estimate if slash else kept.name.removeprefix("truth_"))
    if slash and kept.source.startswith("monitor "):
        group, title = f"Estimates of {monitor}", words(estimate)
    elif kept.name.startswith("truth_"):
        group, title = TRUTH, words(kept.name)
    else:
        group, title = (known.group, words(kept.name)) if known else (OTHERS, kept.name)
    return SignalShape(
        name=kept.name,
        title=title,
        group=group,
        unit=kept.unit,
        factor=factor,
        label=label,
        meaning=known.meaning if known else kept.note,
        positive=known.positive if known else "",
        source=kept.source,
        note=kept.note,
        count=kept.count,
    )


def series_shape(key: str, reader: SeriesReader) -> SeriesShape:
    """Descriptions of all signals of a recording for the page.

    Args:
        key: key in the store
        reader: reader of its signals
    """
    facts = {name: Path(str(each)).name if name == "path" else each for name, each in reader.facts.items()}
    return SeriesShape(
        key=key, span=reader.span, signals=[signal_shape(each) for each in reader.signals.values()], facts=facts
    )
