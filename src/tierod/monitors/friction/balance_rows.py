"""Both sides of the torque balance over a drive for a given friction law, without estimation."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any, NamedTuple

from tierod.core.block import Scalar
from tierod.core.graph.maths import all_of, where
from tierod.methods.filters import Butterworth
from tierod.models.friction_estimation import FrictionParameters
from tierod.monitors.friction.conditioning import SteeringConditioning
from tierod.monitors.friction.presliding_tuning import Coefficients, PreslidingTuning
from tierod.monitors.friction.signals import SteeringSample
from tierod.monitors.friction.torque_balance import ROLLING_SPEED, Regressors, column_motion, reference_load, regressors
from tierod.physics.friction_build_up import RELAXED, BuildUp, build_ups


class BalanceRow(NamedTuple):
    """One sample of the balance.

    Args:
        terms: regressors and torques of the balance, low-passed
        speed: vehicle speed [m/s]
        used: 1 where the vehicle rolls and every signal is present and settled
    """

    terms: Regressors
    speed: Annotated[Scalar, "m/s"]
    used: Annotated[Scalar, ""]


@dataclass(frozen=True)
class BalanceRows:
    """Regressors of `PreslidingFrictionFilter` for one fixed Dahl angle.

    Args:
        parameters: parameters of the vehicle; their `sample_time` is that of the samples
        dahl_angle: travel over which friction builds up [rad]
        tuning: gives weight lever, turn slip and drive share, from which the load of the gear is computed
        conditioning: conditioning of the signals
        cutoff: cutoff frequency of the low-pass on both sides [Hz]
    """

    parameters: FrictionParameters
    dahl_angle: Annotated[float, "rad"]
    tuning: PreslidingTuning = field(default_factory=PreslidingTuning)
    conditioning: SteeringConditioning = field(default_factory=SteeringConditioning)
    cutoff: Annotated[float, "Hz"] = 3.0
    low_pass: Butterworth = field(init=False, repr=False)

    Sample = SteeringSample
    Output = BalanceRow

    class State(NamedTuple):
        """State of conditioning, build-up laws and low-pass."""

        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any

    def __post_init__(self) -> None:
        low_pass = Butterworth(Regressors, self.conditioning.sample_time, 0.0, self.cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    def init(self) -> State:
        """State before the first sample: at rest, friction relaxed."""
        return self.State(self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, BalanceRow]:
        """Process one sample."""
        conditioning, clean = self.conditioning.step(state.conditioning, sample)
        column = column_motion(clean, self.parameters.torsion_bar_stiffness, self.conditioning.sample_time)
        laws = build_ups((state.finite, state.exponential, state.long), column.increment, self.dahl_angle)
        load = reference_load(self.parameters, self.tuning.reference_lever)
        rows = regressors(clean, column, laws, self._before, self.parameters, load)
        low_pass, passed = self.low_pass.step(state.low_pass, rows)
        speed = clean.signals.vehicle_speed
        used = where(all_of(speed > ROLLING_SPEED, clean.settled, clean.present), 1.0, 0.0)
        return self.State(conditioning, *laws, low_pass), BalanceRow(passed, speed, used)

    @property
    def _before(self) -> Coefficients:
        """Prior coefficients of the road torques, which determine the load of the gear."""
        tuning = self.tuning
        zero = Coefficients(*(0.0,) * len(Coefficients._fields))
        return zero._replace(
            aligning_gain=1.0,
            weight_lever=tuning.initial_weight_lever,
            turn_slip=tuning.initial_turn_slip,
            drive_share=tuning.initial_drive_share,
        )
