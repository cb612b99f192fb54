"""How an entry of the fault memory moves on: with a failure, and when an operation cycle begins or ends."""

from __future__ import annotations

from tierod.diagnosis.entry import Entry
from tierod.diagnosis.status import CodeStatus, after_test, at_cycle_end, at_cycle_start, passed_this_cycle
from tierod.diagnosis.trouble_codes import TroubleCode


def failed(entry: Entry, code: TroubleCode) -> Entry:
    """The entry after its test has failed."""
    again = bool(entry.status & CodeStatus.FAILED_THIS_CYCLE)
    cycles = min(entry.failed_cycles + (not again), code.confirmation_cycles)
    status = after_test(entry.status, failed=True)
    if cycles >= code.confirmation_cycles:
        status |= CodeStatus.CONFIRMED
    if status & CodeStatus.CONFIRMED and code.lamp:
        status |= CodeStatus.WARNING_REQUESTED
    occurrences = entry.occurrences + (not entry.status & CodeStatus.TEST_FAILED)
    return entry.with_(
        status=status,
        verdict=1,
        occurrences=occurrences,
        failed_cycles=cycles,
        passed_cycles=0,
        healed=False,
        consequence_of="",
    )


def displaced(entry: Entry) -> Entry:
    """The entry after it made room for another: no longer kept, but what its test says now still stands."""
    gone = CodeStatus.PENDING | CodeStatus.CONFIRMED | CodeStatus.WARNING_REQUESTED
    return Entry(status=entry.status & ~gone, counter=entry.counter, verdict=entry.verdict)


def begun(entry: Entry) -> Entry:
    """The entry at the beginning of an operation cycle: tests start anew, what was found before stays."""
    return entry.with_(status=at_cycle_start(entry.status), counter=0, verdict=0)


def ended(entry: Entry, code: TroubleCode) -> Entry:
    """The entry at the end of an operation cycle: passed cycles let the lamp go, and then the code itself.

    A code that never asked for the lamp ages from its first passed cycle on. A cycle in which the test failed as the
    consequence of another is no step towards healing.
    """
    status = at_cycle_end(entry.status)
    if not passed_this_cycle(entry.status) or entry.consequence_of:
        return entry.with_(status=status)
    entry = entry.with_(status=status, failed_cycles=0, passed_cycles=entry.passed_cycles + 1)
    if not status & CodeStatus.CONFIRMED:
        return entry.with_(passed_cycles=0)
    if not entry.healed and not status & CodeStatus.WARNING_REQUESTED:
        entry = entry.with_(healed=True)
    if not entry.healed and entry.passed_cycles >= code.healing_cycles:
        return entry.with_(status=status & ~CodeStatus.WARNING_REQUESTED, healed=True, passed_cycles=0)
    if entry.healed and entry.passed_cycles >= code.aging_cycles:
        return Entry(status=status & ~CodeStatus.CONFIRMED)
    return entry
