"""What a drive says of all sensors and actuators together."""

import math

import numpy as np
import pytest

from monitors.condition.made_up_statements import PERIOD, declare, doubt, fault_free, place, span
from tierod.core.facts import assemble
from tierod.core.findings import Element, Episode, Status
from tierod.monitors.condition.accelerations import Difference
from tierod.monitors.condition.courses import ElementCourse
from tierod.monitors.condition.coverage import Covered
from tierod.monitors.condition.elements import SLID, Driven, code_courses, elements, losses
from tierod.monitors.condition.facts import Found, verdict_of_drive
from tierod.monitors.condition.kinds import LOST_TORQUE, OFFSET
from tierod.monitors.condition.reaction import NOT_ISOLABLE, substitution_graph
from tierod.monitors.condition.signals import ACTUATORS, FRONT_WHEELS, OF_AUTOMATED, TARGETS, ConditionSample
from tierod.monitors.condition.wiring import Problem

YAW, ANGLE, MOTOR = "yaw_rate", "steering_wheel_angle", "steering_motor_1"

OWN = (*OF_AUTOMATED, *ACTUATORS)


def finding_of(states, drive, **more):
    found = Found("condition, bank", states, drive, "fault of a sensor or actuator", **more)
    finding = assemble("Sensors and actuators", verdict_of_drive(found))
    assert len(finding.headline.split()) <= 12, finding.headline
    return finding


def concluded(
    change=lambda stated: None,
    seconds=20.0,
    speed=5.0,
    missing=(),
    problems=(),
    gone=(),
    multiples=None,
    parked=False,
    slid=0.0,
):
    """Elements, finding and code courses of a drive over which `change` alters what is stated.

    `missing` are never there, `gone` are not from 11 s on: their readings have ended a second before. The
    tyres slide for the first `slid` seconds.
    """
    time, stated = fault_free(seconds)
    change(stated)
    available = np.ones(stated.status.shape, bool)
    available[:, [place(name) for name in FRONT_WHEELS]] = False
    available[:, [place(name) for name in missing]] = False
    available[np.ix_(time >= 11.0 - 1e-9, [place(name) for name in gone])] = False
    values = np.full((len(time), len(ConditionSample._fields)), speed)
    drive = Driven(PERIOD)
    no = np.zeros(len(time), bool)
    sensors, targets = ([place(name) for name in names] for names in (OF_AUTOMATED, ACTUATORS))
    judged = available[:, sensors].any(axis=1) & available[:, targets].all(axis=1)
    drive.add(time, values, Covered(available, judged, no, no, no | parked, ~no))
    drive.add_low_grip(time, time < slid, values)
    drive.sources = {name: {substitution_graph().substitutes[name][0].name: 100} for name in OF_AUTOMATED}
    courses = {name: ElementCourse(name, PERIOD) for name in OWN}
    for name, course in courses.items():
        course.add(time, stated.where_available(available & judged[:, None], ~no), available[:, place(name)])
    lost = losses(courses, drive)
    states = elements(courses, drive, problems, substitution_graph(), lost, multiples or {})
    finding = finding_of(states, drive, problems=problems, lost=lost)
    return {each.name: each for each in states}, finding, code_courses(courses, drive.end)


def faulty(name, start, stop, kind=0.0, size=np.nan):
    def change(stated):
        declare(stated, span(start, stop), (name,), kind, size)

    return change


def doubtful(names, start, stop):
    def change(stated):
        doubt(stated, span(start, stop), names)

    return change


def both(*changes):
    def change(stated):
        for each in changes:
            each(stated)

    return change


def test_a_fault_free_drive():
    states, finding, courses = concluded()
    assert {each.status for each in states.values()} == {Status.HEALTHY}
    assert finding.status is Status.HEALTHY
    assert finding.headline == "Sensors and actuators: healthy, all 10 judged fault-free over 20 s"
    assert finding.evidence == {"seconds": 20.0, "moving_seconds": 20.0, "sensors_and_actuators_judged": 10.0}
    assert finding.warnings == ()
    assert [change.status for change in courses[NOT_ISOLABLE]] == [Status.HEALTHY]


@pytest.mark.parametrize(("spread", "stated"), [(0.2, 3.0), (0.3, None)])
def test_no_smallest_offset_is_stated_that_most_failed_sensors_would_not_reach(spread, stated):
    def rough(statements):
        statements.spread[:, place(ANGLE)] = spread

    element = concluded(rough, multiples={ANGLE: 15.0})[0][ANGLE]
    assert element.status is Status.HEALTHY
    assert element.smallest == (stated if stated is None else pytest.approx(stated))
    assert ("not most offsets" in element.cause) is (stated is None)


def test_a_faulty_sensor_has_size_substitute_and_code_and_the_finding_shows_it_in_usual_units():
    states, finding, courses = concluded(faulty(YAW, 5.0, 12.0, OFFSET, 0.3))
    assert states[YAW].trouble_code == "C1A32-64"
    deviation = math.degrees(substitution_graph().substitutes[YAW][0].deviation)
    assert states[YAW].substitute == f"filter of the others (± {deviation:.3g} °/s)"
    assert finding.headline == "Sensors and actuators: fault, yaw rate: positive offset of 17.2 °/s"
    assert finding.details == ("yaw rate sensor: positive offset of 17.2 °/s from 5.00 s to 12.00 s",)
    assert (finding.since, finding.estimate.value) == (5.0, 0.3)
    assert [change.status for change in courses["yaw-rate"]] == [Status.HEALTHY, Status.FAULT, Status.HEALTHY]
    assert states[ANGLE].status is Status.HEALTHY


def test_a_motor_that_lost_torque_is_reported_in_per_cent():
    states, finding, _ = concluded(faulty(MOTOR, 5.0, 20.0, LOST_TORQUE, 0.5))
    assert finding.details == ("steering motor 1: loss of torque of 50 % from 5.00 s on",)
    assert states[MOTOR].substitute == ""
    assert states[MOTOR].episodes[0].magnitude.value == pytest.approx(50.0)


def test_where_both_motors_lost_torque_what_feeds_both_is_looked_at_first():
    lost = [faulty(name, 5.0, 20.0, LOST_TORQUE, 1.0) for name in ("steering_motor_1", "steering_motor_2")]
    _, finding, _ = concluded(both(*lost))
    assert finding.action.startswith("check steering motor 1 and steering motor 2: the supply and the enabling of both")
    _, finding, _ = concluded(both(*lost, faulty(YAW, 7.0, 9.0)))
    assert "what feeds" not in finding.action
    _, finding, _ = concluded(lost[0])
    places = "the part itself, its wiring, its supply; and the channel of "
    places += "steering motor 1 target torque or steering motor 2 target torque"
    assert finding.action == f"check steering motor 1: {places}"
    assert (
        "the recorded targets (steering motor 1 target torque and steering motor 2 target torque) may be wrong instead"
        in finding.cause
    )


def test_more_than_three_faults_are_counted():
    changes = [faulty(YAW, start, start + 1.0) for start in (1.0, 4.0, 7.0, 10.0, 13.0)]
    _, finding, _ = concluded(both(*changes))
    assert finding.details[-1] == "and 2 more"


def test_lasting_doubt_is_reported_with_all_that_may_be_it():
    states, finding, courses = concluded(doubtful((YAW, ANGLE), 5.0, 7.0))
    assert finding.status is Status.SUSPECT
    assert finding.headline == "Sensors and actuators: suspect, yaw rate or steering wheel angle"
    assert finding.details == ("suspect from 5.00 s to 7.00 s: yaw rate or steering wheel angle",)
    assert (finding.since, finding.declared, finding.end) == pytest.approx((5.0, 5.0, 7.0))
    assert states[YAW].status is states[ANGLE].status is Status.SUSPECT
    assert states[YAW].trouble_code == "C1A3A-64"
    assert [(each.time, each.status) for each in courses[NOT_ISOLABLE]] == [
        (0.0, Status.HEALTHY),
        (pytest.approx(5.0), Status.SUSPECT),
        (pytest.approx(7.0), Status.HEALTHY),
    ]


def test_doubt_that_a_verdict_ends_is_no_doubt():
    states, finding, courses = concluded(both(doubtful((YAW, ANGLE), 5.0, 6.0), faulty(YAW, 6.0, 8.0)))
    assert states[ANGLE].status is Status.HEALTHY
    assert len(states[YAW].episodes) == 1
    assert finding.status is Status.FAULT
    assert [change.status for change in courses[NOT_ISOLABLE]] == [Status.HEALTHY]


def test_doubt_at_the_end_stays_open():
    _, _, courses = concluded(doubtful((YAW, ANGLE), 18.0, 20.0))
    assert [change.status for change in courses[NOT_ISOLABLE]] == [Status.HEALTHY, Status.SUSPECT]


def test_torques_of_one_balance_that_cannot_be_isolated_name_its_other_terms():
    _, finding, _ = concluded(doubtful(("steering_shaft_torque", MOTOR), 18.0, 20.0))
    assert finding.status is Status.SUSPECT
    assert "so may a wrong tie rod force" in finding.cause
    _, finding, _ = concluded(doubtful((YAW, ANGLE), 18.0, 20.0))
    assert "balance" not in finding.cause


def test_a_missing_sensor_is_named():
    states, finding, _ = concluded(missing=(YAW,))
    assert (states[YAW].status, states[YAW].cause) == (Status.NOT_AVAILABLE, "the recording has no yaw rate")
    assert finding.status is Status.HEALTHY
    assert "all 9 judged" in finding.headline
    assert finding.details == ("not judged: yaw rate (not in the recording)",)


def test_a_sensor_that_falls_silent_is_not_available_and_the_drive_is_not_plainly_fault_free():
    states, finding, _ = concluded(gone=(YAW,))
    assert (states[YAW].status, states[YAW].cause) == (
        Status.NOT_AVAILABLE,
        "no reading since 10.00 s; fault-free until then",
    )
    assert states[ANGLE].status is Status.HEALTHY
    assert (finding.status, finding.since) == (Status.NOT_AVAILABLE, pytest.approx(10.0))
    assert finding.headline.endswith("yaw rate: no reading since 10.00 s")
    assert finding.details == ("9 of 10 are fault-free",)


def test_all_sensors_that_fall_silent_leave_nothing_to_judge():
    states, finding, _ = concluded(gone=OF_AUTOMATED)
    assert {states[name].status for name in OF_AUTOMATED} == {Status.NOT_AVAILABLE}
    assert states[MOTOR].status is Status.NOT_TESTABLE
    assert states[MOTOR].cause == "no sensor gives a reading since 10.00 s; fault-free until then"
    assert finding.status is Status.NOT_AVAILABLE
    assert finding.cause == "no sensor gives a reading since 10.00 s"
    assert finding.details == ("nothing is judged from then on",)


def test_too_few_sensors_that_are_left_are_not_testable():
    states, finding, _ = concluded(_testable_until(10.2), gone=OF_AUTOMATED[:3])
    assert states[ANGLE].status is Status.NOT_TESTABLE
    assert "fewer than 4 sensors give a reading since 10.00 s" in states[ANGLE].cause
    assert finding.status is Status.NOT_AVAILABLE


@pytest.mark.parametrize(("missing", "named"), [((), 1), (OF_AUTOMATED[:3], 0)])
def test_a_slide_is_named_only_where_enough_sensors_show_one(missing, named):
    warnings = concluded(missing=missing, slid=10.0)[1].warnings
    assert sum(SLID in each for each in warnings) == named


def test_a_diagnosis_that_can_isolate_with_fewer_sensors_goes_on():
    assert concluded(gone=OF_AUTOMATED[:3])[0][ANGLE].status is Status.HEALTHY


def test_a_target_that_ends_leaves_nothing_to_judge():
    states, finding, _ = concluded(gone=(MOTOR,))
    assert (states[MOTOR].status, states[YAW].status) == (Status.NOT_AVAILABLE, Status.NOT_TESTABLE)
    assert "the target torque of steering motor 1 is not recorded" in states[YAW].cause
    assert finding.status is not Status.HEALTHY


def test_a_fault_that_was_found_before_stays_a_fault():
    states, finding, _ = concluded(faulty(YAW, 5.0, 9.0), gone=OF_AUTOMATED)
    assert (states[YAW].status, finding.status) == (Status.FAULT, Status.FAULT)
    assert states[ANGLE].status is Status.NOT_AVAILABLE


def test_what_ends_while_the_vehicle_is_parked_is_the_end_of_the_drive():
    states, finding, _ = concluded(gone=OF_AUTOMATED, parked=True)
    assert {each.status for each in states.values()} == {Status.HEALTHY}
    assert finding.status is Status.HEALTHY


def _testable_until(stop):
    def change(stated):
        stated.testable[span(stop, 20.0)] = False

    return change


def never_testable(stated):
    stated.testable[:] = False


@pytest.mark.parametrize(("speed", "cause"), [(0.0, "the vehicle stood"), (-3.0, "the vehicle reversed")])
def test_standing_and_reversing_are_causes(speed, cause):
    states, finding, _ = concluded(never_testable, speed=speed)
    assert {each.status for each in states.values()} == {Status.NOT_TESTABLE}
    assert finding.status is Status.NOT_TESTABLE
    assert finding.cause.startswith(cause)


def test_the_cause_of_what_is_there_goes_before_what_is_not():
    _, finding, _ = concluded(never_testable, speed=0.0, missing=(OF_AUTOMATED[0],))
    assert finding.status is Status.NOT_TESTABLE
    assert "the vehicle stood" in finding.cause


def test_too_little_to_show_is_a_cause_of_its_own():
    def change(stated):
        stated.testable[:, [place(YAW), place(MOTOR)]] = False

    states, _, _ = concluded(change)
    assert "its true value was near zero" in states[YAW].cause
    assert "the target torque was too small" in states[MOTOR].cause


def test_what_was_not_judged_stands_beside_its_own_cause():
    def change(stated):
        stated.testable[:, [place(ANGLE), place(MOTOR)]] = False

    _, finding, _ = concluded(change, missing=(YAW, "tie_rod_force"))
    assert finding.details == (
        "not judged: steering wheel angle (its true value was near zero, or the other signals did not determine it "
        "well enough); steering motor 1 (the target torque was too small); yaw rate and tie rod force (not in the "
        "recording)",
    )


def test_without_the_torque_sensor_nothing_shows_what_a_motor_gives():
    def change(stated):
        stated.testable[:, place(MOTOR)] = False

    states, _, _ = concluded(change, missing=("steering_shaft_torque",))
    assert states[MOTOR].cause == "its output cannot be checked without steering shaft torque"


def test_what_was_wired_wrongly_makes_nothing_testable():
    problem = Problem("sign", (YAW,), "the yaw rate has the wrong sign", "correct the channel map")
    states, finding, _ = concluded(faulty(YAW, 5.0, 20.0), problems=(problem,))
    assert {each.status for each in states.values()} == {Status.NOT_TESTABLE}
    assert not any(each.episodes for each in states.values())
    assert (finding.cause, finding.action) == (problem.cause, problem.action)


def slid(seconds, reversing=0.0, **causes):
    """The finding of a drive of 20 s of which some slid and some was in reverse, and of causes beside it."""
    time, stated = fault_free(20.0)
    drive, no = Driven(PERIOD), np.zeros(len(time), bool)
    there = np.ones(stated.status.shape, bool)
    values = np.full((len(time), len(ConditionSample._fields)), 5.0)
    values[time < reversing] = -2.0
    drive.add(time, values, Covered(there, ~no, no, no, no, ~no))
    drive.add_low_grip(time, time < seconds, values)
    courses = {name: ElementCourse(name, PERIOD) for name in OWN}
    for column, course in enumerate(courses.values()):
        course.add(time, stated, there[:, column])
    return finding_of(elements(courses, drive, (), substitution_graph(), {}, {}), drive, **causes)


def test_a_drive_that_slid_for_most_of_the_time_is_not_healthy():
    assert slid(4.0).status is Status.HEALTHY
    finding = slid(12.0)
    assert finding.status is Status.NOT_TESTABLE
    assert finding.cause.startswith("12 of 20 s of driving were not judged: the tyres slid")
    assert finding.action.startswith("drive on a dry road, below 6 m/s² lateral acceleration")


def test_of_a_slide_that_began_in_reverse_only_the_driving_forward_counts():
    assert slid(12.0, reversing=14.0).status is Status.HEALTHY
    assert slid(20.0, reversing=14.0).cause.startswith("6 of 6 s of driving were not judged: the tyres slid")


def test_an_element_that_alone_was_doubted_is_not_fault_free_and_the_time_is_named():
    states, finding, _ = concluded(doubtful((YAW,), 6.0, 8.0))
    assert states[YAW].status is Status.NOT_TESTABLE
    assert "exceeded the fault-free limit from 6.00 s to 8.00 s" in states[YAW].cause
    assert finding.status is Status.NOT_TESTABLE
    assert finding.details == ("9 of 10 are fault-free",)


def test_a_doubt_about_one_element_that_a_declaration_explains_is_not_told():
    states, finding, _ = concluded(both(doubtful((YAW,), 6.0, 6.9), faulty("tie_rod_force", 7.0, 9.0)))
    assert states[YAW].status is Status.HEALTHY
    assert finding.status is Status.FAULT


def test_inputs_that_disagree_with_others_are_named_beside_what_was_found():
    doubt = Difference(False, 3.0, 4.0, 9.0, 1.2)
    cause = slid(12.0, disagreeing={"lateral_acceleration": doubt}, asked=(TARGETS[2:],)).cause
    assert (
        "lateral acceleration may be the cause instead: it differs by 1.2 m/s² from yaw rate times speed from 4 s on"
        in cause
    )
    assert "target drive torque left and target drive torque right may be the cause instead" in cause
    sure = doubt._replace(sure=True)
    assert "instead" not in slid(12.0, disagreeing={"lateral_acceleration": sure}).cause


def test_an_acceleration_is_named_first_unless_what_it_is_compared_with_failed_long_before():
    def result(start):
        first = Episode("delay", start, None)
        other = Episode("off yaw rate times speed", 24.0, None)
        states = [
            Element("lateral_acceleration", "sensor", Status.FAULT, episodes=(other,)),
            Element("wheel_speed_rear_left", "sensor", Status.FAULT, episodes=(first,)),
        ]
        return finding_of(states, Driven(PERIOD)).details[0]

    assert result(2.7).startswith("wheel speed rear left sensor: delay")
    assert result(22.0).startswith("lateral acceleration sensor: off")
    assert result(60.0).startswith("lateral acceleration sensor: off")


def test_targets_that_disagree_are_named_where_nothing_is_declared():
    finding = slid(0.0, asked=(TARGETS[2:],))
    assert finding.status is Status.HEALTHY
    assert "target drive torque right: the targets contradict the acceleration" in finding.warnings[-1]
