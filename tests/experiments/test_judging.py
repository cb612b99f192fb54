"""What becomes of a monitor's verdict when it is held against the truth."""

import math

import numpy as np
import pytest

from tierod.core.facts import Verdict
from tierod.core.recording import Channel, Recording
from tierod.core.statuses import Status
from tierod.monitors.session import Conclusion, Monitor, StatusChange, Variant
from tierod.vehicles import load
from tierod_lab.campaign.judging import Window, judge

NOT_READY, HEALTHY, RISING, FAULT = Status.NOT_READY, Status.HEALTHY, Status.RISING, Status.FAULT


class Scripted:
    """A session that says what the test wants, and is enabled every second second."""

    signals = ("vehicle_speed",)
    traces = {"x": "", "x_standard_deviation": "", "enabled": ""}  # noqa: RUF012

    def __init__(self, course, final):
        self.course, self.final = tuple(StatusChange(*change) for change in course), final

    def refuse(self, aligned):
        pass

    def absorb(self, aligned):
        enabled = (np.floor(aligned.time + 1e-9) % 2 == 0).astype(float)
        return {
            "x": 1.0 + 0.1 * np.sin(aligned.time),
            "x_standard_deviation": np.ones(len(enabled)),
            "enabled": enabled,
        }

    def conclude(self):
        return Conclusion(Verdict("scripted", self.final), course=self.course)


def judged(course, final, fault=None, settling=0.0, truth=1.0):
    variant = Variant("v", "", "", lambda vehicle, rate, baseline: Scripted(course, final))
    monitor = Monitor("m", "", "", "", ("vehicle_speed",), (), 10.0, 1.0, 0.5, {"v": variant}, "v")
    time = np.arange(1000) / 10.0
    channels = [
        Channel("vehicle_speed", time, 20.0 + np.sin(time), "m/s"),
        Channel("truth_x", time, np.where(time < 60.0, truth, truth + 2.0), ""),
    ]
    recording = Recording({channel.name: channel for channel in channels})
    return judge(recording, (monitor, variant), load("midsize-eps"), None, fault, settling)[0]


QUIET = [(0.0, NOT_READY), (20.0, HEALTHY)]


def test_a_quiet_drive():
    found = judged(QUIET, HEALTHY)
    assert (found.status, found.outcome, found.false_alarms) == ("healthy", "quiet", 0)
    assert found.seconds == pytest.approx(100.0)
    assert (found.enabled_s, found.judged_s) == pytest.approx((50.0, 80.0))
    assert (found.fault_free_s, found.fault_free_judged_s) == pytest.approx((100.0, 80.0))
    assert math.isnan(found.detection_s)
    assert found.errors_faulty.count == 0


def test_a_fault_that_is_found():
    found = judged([*QUIET, (65.0, RISING), (75.0, FAULT)], FAULT, Window(60.0, math.inf))
    assert found.outcome == "found"
    assert (found.detection_s, found.fault_s) == pytest.approx((5.0, 15.0))
    assert found.detection_enabled_s == pytest.approx(3.0, abs=0.11)
    assert found.false_alarms == 0
    assert (found.fault_free_s, found.fault_free_judged_s) == pytest.approx((60.0, 40.0))


def test_an_alarm_before_the_fault_is_false_and_is_no_detection_while_it_stands():
    fault = Window(60.0, math.inf)
    stood = judged([*QUIET, (50.0, RISING), (70.0, FAULT)], FAULT, fault)
    assert (stood.outcome, stood.false_alarms, stood.detection_s) == ("early", 1, math.inf)
    gone = judged([*QUIET, (30.0, RISING), (40.0, HEALTHY), (70.0, RISING)], RISING, fault)
    assert (gone.outcome, gone.false_alarms, gone.detection_s) == ("found", 1, pytest.approx(10.0))


def test_errors_are_those_of_settled_estimates_while_the_monitor_judges():
    found = judged(QUIET, HEALTHY, Window(60.0, math.inf), settling=5.0)
    time = np.arange(1000) / 10.0
    estimate = 1.0 + 0.1 * np.sin(time)
    fault_free = estimate[(time >= 20.0) & (time < 60.0)] - 1.0
    assert found.errors_fault_free.count == 400
    assert found.errors_fault_free.mean == pytest.approx(fault_free.mean())
    assert found.errors_fault_free.deviation == pytest.approx(fault_free.std())
    # Enabled every second second: five enabled seconds after 60 s are over at 69 s.
    assert found.errors_faulty.count == pytest.approx(310, abs=1)
    assert found.errors_faulty.mean == pytest.approx(-2.0, abs=0.05)
    assert (found.truth_fault_free, found.truth_faulty) == pytest.approx((1.0, 3.0))
    assert len(found.estimates_fault_free) == 8
