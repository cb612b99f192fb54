"""Both sides of the torque balance over a drive, for a law of friction that is given: no gains, nothing learnt."""

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
        terms: both sides, low-passed
        speed: of the vehicle [m/s]
        used: 1 where the car rolls and every signal is there
    """

    terms: Regressors
    speed: Annotated[Scalar, "m/s"]
    used: Annotated[Scalar, ""]


@dataclass(frozen=True)
class BalanceRows:
    """The regressors of `PreslidingFrictionFilter` for one angle of build-up.

    Args:
        parameters: of the vehicle; `sample_time` of them is that of the samples
        dahl_angle: over which friction builds up [rad]
        tuning: lever, turn slip and drive share before anything is learnt, for the load of the gear
        conditioning: of the signals
        cutoff: of the low-pass on both sides [Hz]
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
        """Memories of conditioning, build-up and low-pass."""

        conditioning: Any
        finite: BuildUp
        exponential: BuildUp
        long: BuildUp
        low_pass: Any

    def __post_init__(self) -> None:
        low_pass = Butterworth(Regressors, self.conditioning.sample_time, 0.0, self.cutoff)
        object.__setattr__(self, "low_pass", low_pass)

    def init(self) -> State:
        """At rest, friction relaxed."""
        return self.State(self.conditioning.init(), RELAXED, RELAXED, RELAXED, self.low_pass.init())

    def step(self, state: State, sample: SteeringSample) -> tuple[State, BalanceRow]:
        """One sample on."""
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
        """Prior of the road before a drive: it presses the gear."""
        tuning = self.tuning
        zero = Coefficients(*(0.0,) * len(Coefficients._fields))
        return zero._replace(
            aligning_gain=1.0,
            weight_lever=tuning.initial_weight_lever,
            turn_slip=tuning.initial_turn_slip,
            drive_share=tuning.initial_drive_share,
        )
