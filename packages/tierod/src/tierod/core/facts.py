"""Facts about a drive beside the verdict of a monitor, and the one place where both become a finding."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from tierod.core.findings import Estimate, Finding, Status
from tierod.core.shown import plus_minus

# Placeholder in a text for the estimate with its standard deviation, which other facts may still widen
ESTIMATE = "{estimate}"


@dataclass(frozen=True)
class Fact:
    """Something that explains, limits or accompanies the verdict of a monitor."""

    name: str  # kind of the fact in a word or two ("late", "stuck", "obstacle")
    cause: str  # the fact as a sentence without a full stop; a warning where it limits nothing
    reason: str = ""  # the same in at most 8 words, for the headline; "" where another one says more
    action: str = ""  # remedy; "" where there is none
    # signals that it is about; it limits only monitors whose verdict rests on one of them
    rests_on: tuple[str, ...] = ()
    allows: Status | None = None  # best status of a verdict without an alarm that it still allows; None allows any
    doubts: bool = False  # whether an alarm is suspect at most
    explains: bool = False  # whether it comes first among the causes where nothing was identifiable
    withholds: bool = False  # whether it prevents any estimate

    def filled(self, **values: object) -> Fact:
        """The fact of a table of sentences with these values in the braces of its texts."""
        given = {"estimate": ESTIMATE, **values}
        cause, reason, action = (each.format(**given) for each in (self.cause, self.reason, self.action))
        return replace(self, cause=cause, reason=reason, action=action)

    def limited(self, status: Status) -> Status:
        """Status that it leaves of one without it; for an estimate, suspect is inconsistent."""
        if status.alarm:
            return status.doubted if self.doubts else status
        if self.allows is None or not status.judged:
            return status
        return status.doubted if self.allows.alarm else self.allows

    def bears_on(self, status: Status) -> bool:
        """Whether it is among the causes of a status that it has not lowered itself."""
        if status is Status.NOT_IDENTIFIABLE:
            return self.explains
        return status in (Status.SUSPECT, Status.INCONSISTENT) and self.allows is not None


@dataclass(frozen=True)
class Verdict:
    """What a monitor states over a recording, before the facts about signals, vehicle file and drive.

    `ESTIMATE` in a reason, a cause or a detail stands for the estimate.
    """

    monitor: str  # name of the monitor and its variant
    status: Status  # its status; that of a monitor that only estimates is never healthy or suspect
    because: tuple[Fact, ...] = ()  # facts that explain the status, the decisive one first, which gives the headline
    estimate: Estimate | None = None  # the estimated quantity; None where nothing could be estimated
    # times of the change [s], see `Finding`
    since: float | None = None
    evidence: dict[str, float] = field(default_factory=dict)  # named figures, with unit in the name
    details: tuple[str, ...] = ()  # further sentences about the estimate, such as the limits that it was compared with
    decided_by: tuple[str, ...] = ()  # names of the decision rules that raised the alarm
    declared: float | None = None
    end: float | None = None
    facts: tuple[Fact, ...] = ()  # further facts that the monitor has found, defects of its signals among them

    @property
    def cause(self) -> str:
        """Causes of the status, one after the other."""
        return "; ".join(each.cause for each in self.because if each.cause)


# Remedy for a defective signal
REPAIR = "repair the sensor and record again, or correct the entry in channel map or vehicle file and judge again"

# Remedy for a defect that prevents any estimate
REPLACE = (
    "correct scale or unit of the signal in the channel map, or its time stamps, or give the vehicle file of this car "
    "(tierod identify vehicle), and judge again"
)

GUESSES = "guesses"  # Name of the fact that uncertain parameters decide the verdict
LONGEST_REASON = 8  # Most words of a reason, so that a headline has 12 at most


def defect(names: tuple[str, ...], cause: str, reason: str = "", withholds: bool = False) -> Fact:
    """Defect of an input signal, which leaves no verdict healthy.

    Args:
        names: name of the signal; several where the defect cannot be isolated; empty where it is the vehicle file's
        cause, reason, withholds: see `Fact`; without a reason it is the first clause of the cause
    """
    reason = reason or shortened(cause) or f"{' or '.join(names[:3]) or 'the vehicle file'} may be wrong"
    status = Status.INCONSISTENT if withholds else Status.SUSPECT
    action = REPLACE if withholds else REPAIR
    limits = bool(names) or withholds
    return Fact(
        "defect", cause, reason, action, names, status if limits else None, limits, explains=limits, withholds=withholds
    )


def shortened(cause: str) -> str:
    """First clause of a cause as a reason; empty where it is too long for a headline, or begins a list."""
    clause = re.split(r"; |: | \(|, ", cause, maxsplit=1)[0]
    return clause if 3 <= len(clause.split()) <= LONGEST_REASON else ""


class Weighed(NamedTuple):
    """Status of a verdict among facts, and those of the facts that are its causes."""

    status: Status
    causes: tuple[Fact, ...]
    lowering: tuple[Fact, ...]


def weigh(verdict: Verdict, facts: Sequence[Fact] = (), needed: Collection[str] | None = None) -> Weighed:
    """Status that some facts leave of a verdict; see `assemble`."""
    return _weighed(*_distinct(verdict, facts), needed)


def _weighed(verdict: Verdict, facts: Sequence[Fact], needed: Collection[str] | None) -> Weighed:
    status, causes, lowering = verdict.status, [], []
    counting = [each for each in (*verdict.facts, *facts) if _counts(each, needed)]
    hidden = [each for each in counting if each.withholds and each.allows] if verdict.estimate is not None else []
    if hidden:
        status = hidden[0].allows or status
        counting = [each for each in counting if each in hidden or each.rests_on]
    for each in counting:
        after = each.limited(status)
        if after is not status or each.bears_on(status) or each in hidden:
            causes.append(each)
        if after is not status or each in hidden:
            lowering.append(each)
        status = after
    return Weighed(status, tuple(causes), tuple(lowering))


def assemble(
    subject: str, verdict: Verdict, facts: Sequence[Fact] = (), needed: Collection[str] | None = None
) -> Finding:
    """The finding of a verdict among facts: status, headline, cause, action, details and warnings.

    Args:
        facts: facts found outside the monitor; they limit after its own, and are named before them
        needed: signals that the verdict rests on; None lets every fact limit it
    """
    verdict, facts = _distinct(verdict, facts)
    status, counted, lowering = _weighed(verdict, facts, needed)
    said = "; ".join(each.cause for each in (*verdict.because, *verdict.facts))
    new = [each for each in facts if each in lowering or not _told(each, said, verdict.because)]
    others = list(dict.fromkeys((*new, *verdict.facts)))
    causes = [each for each in others if each in counted]
    withheld = verdict.estimate is not None and any(each.withholds for each in causes)
    own = () if withheld or (lowering and verdict.status.quiet) else verdict.because
    cause = "; ".join(dict.fromkeys(each.cause for each in (*causes, *own) if each.cause))
    # A doubt of its own that the monitor gives with a remedy outlives what lowers the verdict.
    doubts = [each for each in verdict.because if each not in own and each.cause and not _idle(each.action)]
    beside = [each for each in dict.fromkeys((*verdict.facts, *new)) if each not in causes]
    beside += [] if withheld else doubts
    actions = [each.action for each in causes]
    # What could limit a verdict but does not needs no remedy now.
    mere = [each for each in beside if each.allows is None and not each.explains]
    actions += [each.action for each in mere if not any(name in cause for name in each.rests_on)]
    actions += [each.action for each in own]
    brief = _brief(verdict)
    reason = next((each.reason for each in causes if each.reason), "" if lowering else brief)
    details = verdict.details
    if lowering:
        details = (f"ignoring this: {verdict.status}{brief and f', {brief}'}", *details)
    estimate = None if withheld else verdict.estimate
    finding = Finding(
        verdict.monitor,
        status,
        f"{subject}: {status}{reason and f', {reason}'}",
        verdict.since,
        estimate,
        verdict.evidence,
        cause,
        _joined(actions),
        tuple(dict.fromkeys(each.cause for each in beside if each.cause)),
        verdict.decided_by,
        verdict.declared,
        verdict.end,
        () if withheld else details,
    )
    return finding if estimate is None else _filled(finding, estimate)


def _counts(fact: Fact, needed: Collection[str] | None) -> bool:
    return needed is None or not fact.rests_on or any(name in needed for name in fact.rests_on)


def _distinct(verdict: Verdict, facts: Sequence[Fact]) -> tuple[Verdict, tuple[Fact, ...]]:
    """Without a second doubt about the same signal; one that withholds the estimate is kept, then the first found."""
    named: set[str] = set()
    dropped = []
    for each in sorted((*facts, *verdict.facts), key=lambda fact: not fact.withholds):
        if each.doubts and each.rests_on and named.intersection(each.rests_on):
            dropped.append(each)
        elif each.doubts:
            named.update(each.rests_on)
    own = tuple(each for each in verdict.facts if each not in dropped)
    return replace(verdict, facts=own), tuple(each for each in facts if each not in dropped)


def _told(fact: Fact, said: str, because: Sequence[Fact]) -> bool:
    own = any(each.cause and each.cause in fact.cause for each in because)
    return own or any(each and each in said for each in (fact.cause, fact.reason))


def _brief(verdict: Verdict) -> str:
    if reason := next((each.reason for each in verdict.because if each.reason), ""):
        return reason
    value = ESTIMATE if verdict.estimate is not None and verdict.status.judged else ""
    return " ".join(filter(None, (value, "" if verdict.since is None else f"since {verdict.since:.0f} s")))


def _joined(actions: Iterable[str]) -> str:
    """Remedies one after the other; that nothing is to be done is said only where there is no other."""
    every = [each for each in dict.fromkeys(actions) if each]
    some = [each for each in every if not _idle(each)]
    return "; ".join(some or every[:1])


def _idle(action: str) -> bool:
    return action in ("", "none") or action.startswith("none;")


def _filled(finding: Finding, estimate: Estimate) -> Finding:
    value = plus_minus(estimate.value, estimate.standard_deviation, estimate.unit)
    return replace(
        finding,
        headline=finding.headline.replace(ESTIMATE, value),
        cause=finding.cause.replace(ESTIMATE, value),
        details=tuple(each.replace(ESTIMATE, value) for each in finding.details),
        warnings=tuple(each.replace(ESTIMATE, value) for each in finding.warnings),
    )
