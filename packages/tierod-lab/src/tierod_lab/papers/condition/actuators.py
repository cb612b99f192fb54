"""Tests of the actuators: half or all torque lost, with an alternating or a fixed split between the motors."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product

import numpy as np

from tierod.core.claims import Claim, Goal, at_least, at_most, exactly
from tierod.core.content import Chart, Heading, Item, Panel, Points, Table
from tierod_lab.papers.condition import causes, tables
from tierod_lab.papers.condition.drives import ACTUATORS, Drive, actuator_tests, supply_tests
from tierod_lab.papers.condition.reported import vehicles
from tierod_lab.papers.condition.runs import BEST, VARIANTS, scores
from tierod_lab.papers.condition.scoring import AMBIGUOUS, DriveScore
from tierod_lab.papers.condition.sensors import GOAL, longest
from tierod_lab.papers.condition.summary import Isolated, injected_name, isolated, summary
from tierod_lab.studies.effort import Effort

TEXT = (
    "Both steering motors and a drive on three rounds, 200 s each, without torque from 104 s on: nine tests, with "
    "every vehicle; the paper has nine too, and does not list them. Half the torque lost follows. The steering "
    "torque is split 65 to 35 between the motors, and back, every 0.12 s; the last table has a fixed split.",
    "A lost torque is observable only while torque is commanded: its delay is the observable time before it is "
    "declared. Where the drive asks for much torque for a moment, for none over a second, and for much again, that "
    "second carries no information; the delay that includes it is printed as that from the first moment.",
)

SUPPLY = (
    "Both steering motors, and both drives, lose all torque or half of it at once, as where their supply or their "
    "enabling fails: six tests with every vehicle. Half the torque of both is all the torque of one until the split of "
    "the motors changes, or a drive turns the vehicle; with a fixed split half of both is not isolable from one.",
)

PAUSES = "It holds the time in which no torque is asked for, and a lost one makes no difference."
ONE_OR_BOTH = (
    "Half of both is all of one until the split changes, or a drive turns the vehicle; more excitation mends it."
)
PLACES = tuple(name.replace("_", " ") for name in ACTUATORS)


def campaign(effort: Effort, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """Tests with one actuator lost, on all vehicles; a few tests on one vehicle if quick.

    Args:
        share: lost share of the torque [-]
        swing: whether the split of the steering torque alternates
    """
    drives = [drive for number in vehicles(effort) for drive in actuator_tests(number, share, swing)]
    return drives[::8] if effort.quick else drives


def supply_campaign(effort: Effort, share: float = 1.0, swing: bool = True) -> list[Drive]:
    """Tests with both motors or both drives lost, on all vehicles; on one round of one vehicle if quick.

    Args:
        share: share of the torque that both lose [-]
        swing: whether the split of the steering torque alternates
    """
    drives = [drive for number in vehicles(effort) for drive in supply_tests(number, share, swing)]
    return drives[:2] if effort.quick else drives


def items(effort: Effort) -> Iterator[Item]:
    if not VARIANTS:
        return
    found, partial = scores(campaign(effort), effort), scores(campaign(effort, 0.5), effort)
    yield Heading("The tests of the actuators", TEXT)
    yield tables.compared("All torque lost", found)
    yield tables.compared("Half the torque lost", partial)
    yield tables.by_group(
        "Accuracy by actuator (Figure 25), mean / worst", found, lambda each: each.drive.injected[0].element, "actuator"
    )
    yield _figure_twenty_five(found)
    for name, several in found.items():
        yield tables.confused(f"What went by which name: {VARIANTS[name].title}", several)
    if BEST in found:
        shares = {"all torque": _that_lose(1.0), "half the torque": _that_lose(0.5)}
        yield tables.delays("Delay [s]", [*found[BEST], *partial[BEST]], shares)
        yield from _claims(found[BEST], partial[BEST])
        fixed = scores(campaign(effort, 0.5, False), effort, (BEST,))
        yield tables.confused("Half the torque lost, with a fixed split", fixed[BEST])
        yield from _fixed("fixed-split", "a steering motor's", fixed[BEST])
        yield from _of_supplies(effort)


def _of_supplies(effort: Effort) -> Iterator[Item]:
    found = {}
    for (name, share), swing in product({"all torque": 1.0, "half the torque": 0.5}.items(), (True, False)):
        title = name if swing else f"{name}, with a fixed split"
        found[title] = scores(supply_campaign(effort, share, swing), effort, (BEST,))[BEST]
    yield Heading("Both motors, both drives", SUPPLY)
    rows = tuple(
        (title, str(len(of)), *(f"{part:.3f}" for part in isolated(of)), f"{longest(summary(of).delays_excited):.2f}")
        for title, of in found.items()
    )
    header = ("lost", "drives", *Isolated._fields, "longest delay [s]")
    yield Table("Two actuators at once, by what was named", header, rows)
    for title, of in found.items():
        yield tables.named(f"Both lose {title}", of)
    whole, half = found["all torque"], found["half the torque"]
    both = [*whole, *half]
    named = "Both named, and nothing else, where both lost torque."
    yield _claim("both-named", named, isolated(both).right, at_least(1.0), causes.misnamed(both))
    late = "Longest delay where both lost {}, over the time in which it is observable."
    late_whole, late_half = (longest(summary(of).delays_excited) for of in (whole, half))
    yield _claim("both-delay", late.format("all torque"), late_whole, at_most(0.3), _excited(whole), "s")
    both_half = f"{_excited(half)} {ONE_OR_BOTH}"
    yield _claim("both-half-delay", late.format("half the torque"), late_half, at_most(0.54), both_half, "s")
    size = "Error of the share that both lost."
    yield _claim("both-size", size, summary(both).size_error, at_most(0.1), causes.sizes(both))
    yield from _fixed("both-fixed-split", "both steering motors'", found["half the torque, with a fixed split"])


def _that_lose(share: float) -> Callable[[DriveScore], bool]:
    return lambda each: each.drive.injected[0].size == share


def _figure_twenty_five(found: tables.Scores) -> Chart:
    marks = []
    for name, several in found.items():
        parts = [summary([each for each in several if each.drive.injected[0].element == one]) for one in ACTUATORS]
        accuracy = np.array([part.accuracy for part in parts])
        marks.append(Points(VARIANTS[name].title, PLACES, accuracy, np.array([part.worst for part in parts]), accuracy))
    return Chart(
        "condition-accuracy-actuators",
        "Accuracy by actuator (Figure 25)",
        "Mean over the tests of each actuator; the line reaches down to the worst test.",
        "Accuracies of four actuators by several diagnoses.",
        (Panel("accuracy", "actuator", "accuracy", tuple(marks)),),
    )


def _claim(key: str, claim: str, measured: float, goal: Goal, cause: str, unit: str = "") -> Claim:
    return Claim(f"actuators.{key}", claim, GOAL, None, measured, goal, unit, cause=cause)


def _claims(whole: Sequence[DriveScore], half: Sequence[DriveScore]) -> Iterator[Claim]:
    for key, what, of, limit in (("lost", "all torque", whole, 0.25), ("half", "half the torque", half, 0.54)):
        known = summary(of)
        late, plain = longest(known.delays_excited), longest(known.delays_shown)
        accuracy = f"Mean accuracy with {what} lost."
        yield _claim(f"{key}-accuracy", accuracy, known.accuracy, at_least(0.99), causes.wrong_time(of))
        once, excited = f"Longest delay with {what} lost, over the time in which it is observable.", _excited(of)
        yield _claim(f"{key}-delay", once, late, at_most(limit), excited, "s")
        first = f"Longest delay with {what} lost, from the first moment in which it is observable."
        pauses = f"{causes.late(of, lambda fault: fault.delay_shown)} {PAUSES} Without it: {excited}"
        yield _claim(f"{key}-delay-from-first", first, plain, at_most(limit), pauses, "s")
        strict = f"Missed, with {what} lost, seen by a likelihood-ratio test with true parameters."
        yield _claim(f"{key}-strict-missed", strict, known.strict.missed, exactly(0.0), causes.missed(of))
        size = f"Error of the share lost, with {what} lost."
        yield _claim(f"{key}-size", size, known.size_error, at_most(0.1), causes.sizes(of))
        named = f"Motor and side right, with {what} lost."
        yield _claim(f"{key}-named", named, isolated(of).right, at_least(1.0), causes.misnamed(of))
        yield _claim(f"{key}-missed", f"Missed, with {what} lost.", known.missed, exactly(0.0), causes.missed(of))


def _excited(of: Sequence[DriveScore]) -> str:
    return causes.late(of, lambda fault: fault.delay_excited)


def _fixed(key: str, whose: str, of: Sequence[DriveScore]) -> Iterator[Claim]:
    steering = [each for each in of if each.drive.injected[0].element.startswith("steering_motor")]
    right = [each for each in steering if each.named in (AMBIGUOUS, injected_name(each))]
    claim = f"With a fixed split half {whose} torque is named rightly, or as one of several."
    yield _claim(key, claim, len(right) / max(len(steering), 1), at_least(1.0), causes.misnamed(steering))
