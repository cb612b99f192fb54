"""The steering model with four states in the unscented filter, compared with two states: residual and effort."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from tierod.core.block import Model
from tierod.core.claims import Claim, at_most, between
from tierod.core.content import Heading, Item, Table
from tierod.core.graph import scan
from tierod.core.graph.analysis import jacobian, operation_count
from tierod.models.linear import discretise
from tierod.vehicles import load
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.condition.drives import LOSS, TEST_SECONDS, Drive, Injected
from tierod_lab.papers.condition.recorded import fault_free, recorded
from tierod_lab.papers.condition.rules.angle_filters import (
    explicit,
    exponential,
    one_body,
    two_bodies,
    two_body_parameters,
)
from tierod_lab.papers.condition.rules.parameters import PAPER, ResidualParameters
from tierod_lab.papers.condition.rules.rack import StiffRack, TwoBodyRack
from tierod_lab.papers.condition.vehicles import SHORT
from tierod_lab.studies.effort import Effort

TEXT = (
    "The paper's filter of the angle has four states (eqs 3, 4); the residuals use two, since the teeth swing at some "
    "hundred times the sampling rate. Both are shown here. The exponential of eq (3) depends on tuning alone and is "
    "worked out once; Runge and Kutta blow up with less than 22 steps to a sample. The rack's position, made "
    "from the angle by eq (5), counts the one sensor twice.",
)
SAMPLE_TIME = 0.01
CAR = load("smartload").parameters_for(ResidualParameters)
_FINE = 200  # Runge-Kutta steps per sample of the reference solution
_SEED = 11
_BOTH = ("two bodies, the angle measured", "two bodies, both measured (eqs 4, 5)")


def items(effort: Effort) -> Iterator[Item]:
    yield Heading("The steering as two bodies (eqs 3, 4)", TEXT)
    samplings = sampled(0.5 if effort.quick else 2.0)
    yield Table(
        "One sample of 10 ms of the steering, by the way in which it is sampled",
        ("sampling", "multiplications of a filter's step", "additions", "largest error of the angle [mrad]"),
        tuple(each.row for each in samplings),
        "Torque and tie-rod force swing as in a drive; errors are against 200 steps of Runge and Kutta to a sample.",
    )
    shown = {name: drive_of(each, name == _BOTH[1]) for name, each in filters().items()}
    yield Table(
        "The angle's filter on a minute, and on the same with the angle lost from 20 to 40 s",
        (
            "filter",
            "r1, root mean square [mrad]",
            "deviation that the filter states [mrad]",
            "its error [mrad]",
            "largest r1 in the tenth of a second after the loss [rad]",
            "r1 10 s after it [mrad]",
        ),
        tuple((name, *each.row) for name, each in shown.items()),
        "The error is that of the estimate against what a fault-free sensor would read without noise and steps.",
    )
    yield from _claims(samplings, shown)


class Sampling(NamedTuple):
    """A discretisation of the steering model."""

    name: str  # name in the table
    multiplications: int  # multiplications, additions: operations of a step of the unscented filter with it
    additions: int
    error: float  # largest error of the angle over the test [rad]; NaN where it diverges

    @property
    def row(self) -> tuple[str, ...]:
        """Row of the table."""
        error = f"{1e3 * self.error:.2f}" if np.isfinite(self.error) else "diverges"
        return self.name, str(self.multiplications), str(self.additions), error


def sampled(seconds: float) -> list[Sampling]:
    """Every discretisation, tested on the same torque and force.

    Args:
        seconds: duration of the test [s]
    """
    exact = _angles(explicit(_FINE), two_body_parameters(CAR), seconds)
    ways: dict[str, Model] = {
        "two bodies, exponential of eq (3), friction explicit": exponential(),
        "two bodies, exponential in every state": exponential(everywhere=True),
        "two bodies, ten steps of Euler": discretise(TwoBodyRack, "euler", 10),
    }
    ways |= {f"two bodies, {steps} steps of Runge and Kutta": explicit(steps) for steps in (20, 22, 25, 50)}
    single = one_body(CAR, SAMPLE_TIME)
    found = [_sampling("one body, exponential", single, _angles(single.model, CAR.rack, seconds) - exact)]
    for name, model in ways.items():
        angles = _angles(model, two_body_parameters(CAR), seconds)
        found.append(_sampling(name, two_bodies(CAR, SAMPLE_TIME, model), angles - exact))
    return found


def _sampling(name: str, block: UnscentedFilter, error: np.ndarray) -> Sampling:
    count = operation_count(block)
    largest = float(np.max(np.abs(error)))
    return Sampling(name, count.multiplications, count.additions, largest if largest < 1.0 else np.nan)


def _angles(model: Model, parameters: Any, seconds: float) -> np.ndarray:
    """Angle of the column at each sample of the test [rad]; infinite once it diverges."""
    known: Any = model
    at = known.Parameters(parameters, SAMPLE_TIME)
    x = known.State(*(0.0,) * len(known.State._fields))
    angles = np.full(round(seconds / SAMPLE_TIME), np.inf)
    for k in range(len(angles)):
        time = SAMPLE_TIME * k
        inputs = StiffRack.Input(3.0 * np.sin(5.0 * time) + 1.0, 150.0 * np.sin(3.0 * time))
        x = known.transition(x, inputs, at)
        # Written so that NaN ends the loop as well.
        if not abs(x.steering_wheel_angle) < 10.0:
            break
        angles[k] = x.steering_wheel_angle
    return angles


def filters() -> dict[str, UnscentedFilter]:
    """The filter of the residuals and those of the paper, by name in the table."""
    both = two_bodies(CAR, SAMPLE_TIME)
    return {"one body": one_body(CAR, SAMPLE_TIME)} | dict.fromkeys(_BOTH, both)


class OnDrive(NamedTuple):
    """Results of a filter on a minute of driving, fault-free and with a lost angle."""

    residual: float  # r1 without fault, root mean square [rad]
    stated: float  # standard deviation of the angle by the filter's covariance at the end [rad]
    error: float  # error of the estimated angle without fault, root mean square [rad]
    jump: float  # largest r1 in the tenth of a second after the loss [rad]
    later: float  # largest r1 in the tenth of a second from ten seconds after the loss [rad]
    values: np.ndarray  # r1 without fault [rad]

    @property
    def row(self) -> tuple[str, ...]:
        """Row of the table."""
        return (
            *(f"{1e3 * each:.2f}" for each in (self.residual, self.stated, self.error)),
            f"{self.jump:.3f}",
            f"{1e3 * self.later:.2f}",
        )


def drive_of(block: UnscentedFilter, copied: bool) -> OnDrive:
    """Results of a filter on the test drive.

    Args:
        block: a filter of `filters`
        copied: whether it gets the rack position as rack ratio times angle
    """
    drive = Drive(SHORT, TEST_SECONDS, 1, _SEED)
    lost = Drive(SHORT, TEST_SECONDS, 1, _SEED, (Injected("steering_wheel_angle", LOSS),))
    angle, expected, deviation = _filtered(block, copied, drive)
    true = fault_free("steering_wheel_angle", recorded(drive), drive.driven.sensors)
    read, followed, _ = _filtered(block, copied, lost)
    settled = slice(200, None)
    # The angle is lost at 20 s, sample 2000.
    jump, later = (float(np.max(np.abs((followed - read)[at : at + 10]))) for at in (2000, 3000))
    values = (expected - angle)[settled]
    return OnDrive(_rms(values), float(deviation[-1]), _rms((expected - true)[settled]), jump, later, values)


def _filtered(block: UnscentedFilter, copied: bool, drive: Drive) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Measured angle, estimated angle, and standard deviation by the filter's covariance [rad]."""
    made = recorded(drive)
    torque, force, angle = (
        made[name].values for name in ("steering_shaft_torque", "tie_rod_force", "steering_wheel_angle")
    )
    rack = CAR.rack_ratio * angle if copied else np.full(len(angle), np.nan)
    columns = [torque, force, *([rack] if len(block.model.State._fields) == 4 else []), angle]
    result = scan(block, np.stack(columns, axis=1))
    variance = result["variance.steering_wheel_angle"]
    return angle, result["mean.steering_wheel_angle"], np.sqrt(variance)


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values * values)))


@cache
def modes() -> np.ndarray:
    """Eigenvalues of eq (3) in ascending magnitude [1/s]."""
    sliding = TwoBodyRack.State(0.0, 0.0, 0.0, 1e3)
    still = StiffRack.Input(0.0, 0.0)
    matrix = jacobian(lambda x: TwoBodyRack.derivative(x, still, two_body_parameters(CAR)), sliding)
    found = np.linalg.eigvals(np.array(matrix, float))
    return found[np.argsort(np.abs(found))]


def _claims(samplings: list[Sampling], shown: dict[str, OnDrive]) -> Iterator[Claim]:
    single, exact = samplings[0], samplings[1]
    one, once, twice = shown["one body"], *(shown[name] for name in _BOTH)
    yield Claim(
        "rules.two-bodies-swing",
        "Frequency at which pinion and rack swing against each other in eq (3).",
        f"{PAPER}eq (3) and Table A1, derived",
        None,
        float(np.abs(modes()[-1].imag) / (2.0 * np.pi)),
        between(660.0, 672.0),
        "Hz",
        f"Slow modes {modes()[0].real:.2f} and {modes()[1].real:.1f} 1/s, with the inertia of 0.045 kg*m**2.",
    )
    yield Claim(
        "rules.two-bodies-cost",
        "Multiplications of the filter of four states over those of two, the exponential worked out before.",
        "tierod's goal",
        None,
        exact.multiplications / single.multiplications,
        at_most(3.0),
    )
    yield Claim(
        "rules.two-bodies-angle",
        "The two bodies leave the residual r1 as it is: difference from one body on a fault-free minute, rms.",
        "tierod's goal",
        None,
        1e3 * _rms(once.values - one.values),
        at_most(2.0),
        "mrad",
        "A step of the sensor is 1.7 mrad.",
    )
    yield Claim(
        "rules.rack-copied",
        "The angle counted twice (eqs 4, 5): variance that the filter states, over that with one measurement.",
        f"{PAPER}eqs (4) and (5)",
        None,
        (twice.stated / once.stated) ** 2,
        between(0.5, 1.0),
        "",
        f"Its error is {1e3 * twice.error:.2f} mrad, with one measurement {1e3 * once.error:.2f} mrad.",
    )
    yield Claim(
        "rules.r1-sees-jumps",
        "r1 sees a lost angle as a jump alone: r1 after ten seconds over that in the tenth of a second after the loss.",
        f"{PAPER}eqs (3) to (6)",
        None,
        once.later / once.jump if once.jump > 0.0 else np.nan,
        at_most(0.5),
    )
