"""Tyres and load transfer of the virtual vehicle: brush, magic formula by load, relaxation, parking."""

from __future__ import annotations

from typing import NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import absolute, maximum, sign, sin, sqrt
from tierod.physics.tyre import magic_angle


def brush_lateral_force(lateral_slip: Scalar, cornering_stiffness: Scalar, adhesion: Scalar, load: Scalar) -> Scalar:
    """Lateral force [N] of the brush model with parabolic pressure, the same as Fiala's.

    Validity: pure side slip, rigid carcass, one friction coefficient.
    Source: Fiala (1954); Pacejka, 3rd ed., section 3.2.1: F = mu Fz (1 - (1 - x)^3), x = tan(alpha)/tan(alpha_sl), and
    mu Fz beyond x = 1.

    Args: lateral_slip: tangent of the slip angle [-]; cornering_stiffness [N/rad]; adhesion: friction coefficient of
    tyre and road [-]; load: vertical load [N].
    """
    share = lateral_slip / (3.0 * adhesion * load / cornering_stiffness)
    sticking = maximum(1.0 - absolute(share), 0.0)
    return adhesion * load * sign(share) * (1.0 - sticking * sticking * sticking)


def brush_aligning_torque(
    lateral_slip: Scalar, cornering_stiffness: Scalar, adhesion: Scalar, load: Scalar, contact_half_length: Scalar
) -> Scalar:
    """Aligning torque [N*m] of the brush model about the contact centre, opposing positive steer.

    Source: Pacejka, 3rd ed., section 3.2.1: M = mu Fz a x (1 - |x|)^3, with reversed sign, since M here opposes steer.

    Args: lateral_slip: tangent of the slip angle [-]; cornering_stiffness [N/rad]; adhesion: friction coefficient of
    tyre and road [-]; load: vertical load [N]; contact_half_length: half of the contact length, a [m].
    """
    share = lateral_slip / (3.0 * adhesion * load / cornering_stiffness)
    sticking = maximum(1.0 - absolute(share), 0.0)
    return adhesion * load * contact_half_length * share * sticking * sticking * sticking


def bounded_relaxation_rate(
    deflection: Scalar, slip_speed: Scalar, speed: Scalar, relaxation_length: Scalar, shortest_time: Scalar
) -> Scalar:
    """Rate [m/s] of the deflection of a rolling tyre, bounded so that a fixed-step integration is stable at any speed.

    Source: Pacejka, 3rd ed., eq (7.7), du/dt + |V| u / sigma = Vsy, with a lag of the tread in series; the steady-state
    deflection is the same.

    Args: deflection: of the tyre [m]; slip_speed: of the contact patch in the direction of the deflection [m/s]; speed:
    forward speed, for example from `relaxation_speed`, not negative [m/s]; relaxation_length: distance over which the
    force builds up [m]; shortest_time: added to the time constant sigma/V, which therefore never falls below it [s].
    """
    rate = slip_speed - absolute(speed) / relaxation_length * deflection
    return rate / (1.0 + shortest_time / relaxation_length * speed)


def relaxation_speed(speed_squared: Scalar, slip_speed_squared: Scalar, greatest_slip: Scalar) -> Scalar:
    """Equivalent speed [m/s] for the relaxation of a deflection, which keeps the effective slip below a maximum.

    A fourth-power norm, (V^4 + (Vs/s)^4)^(1/4): within 2 % of the wheel's own speed below half of the maximum slip, and
    within 0.04 % below a fifth of it. Without it the deflection of a locked tyre that is dragged grows without bound.

    Args: speed_squared: square of the wheel's forward speed [m**2/s**2]; slip_speed_squared: square of the speed of the
    contact patch over the ground [m**2/s**2]; greatest_slip: effective slip of a patch that slides over the ground
    without rolling [-].
    """
    sliding_squared = slip_speed_squared / (greatest_slip * greatest_slip)
    return sqrt(sqrt(speed_squared * speed_squared + sliding_squared * sliding_squared))


def parking_torque(load: Scalar, adhesion: Scalar, pressure: Scalar) -> Scalar:
    """Torque [N*m] about the kingpin that turns one standing wheel on the ground.

    Validity: standing wheel, fully twisted; falls within a few contact lengths of rolling.
    Source: Gough's formula, as in Sharp and Granger, Proc. IMechE D 217 (2003) 87: M = (mu W / 3) sqrt(W / p).

    Args: load: vertical load of the wheel [N]; adhesion: friction coefficient of tyre and road [-]; pressure: inflation
    pressure [Pa].
    """
    return adhesion * load / 3.0 * sqrt(load / pressure)


# Normalised slip that is added to the length of the slip vector [-], so that its direction is defined at zero slip
REST = 1e-6


class SlipForces(NamedTuple):
    """Forces of one tyre [N], and the angle of the formula that `trail` needs [rad]."""

    longitudinal: Scalar
    lateral: Scalar
    angle: Scalar


def stiffness_per_load(load: Scalar, nominal_load: Scalar, greatest: Scalar, load_of_greatest: Scalar) -> Scalar:
    """Cornering stiffness over load [1/rad]; the stiffness rises degressively with the load to a maximum.

    Source: Pacejka, 3rd ed., section 4.3.2, stiffness without camber: K = pKy1 Fz0 sin(2 arctan(Fz/(pKy2 Fz0))),
    with sin(2 arctan x) = 2 x/(1 + x^2).

    Args: load: vertical load [N], not negative; nominal_load: Fz0 [N]; greatest: maximum stiffness over nominal load,
    pKy1 [1/rad]; load_of_greatest: load at the maximum stiffness over nominal load, pKy2 [-].
    """
    share = load / (load_of_greatest * nominal_load)
    return 2.0 * greatest / load_of_greatest / (1.0 + share * share)


def combined_forces(
    slips: tuple[Scalar, Scalar],
    stiffnesses: tuple[Scalar, Scalar],
    frictions: tuple[Scalar, Scalar],
    load: Scalar,
    shape_factor: Scalar,
    curvature_factor: Scalar,
) -> SlipForces:
    """Forces of a tyre under combined longitudinal and lateral slip.

    Each slip is normalised by the one at which the linear tyre would reach its peak. The length of the normalised slip
    gives the share of the peak, its direction the two components. With pure slip this is `magic_formula`.
    Source: similarity of Pacejka (3rd ed., section 4.2) and normalisation of Radt in the form of Sharp and Bettella,
    Vehicle System Dynamics 39 (2003) 27, without their transformation of the slips.

    Args: slips: longitudinal slip, tangent of the slip angle [-]; stiffnesses: slope of the force at zero slip over
    load, along and across [1/rad]; frictions: peak force over load, along and across [-], positive; load: vertical load
    [N], not negative; zero is allowed; shape_factor: C [-], the same in both directions; curvature_factor: E [-], the
    same in both directions.
    """
    along = stiffnesses[0] * slips[0] / frictions[0]
    across = stiffnesses[1] * slips[1] / frictions[1]
    length = sqrt(along * along + across * across + REST * REST)
    angle = magic_angle(length / shape_factor, curvature_factor)
    secant = load * sin(shape_factor * angle) / length
    return SlipForces(stiffnesses[0] * slips[0] * secant, stiffnesses[1] * slips[1] * secant, angle)
