"""The status byte of a trouble code."""

from __future__ import annotations

from enum import IntFlag


class CodeStatus(IntFlag):
    """Status bits of a trouble code.

    Source: ISO 14229-1:2020, annex D.2, DTC status bits.
    """

    TEST_FAILED = 0x01
    """The latest completed test failed."""
    FAILED_THIS_CYCLE = 0x02
    """A test failed in this operation cycle."""
    PENDING = 0x04
    """A test failed in this or the last operation cycle in which it was completed."""
    CONFIRMED = 0x08
    """The test failed in the cycles required for confirmation, and the code has not aged since."""
    NOT_COMPLETED_SINCE_CLEAR = 0x10
    """No test was completed since the memory was cleared."""
    FAILED_SINCE_CLEAR = 0x20
    """A test failed since the memory was cleared."""
    NOT_COMPLETED_THIS_CYCLE = 0x40
    """No test was completed in this operation cycle."""
    WARNING_REQUESTED = 0x80
    """The warning lamp is requested."""

    @property
    def words(self) -> tuple[str, ...]:
        """Names of the bits that are set."""
        return tuple((bit.name or "").lower().replace("_", " ") for bit in CodeStatus if bit in self)


CLEARED = CodeStatus.NOT_COMPLETED_SINCE_CLEAR | CodeStatus.NOT_COMPLETED_THIS_CYCLE
"""Status of a code that has never been tested."""


def after_test(status: CodeStatus, failed: bool) -> CodeStatus:
    """Status after a completed test; confirmation and lamp request are decided elsewhere."""
    status &= ~(CodeStatus.NOT_COMPLETED_SINCE_CLEAR | CodeStatus.NOT_COMPLETED_THIS_CYCLE)
    if not failed:
        return status & ~CodeStatus.TEST_FAILED
    return (
        status
        | CodeStatus.TEST_FAILED
        | CodeStatus.FAILED_THIS_CYCLE
        | CodeStatus.PENDING
        | CodeStatus.FAILED_SINCE_CLEAR
    )


def passed_this_cycle(status: CodeStatus) -> bool:
    """Whether a test was completed in this operation cycle and none failed."""
    return not status & (CodeStatus.NOT_COMPLETED_THIS_CYCLE | CodeStatus.FAILED_THIS_CYCLE)


def at_cycle_end(status: CodeStatus) -> CodeStatus:
    """Status at the end of an operation cycle: the pending bit is reset if the cycle passed."""
    return status & ~CodeStatus.PENDING if passed_this_cycle(status) else status


def at_cycle_start(status: CodeStatus) -> CodeStatus:
    """Status at the beginning of an operation cycle: no test completed yet."""
    return (status | CodeStatus.NOT_COMPLETED_THIS_CYCLE) & ~CodeStatus.FAILED_THIS_CYCLE
