"""Unknowns and outputs of the default friction estimator, and its noises and priors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from tierod.core.block import Scalar
from tierod.physics.tyre import turn_slip_stiffness


class Coefficients(NamedTuple):
    """Coefficients of the regression; also the shape of one row of it, of its variances and of its process noises.

    Args:
        finite, exponential, long: shares of the friction torque that build up with Dahl exponent 1/2, 1 and 2; their
            sum is the friction torque [N*m]. One of them may be negative where the true law lies outside the three
        log_dahl_angle: logarithm of their common Dahl angle [rad]
        aligning_gain: factor on the self-aligning torque of the vehicle file
        trail_drop: change of that factor per torque at the steering wheel, as the pneumatic trail shrinks
        weight_lever: lever of the front axle load, which turns the wheels back to straight ahead
        turn_slip: turn slip stiffness of both front tyres over the load of their axle
        drive_share: factor on the torque that the whole drive and brake force, at the front axle, would exert on the
            steered wheels through the trail of the vehicle file
        load_share: friction per magnitude of the road torque at the steering wheel
        offset: constant torque: offsets of both torque sensors, pull of the car
        damping: viscous damping at the steering wheel axis
        inertia: inertia below the torsion bar, at the steering wheel axis
    """

    finite: Annotated[Scalar, "N*m"]
    exponential: Annotated[Scalar, "N*m"]
    long: Annotated[Scalar, "N*m"]
    log_dahl_angle: Annotated[Scalar, ""]
    aligning_gain: Annotated[Scalar, ""]
    trail_drop: Annotated[Scalar, "1/(N*m)"]
    weight_lever: Annotated[Scalar, "m"]
    turn_slip: Annotated[Scalar, "m**2"]
    drive_share: Annotated[Scalar, ""]
    load_share: Annotated[Scalar, ""]
    offset: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]
    inertia: Annotated[Scalar, "kg*m**2"]

    @property
    def friction_torque(self) -> Scalar:
        """Level of dry friction [N*m] at the reference load."""
        return self.finite + self.exponential + self.long


class FrictionTorque(NamedTuple):
    """Output of the estimator after a sample.

    Args:
        friction_torque: level of dry friction at the steering wheel axis, at the reference load
        friction_deviation: its standard deviation, for correct torque sensors
        misfit: factor by which it was widened because the torque balance fits worse than the tuning expects
        residual: root mean square of `innovation` over the last enabled time
        enabled: 1 where the sample was used
        hands_on, same_direction, moving, rolling, settled: the enabling conditions, one by one
        dahl_angle: travel over which friction builds up
        aligning_gain, trail_drop, weight_lever, turn_slip, drive_share, load_share, offset, damping, inertia: see
            `Coefficients`
        reference_load: road torque at the steering wheel for which friction is stated
        build_up: share of the full level that friction has reached, with sign
        excitation: mean magnitude of `build_up` over the enabled time; 1 is permanent sliding, below 0.5 the strokes
            end before friction has built up
        innovation: measured less expected torque
        innovation_variance: variance expected by the filter; set wide for errors that last over many samples
        nis: normalised innovation squared; far below 1 for that reason
    """

    friction_torque: Annotated[Scalar, "N*m"]
    friction_deviation: Annotated[Scalar, "N*m"]
    misfit: Annotated[Scalar, ""]
    residual: Annotated[Scalar, "N*m"]
    enabled: Annotated[Scalar, ""]
    hands_on: Annotated[Scalar, ""]
    same_direction: Annotated[Scalar, ""]
    moving: Annotated[Scalar, ""]
    rolling: Annotated[Scalar, ""]
    settled: Annotated[Scalar, ""]
    dahl_angle: Annotated[Scalar, "rad"]
    aligning_gain: Annotated[Scalar, ""]
    trail_drop: Annotated[Scalar, "1/(N*m)"]
    weight_lever: Annotated[Scalar, "m"]
    turn_slip: Annotated[Scalar, "m**2"]
    drive_share: Annotated[Scalar, ""]
    load_share: Annotated[Scalar, ""]
    reference_load: Annotated[Scalar, "N*m"]
    offset: Annotated[Scalar, "N*m"]
    damping: Annotated[Scalar, "N*m*s/rad"]
    inertia: Annotated[Scalar, "kg*m**2"]
    build_up: Annotated[Scalar, ""]
    excitation: Annotated[Scalar, ""]
    innovation: Annotated[Scalar, "N*m"]
    innovation_variance: Annotated[Scalar, "N**2*m**2"]
    nis: Annotated[Scalar, ""]


PROCESS = Coefficients(
    finite=1.0,
    exponential=1.0,
    long=1.0,
    log_dahl_angle=1e-6,
    aligning_gain=1e-7,
    trail_drop=1e-10,
    weight_lever=1e-10,
    turn_slip=1e-9,
    drive_share=1e-7,
    load_share=1e-8,
    offset=1e-6,
    damping=1e-8,
    inertia=1e-10,
)
"""Variance that each coefficient gains per enabled second; for the three shares of friction, in multiples of
error_density / memory**2 of the tuning."""

DEVIATIONS = Coefficients(
    finite=2.0,
    exponential=5.0,
    long=2.0,
    log_dahl_angle=1.0,
    aligning_gain=0.5,
    trail_drop=0.03,
    weight_lever=0.006,
    turn_slip=0.03,
    drive_share=0.4,
    load_share=0.22,
    offset=1.0,
    damping=0.5,
    inertia=0.1,
)
"""Standard deviation of each coefficient before the first sample."""


@dataclass(frozen=True)
class PreslidingTuning:
    """Noises and priors of the regression.

    Args:
        error_density: spectral density of the torque balance's persistent errors [N**2*m**2*s]; 0.35 N*m over a second,
            or 12.5 N**2*m**2 per sample of 10 ms
        error_time: duration of such an error [s]; where the innovations exceed what density and duration allow, the
            reported standard deviation grows with them
        memory: time constant of the friction torque in enabled time [s]. A shorter one detects a fault sooner and
            scatters more: 10 s halves the delay for 1.3 times the scatter
        process: variance gained per enabled second by each coefficient, tuned in simulation; for the shares of friction
            in multiples of error_density / memory**2
        deviations: standard deviations before the first sample. 2 N*m for the shares of exponent 1/2 and 2 lets another
            law be learnt within 50 s and costs nothing where the law is exponential (simulated); the vehicle's own
            constants by their uncertainty in a vehicle file [assumed]
        initial_friction: initial estimate of friction [N*m]; 3 as printed by Mohtat et al.
        initial_dahl_angle: initial estimate of the Dahl angle [rad]; 1 degree
        smallest_dahl_angle, largest_dahl_angle: bounds of the learnt Dahl angle [rad]; 0.05 and 8 degrees
        initial_weight_lever: initial lever of the front axle load [m]; kingpins inclined by 12 degrees with a scrub
            radius of 10 mm give 15 mm (`tierod.physics.kingpin.weight_lever`), the round tyre shoulders reduce it
        initial_turn_slip: initial turn slip stiffness over load [m**2]; for a contact patch 160 mm wide with a
            longitudinal stiffness of 25 times the load
        initial_drive_share: initial share of the drive and brake force [-]; that of brake forces at the front axle. A
            front-driven car has more, a rear-driven one less
        reference_lever: lever of the front axle load that gives the road torque for which friction is stated [m]; usual
            in curves: a trail of 45 mm at a lateral acceleration of 1.44 m/s**2. 4 N*m at the steering wheel of a
            mid-size car, 0.9 of a quadricycle, 6 of a van; at a torque that never occurs friction would stay uncertain
        outlier: innovation beyond which its influence no longer grows (Huber) [N*m]; above that of a step of friction
            from 4 to 12.5, below a fault of a torque sensor
        excitation_memory: time constant of the excitation in enabled time [s]; equal to that of the friction torque
    """

    error_density: Annotated[float, "N**2*m**2*s"] = 0.125
    error_time: Annotated[float, "s"] = 1.0
    memory: Annotated[float, "s"] = 20.0
    process: Coefficients = PROCESS
    deviations: Coefficients = DEVIATIONS
    initial_friction: Annotated[float, "N*m"] = 3.0
    initial_dahl_angle: Annotated[float, "rad"] = math.radians(1.0)
    smallest_dahl_angle: Annotated[float, "rad"] = math.radians(0.05)
    largest_dahl_angle: Annotated[float, "rad"] = math.radians(8.0)
    initial_weight_lever: Annotated[float, "m"] = 0.012
    initial_turn_slip: Annotated[float, "m**2"] = turn_slip_stiffness(25.0, 0.08)
    initial_drive_share: Annotated[float, ""] = 0.7
    reference_lever: Annotated[float, "m"] = 0.0066
    outlier: Annotated[float, "N*m"] = 10.0
    excitation_memory: Annotated[float, "s"] = 20.0
