"""Whether a diagnosis would take a recording: what it refuses, said before it runs."""

from __future__ import annotations

from collections.abc import Mapping

from tierod.core.errors import TierodError
from tierod.core.recording import Recording
from tierod.io.derive import complete, ingredients
from tierod.monitors.harness.quality_over_chunks import QualityOverChunks
from tierod.monitors.harness.running import opened
from tierod.monitors.harness.session import Monitor, Variant
from tierod.monitors.harness.suitable import refuse_unsuitable
from tierod.vehicles import Vehicle

SEEN = 1.0
"""Seconds of a recording that a session sees before it refuses it."""


def refusals(monitor: Monitor, vehicle: Vehicle | None, recording: Recording) -> Mapping[str, str]:
    """By the name of every variant, why a diagnosis would refuse the recording; "" where it would run.

    Args:
        monitor: that is asked for
        vehicle: as which it would be judged; None where none is given, so that only the signals are checked
        recording: the whole
    """
    whole = complete(recording, [*monitor.required, *monitor.optional])
    return {variant.name: _refusal(monitor, variant, vehicle, whole) for variant in monitor.variants.values()}


def taken(monitor: Monitor, reasons: Mapping[str, str]) -> tuple[str, ...]:
    """The variants that would run: the default first, where the monitor has one.

    Args:
        monitor: that is asked for
        reasons: as of `refusals`
    """
    free = [name for name, reason in reasons.items() if not reason]
    return tuple(sorted(free, key=lambda name: name != monitor.default))


def _refusal(monitor: Monitor, variant: Variant, vehicle: Vehicle | None, whole: Recording) -> str:
    suited = monitor.needing(variant).suited_to(whole)
    if not any(name in whole for name in (*suited.required, *suited.optional)):
        return "the recording has none of its signals"
    try:
        refuse_unsuitable(suited, vehicle, whole)
        quality = QualityOverChunks(ingredients(suited.required))
        quality.add(whole)
        quality.refuse_slow(suited.required, suited.minimum_rate)
        quality.refuse_unusable(suited.required)
        if vehicle is not None:
            session, start = opened(suited, variant, vehicle), whole.span[0]
            age = suited.maximum_age
            session.refuse(whole.align(session.signals, suited.rate, maximum_age=age, start=start, stop=start + SEEN))
            # Whether the recording is a condition test shows only at its end; such recordings are short.
            if monitor.condition:
                session.absorb(whole.align(session.signals, suited.rate, maximum_age=age))
                session.conclude()
    except TierodError as error:
        return str(error)
    return ""
