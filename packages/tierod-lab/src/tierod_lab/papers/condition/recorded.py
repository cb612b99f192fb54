"""Recordings of drives at 100 Hz, work over many drives in parallel, and the recordings of a calibration."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from functools import lru_cache, partial
from typing import Any, NamedTuple

import numpy as np

from tierod.core.recording import Channel, Recording
from tierod.core.signals import SIGNALS
from tierod_lab.ground.faults import injected
from tierod_lab.ground.run import Outcome, run
from tierod_lab.ground.sensors import SensorSet
from tierod_lab.papers.condition.drives import TARGETS, TORQUES, Drive, calibration_drives
from tierod_lab.papers.condition.vehicles import MEASURED, course
from tierod_lab.studies.effort import Effort

RATE = 100.0  # Sampling rate of all channels [Hz]

TRUTHS = {
    "truth_wheel_speed_rear_left": "m/s",
    "truth_wheel_speed_rear_right": "m/s",
    "truth_yaw_rate": "rad/s",
    "truth_steering_wheel_angle": "rad",
    "truth_steering_shaft_torque": "N*m",
    "truth_tie_rod_force": "N",
    "truth_speed": "m/s",
    "truth_sideslip_angle": "rad",
    "truth_longitudinal_acceleration": "m/s**2",
    "truth_lateral_acceleration": "m/s**2",
    "truth_steering_motor_1_torque": "N*m",
    "truth_steering_motor_2_torque": "N*m",
    "truth_drive_torque_left": "N*m",
    "truth_drive_torque_right": "N*m",
    "truth_bank_angle": "rad",
    "truth_grade_angle": "rad",
    "truth_road_friction": "",
    "truth_position_x": "m",
    "truth_position_y": "m",
    "truth_lateral_offset": "m",
}
"""True signals that are kept beside the measured ones -> unit."""

UNITS = {name: SIGNALS[name].unit for name in MEASURED} | TRUTHS  # Channel -> unit, for all channels of a recording


def outcome(drive: Drive) -> Outcome:
    """Simulates a drive and returns the complete outcome of the proving ground."""
    car, sensors = drive.driven
    way = course(drive.course, drive.seconds, drive.seed)
    return run(car, way, drive.seconds, drive.seed, sensors, [each.fault for each in drive.injected])


def recorded(drive: Drive) -> Recording:
    """The recording of a drive: `MEASURED` and `TRUTHS` on one time grid of 100 Hz.

    Faults that affect the recording alone are injected into the recording of the drive without them, so that several
    drives share one simulation.
    """
    late = tuple(each for each in drive.injected if each.in_recording_alone)
    driven = replace(drive, injected=tuple(each for each in drive.injected if not each.in_recording_alone))
    base = _driven(driven)
    truth = {"drive": drive.name, "faults": [asdict(each) for each in drive.injected]}
    if late:
        sensors = drive.driven.sensors
        base = injected(base, [each.fault for each in late], sensors, drive.seed)
    return replace(base, metadata={**base.metadata, **truth})


@lru_cache(maxsize=4)
def _driven(drive: Drive) -> Recording:
    return as_recorded(outcome(drive).recording)


def as_recorded(made: Recording) -> Recording:
    """Reduces a recording of the proving ground to `MEASURED` and `TRUTHS` on one time grid, as `recorded` does."""
    return _recording(_columns(made))


def _columns(made: Recording) -> dict[str, Any]:
    return {name: made[name].values.astype(np.float32) for name in (*MEASURED, *TRUTHS)}


def _recording(columns: dict[str, np.ndarray]) -> Recording:
    time = np.arange(len(columns[MEASURED[0]])) / RATE
    channels = {name: Channel(name, time, values.astype(float), UNITS[name]) for name, values in columns.items()}
    return Recording(channels, {"source": "tierod virtual test vehicle"})


def deviations(drive: Drive, recording: Recording) -> dict[str, np.ndarray]:
    """Deviation of every faulty element from its fault-free value at each sample.

    Returns:
        by element: reading of a sensor less that of a fault-free sensor without noise, in its unit; commanded less
        delivered torque of an actuator [N*m]
    """
    sensors = drive.driven.sensors
    found = {}
    for each in drive.injected:
        if each.element in TORQUES:
            found[each.element] = recording[TARGETS[each.element]].values - recording[truth(each.element)].values
        else:
            found[each.element] = recording[each.element].values - fault_free(each.element, recording, sensors)
    return found


def fault_free(sensor: str, recording: Recording, sensors: SensorSet) -> np.ndarray:
    """Readings of a sensor without fault and noise, but with its gain and bias, in its unit."""
    return sensors[sensor].gain * recording[f"truth_{sensor}"].values + sensors[sensor].bias


def truth(actuator: str) -> str:
    """Channel of the torque that an actuator delivers."""
    return f"truth_{TORQUES[actuator]}"


def each(work: Callable[[Drive, Recording], Any], drives: Sequence[Drive], effort: Effort) -> list[Any]:
    """Results of a function for every drive's recording, in the order of the drives.

    Args:
        work: importable function of drive and recording with picklable results, or a partial of one

    Raises:
        InputError: a drive failed, with the reason
    """
    return effort.made(partial(_worked, work), drives, lambda drive: f"the drive '{drive.name}'")


def _worked(work: Callable[[Drive, Recording], Any], drive: Drive) -> Any:
    return work(drive, recorded(drive))


QUICK_SECONDS = 80.0
"""Driving for the parameters of a quick study [s]; little more than a calibration requires at least."""
QUICK_DRIVES = 2  # Drives of ten minutes for the limits of a quick study; with fewer, limits cannot be designed


class CalibrationSet(NamedTuple):
    """Fault-free recordings of a vehicle for its calibration."""

    fitted: list[Recording]  # recordings for the parameters
    healthy: list[Recording]  # recordings for limits and thresholds


def calibration_set(number: int, quick: bool, drives: int = QUICK_DRIVES) -> CalibrationSet:
    """Five fault-free minutes and an hour of a vehicle; if quick, 80 s and a few drives of ten minutes.

    Args:
        drives: number of drives of ten minutes in a short set
    """
    first, hour = calibration_drives(number)
    first = replace(first, seconds=QUICK_SECONDS) if quick else first
    return CalibrationSet([recorded(first)], [recorded(each) for each in (hour[:drives] if quick else hour)])
