"""Rows of campaigns that never ran, for what is made of them."""

import math

from tierod_lab.campaign.figures import Moments
from tierod_lab.campaign.judging import FAULT_FREE, Judged, Row

STATUSES = {"found": "fault", "early": "fault", "false alarm": "suspect", "not judged": "not ready"}


def judged(outcome="quiet", **changes):
    """A judgement over ten minutes of driving, half of them before the fault if there is one."""
    faulty = outcome in ("found", "missed", "early")
    later = math.inf if faulty else math.nan
    values = {
        "status": STATUSES.get(outcome, "healthy"),
        "headline": "As the test wants.",
        "cause": "",
        "value": 8.0 if faulty else 4.0,
        "deviation": 0.2,
        "unit": "N*m",
        "ratio": math.nan,
        "outcome": outcome,
        **dict.fromkeys(("detection_s", "detection_enabled_s", "fault_s", "fault_enabled_s"), later),
        "false_alarms": 0,
        "seconds": 600.0,
        "enabled_s": 300.0,
        "judged_s": 480.0,
        "fault_free_s": 300.0 if faulty else 600.0,
        "fault_free_judged_s": 240.0 if faulty else 480.0,
        "truth_fault_free": 4.0,
        "truth_faulty": 8.0 if faulty else math.nan,
        "errors_fault_free": Moments(100, 0.1, 4.0),
        "errors_faulty": Moments(100, -0.3, 4.0) if faulty else Moments(),
        "area": 1.0 if faulty else math.nan,
        "estimates_fault_free": (3.9, 4.1, 4.3),
        "estimates_faulty": (7.5, 7.7, 7.9) if faulty else (),
    }
    return Judged(**values | changes)


def row(seed=1, fault=FAULT_FREE, size="", outcome="driven", monitor="friction", reason="", came=True, **judgement):
    """A row of a drive; `judgement` makes what was judged."""
    place = {"vehicle": "car", "fault": fault, "size": str(size), "seed": str(seed)}
    windows = [] if fault == FAULT_FREE else [{"start": 300.0 if came else None, "end": 600.0 if came else None}]
    drive = {"outcome": outcome, "reason": reason, "recording": None, "windows": windows, "last_good_s": None}
    if outcome != "driven" or reason:
        return Row(place, drive, monitor, None, reason)
    verdict = judgement.pop("verdict", "quiet" if fault == FAULT_FREE else "found")
    return Row(place, drive, monitor, judged(verdict, **judgement))
