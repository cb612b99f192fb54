"""Coefficients of the residuals' models, by least squares on fault-free drives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tierod.core.errors import InputError
from tierod.core.graph import scan
from tierod.core.recording import Recording
from tierod.monitors.condition.signals import ConditionSample
from tierod_lab.papers.condition.rules.parameters import Coefficients
from tierod_lab.papers.condition.rules.residual_set import ResidualSet
from tierod_lab.papers.condition.rules.routes import steer_of_rolling

SETTLING = 2.0  # Warm-up of the filters at the start of every drive, which is left out [s]

FEWEST = 3000  # Smallest number of fault-free samples for a fit: half a minute at 100 Hz


def samples_of(recording: Recording) -> np.ndarray:
    """Samples of a recording in the columns of `ConditionSample`, (n, 14); NaN for a missing signal.

    Args:
        recording: recording with its channels on one time grid

    Raises:
        InputError: all signals are missing, or they are not on one time grid
    """
    names = [name for name in ConditionSample._fields if name in recording.channels]
    if not names:
        raise InputError("the recording has none of the signals of the condition monitor; map its channels first")
    lengths = {len(recording[name].values) for name in names}
    if len(lengths) > 1:
        raise InputError(f"the signals have {sorted(lengths)} samples; align them on one grid first")
    columns = np.full((lengths.pop(), len(ConditionSample._fields)), np.nan)
    for column, name in enumerate(ConditionSample._fields):
        if name in names:
            columns[:, column] = recording[name].values
    return columns


def fit_coefficients(block: ResidualSet, drives: Sequence[np.ndarray]) -> Coefficients:
    """The coefficients of eqs (11) and (46), and the understeer, by least squares.

    Args:
        block: residuals whose filters and parameters are used; its coefficients have no effect
        drives: fault-free drives, columns of `ConditionSample`

    Raises:
        InputError: too little driving
    """
    torque, force, angle, drive = _Equations(6), _Equations(4), _Equations(2), _Equations(4)
    for samples in drives:
        steer = scan(block.steering, samples[:, [3, 4, 5, 7]])
        columns: dict[str, np.ndarray] = {name: steer[name] for name in block.steering.Output._fields}
        left, right, yaw, turned = samples[:, :4].T
        late = round(SETTLING / block.steering.sample_time)
        use = np.isfinite(samples[:, :8]).all(axis=1) & (np.maximum(left, right) > block.moving)
        use[:late] = False
        ones = np.ones(len(samples))
        motion = [columns["angle"], columns["rate"], columns["acceleration"], columns["direction"]]
        across = columns["lateral_acceleration"]
        torque.add([*motion, across, ones], columns["torque"], use)
        force.add([block.car.mass * across, columns["torque"], columns["direction"], ones], columns["force"], use)
        speed, along, asked = 0.5 * (left + right), samples[:, 6], samples[:, 10] + samples[:, 11]
        sides = samples[:, 7] * block.car.steering_ratio * turned
        wanted = asked / block.car.wheel_radius
        drive.add([along, ones, speed * speed, sides], wanted, use & np.isfinite(asked))
        rolling = steer_of_rolling(yaw, left, right, block.car)
        angle.add([speed * yaw, ones], block.car.steering_ratio * turned - rolling, use)
    turn, rate, acceleration, friction, cornering, torque_offset = torque.solved()
    per_mass, per_torque, rubbing, force_offset = force.solved()
    understeer, angle_offset = angle.solved()
    # Recordings may lack the targets of the drives.
    driven = drive.solved() if drive.samples >= FEWEST else [0.0] * 4
    return Coefficients(
        turn,
        rate,
        acceleration,
        friction,
        cornering,
        torque_offset,
        per_mass,
        per_torque,
        # Eq (46) subtracts friction from the torque before the factor `per_torque`; here it was fitted after it.
        force_friction=-rubbing / per_torque if per_torque else 0.0,
        force_offset=force_offset,
        understeer=understeer,
        angle_offset=angle_offset / block.car.steering_ratio,
        inertia=driven[0],
        resistance=driven[1],
        drag=driven[2],
        turning=driven[3],
    )


class _Equations:
    def __init__(self, count: int):
        self.left, self.right, self.samples = np.zeros((count, count)), np.zeros(count), 0

    def add(self, regressors: list[np.ndarray], wanted: np.ndarray, use: np.ndarray) -> None:
        rows = np.stack([each[use] for each in regressors])
        self.left += rows @ rows.T
        self.right += rows @ wanted[use]
        self.samples += int(use.sum())

    def solved(self) -> list[float]:
        if self.samples < FEWEST:
            raise InputError(
                f"{self.samples} samples of fault-free driving are too few to fit the residuals' models on; "
                f"give {FEWEST} or more while the vehicle moves"
            )
        return [float(each) for each in np.linalg.lstsq(self.left, self.right, rcond=1e-12)[0]]
