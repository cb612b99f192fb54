"""An example of every block that is no part of another example; a block without one fails the contract test."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from bank_of_graph import bank
from models.friction_paper import CAR
from monitors.condition.demonstrator import CAR as DEMONSTRATOR
from tierod.core.graph.bank import Bank
from tierod.diagnosis.trouble_codes import DebounceCounter
from tierod.methods.detectors.control_charts import Cusum, Debounce, HeldThreshold
from tierod.methods.estimators.kalman import KalmanFilter
from tierod.methods.estimators.observers import Luenberger
from tierod.methods.filters import Butterworth, Differentiator, FirstOrderLowPass, InputHold, JumpGate
from tierod.methods.identification.bench_recording import BenchParameters, RoundedColumn, SampledColumn
from tierod.methods.identification.drives import DriveLikelihood, DriveNoises, drive_filter
from tierod.methods.identification.maximum_likelihood import Innovations, Simulation
from tierod.models.lateral_motion import LateralParameters
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.models.steering_column import ColumnParameters, TwoInertiaParameters
from tierod.monitors.condition.kinds import KindOfFault
from tierod.monitors.condition.parameters import WhitenedInnovations
from tierod.monitors.condition.reaction import FaultReaction, Reconfiguration
from tierod.monitors.condition.rolling_filter import RollingFilter
from tierod.monitors.condition.vehicle_filter import LeaveOutFilter
from tierod.monitors.driver_torque.block import ColumnSigns, DriverTorqueMonitor
from tierod.monitors.driver_torque.hands import HandsMonitor
from tierod.monitors.driver_torque.observer import ColumnObserver, DelayedHandTorque
from tierod.monitors.friction.definition import FrictionMonitor
from tierod.monitors.friction.signals import SteeringSample
from tierod.monitors.motor_angle.definition import MotorAngleMonitor
from tierod.monitors.motor_angle.plausibility import AnglePlausibility, Superposition
from tierod.monitors.own_car import BalanceRows
from tierod.monitors.sideslip.definition import SideslipMonitor
from tierod.monitors.sideslip.estimator import CombinedSideslip
from tierod.monitors.stuck import StuckSignals
from tierod.vehicles import load
from tierod_lab.methods.stationary import StationaryFilter
from tierod_lab.methods.unscented import UnscentedFilter
from tierod_lab.papers.column.position_control import ObservedPositionControl, PositionControl
from tierod_lab.papers.column.printed import PrintedObserver
from tierod_lab.papers.condition.rules.parameters import RESIDUALS, Coefficients, ResidualCalibration
from tierod_lab.papers.condition.rules.rule_monitor import RulesWithReaction, rule_monitor
from tierod_lab.papers.friction.joint_model import FrictionEstimation as EstimatedFriction
from tierod_lab.papers.friction.presets import consistent, linearised, unscented
from tierod_lab.papers.friction.refined import LinearisedFrictionMonitor, RefinedFrictionMonitor
from tierod_lab.papers.friction.variance_method import RollingVariance, VarianceFrictionMonitor, VarianceParameters
from tierod_lab.papers.motor_angle.observers import FeedforwardAngle, RotorFrameObserver, extended_kalman, luenberger
from tierod_lab.papers.motor_angle.variants import PrintedMotorObserver, monitor_with
from tierod_lab.papers.sideslip.observers import (
    ConventionalKalman,
    ConventionalPoles,
    conventional_kalman,
    conventional_poles,
)
from tierod_lab.papers.sideslip.steered_vehicle import SteeredVehicle
from tierod_lab.papers.sideslip.two_stage import TwoStagePoles, two_stage_kalman, two_stage_poles

DT = 0.01
BENCH = load("column-bench").parameters_for(BenchParameters)
GAIN = tuple(tuple(0.3 * (row == column) for column in range(3)) for row in range(5))
"""Of a stable observer of three measured states among five."""

COLUMN = TwoInertiaParameters(0.035, 0.23, 132.0, 18.0, 1.6e-4, 1.5e-3)  # Two inertias on a spring

BASES = {"EachSignal", "SteeringTorqueObserver"}  # What several blocks share; they are exercised through those

SET_UPS = {"AlarmWatch", "ClosedLoop", "EnergyAudit", "Replay", "SweptBench"}
"""A plant with what watches or drives it, of one campaign of a paper."""

PARTS = {
    "AllResiduals",
    "AngleObserver",
    "ConditionJudge",
    "Decision",
    "FaultReaction",
    "Watching",
}
"""Steps with arguments of their own, used inside one block and exercised through it, or equations that are counted."""


def _rules():
    return rule_monitor(DEMONSTRATOR, ResidualCalibration(Coefficients(), dict.fromkeys(RESIDUALS, 0.5), 0))


MOTOR = load("motor-bench").parameters_for(SampledMotorParameters)  # Of the bench, sampled at 10 kHz
DQ_MOTOR = load("motor-bench").parameters_for(MotorParameters)

BY_WIRE = load("steer-by-wire").parameters_for(SteeredVehicle.Parameters)


EXAMPLES: dict[type, Callable[[], Any]] = {
    Bank: bank,
    StuckSignals: lambda: StuckSignals(
        ("steering_wheel_rate", "motor_torque", "lateral_acceleration", "vehicle_speed"),
        ("steering_wheel_angle", "driver_torque", "yaw_rate", "wheel_speed_rear_left"),
        0.05,
    ),
    PositionControl: lambda: PositionControl.design(COLUMN, 140.0, 1e-3, friction=0.1),
    Cusum: lambda: Cusum(0.5, 4.0, 20.0),
    HeldThreshold: lambda: HeldThreshold(0.5, 3),
    Debounce: lambda: Debounce(0.05, 0.1, DT),
    DebounceCounter: lambda: DebounceCounter(2.0, 3.0),
    Reconfiguration: lambda: Reconfiguration.of_vehicle(load("smartload"), DT),
    KindOfFault: lambda: KindOfFault(7.5, 0.75, 0.75, 3e-4),
    KalmanFilter: lambda: replace(consistent(CAR).filter, hold_missing_input=True),
    UnscentedFilter: lambda: replace(unscented(CAR).filter, hold_missing_input=True),
    Butterworth: lambda: Butterworth(SteeringSample, DT, 0.0, 5.0),
    FirstOrderLowPass: lambda: FirstOrderLowPass(SteeringSample, DT, 0.05, 0.2),
    Differentiator: lambda: Differentiator(SteeringSample, DT, 0.05, 0.02),
    InputHold: lambda: InputHold(SteeringSample, DT, 0.05),
    JumpGate: lambda: JumpGate(SteeringSample, DT, 0.05, 5.0),
    BalanceRows: lambda: BalanceRows(CAR, 0.02),
    FrictionMonitor: lambda: FrictionMonitor.of_vehicle(load("midsize-eps")),
    ConventionalKalman: lambda: conventional_kalman(BY_WIRE, DT),
    ConventionalPoles: lambda: conventional_poles(BY_WIRE, DT),
    TwoStagePoles: lambda: two_stage_poles(BY_WIRE, DT),
    SideslipMonitor: lambda: SideslipMonitor.of_vehicle(two_stage_kalman(BY_WIRE, 1e-3), load("steer-by-wire")),
    RefinedFrictionMonitor: lambda: consistent(CAR),
    LinearisedFrictionMonitor: lambda: linearised(CAR, steering_ratio_growth=0.06),
    RollingVariance: lambda: RollingVariance(50, 40),
    CombinedSideslip: lambda: CombinedSideslip.of_vehicle(load("midsize-eps"), DT),
    DriverTorqueMonitor: lambda: DriverTorqueMonitor(
        ColumnObserver.of_vehicle(load("column-bench"), 1e-3),
        HandsMonitor.of_vehicle(load("column-bench"), 1e-3),
        ColumnSigns(18.0, 1e-3),
    ),
    VarianceFrictionMonitor: lambda: VarianceFrictionMonitor(
        load("midsize-eps").parameters_for(VarianceParameters), threshold=1000.0, gate=None
    ),
    WhitenedInnovations: lambda: WhitenedInnovations(LeaveOutFilter.of_vehicle(load("smartload"), DT)),
    RollingFilter: lambda: RollingFilter.of_vehicle(load("rav4"), DT),
    RulesWithReaction: lambda: RulesWithReaction(
        _rules(), FaultReaction.of(Reconfiguration.of_vehicle(load("smartload"), filters=False))
    ),
    FeedforwardAngle: lambda: FeedforwardAngle(MOTOR),
    PrintedMotorObserver: lambda: monitor_with(luenberger(DQ_MOTOR, 1e-4), load("motor-bench"), 1e-4).observer,
    RotorFrameObserver: lambda: extended_kalman(DQ_MOTOR, 1e-4),
    MotorAngleMonitor: lambda: MotorAngleMonitor.of_vehicle(load("motor-bench"), 1e-4),
    AnglePlausibility: lambda: AnglePlausibility(Superposition(22.5, 1.0, 140.0)),
    ObservedPositionControl: lambda: ObservedPositionControl.of_vehicle(load("column-bench")),
    DelayedHandTorque: lambda: DelayedHandTorque.of_vehicle(load("column-bench")),
    PrintedObserver: lambda: PrintedObserver.of_column(
        load("column-bench").parameters_for(ColumnParameters), "balanced"
    ),
    DriveLikelihood: lambda: DriveLikelihood(
        drive_filter(load("midsize-eps").parameters_for(LateralParameters), DriveNoises(), DT), 0.065
    ),
    Innovations: lambda: Innovations(
        SampledColumn, BENCH, (0.0,) * 7, (1e-4,) * 7, (1e-4,), (1e-6, 1e-5, 4e-4), RoundedColumn
    ),
    Simulation: lambda: Simulation(SampledColumn, BENCH, (0.0,) * 7),
    Luenberger: lambda: Luenberger(EstimatedFriction, CAR, (0.0,) * 5, GAIN),
    StationaryFilter: lambda: StationaryFilter(
        EstimatedFriction, CAR, (0.0,) * 5, GAIN, (1.0,) * 15, (1.0, 0.0, 0.0, 1.0, 0.0, 1.0)
    ),
}
"""Class -> a function that builds an example."""
