"""The lock-to-lock test: friction from the work of a closed turn of the steering wheel."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tierod.core.facts import Fact, Verdict, shortened
from tierod.core.findings import Estimate, Status
from tierod.core.recording import Aligned, Channel, Recording
from tierod.core.shown import in_words
from tierod.core.signals import SIGNALS
from tierod.io.readings import LOUD, USUAL, scatter
from tierod.methods.detectors.rule_design import alarms_at
from tierod.methods.identification.hysteresis import HysteresisFriction, HysteresisIdentification, Support
from tierod.methods.identification.lock_to_lock import Noise
from tierod.monitors.baseline import Baseline
from tierod.monitors.friction.facts import SMALLEST_NOMINAL
from tierod.monitors.friction.sentences import TOO_LOW
from tierod.monitors.hysteresis.facts import (
    FAULT_FREE_TEST,
    GAIN,
    INCREASE,
    RATE,
    SCATTER,
    Increase,
    IncreaseLimits,
    over_baseline,
    over_nominal,
    torque_defects,
)
from tierod.monitors.robustness import baseline_command, cure
from tierod.monitors.session import Conclusion, Monitor, Session, Variant
from tierod.vehicles import Vehicle
from tierod.vehicles.classes import held_deviation, torque_gain_deviation

PAPER = "Mohtat et al., appendix A, eqs (15) to (17)"

SIGNALS_USED = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "vehicle_speed")


@dataclass(frozen=True)
class GroundSuspicion:
    """Limits beyond which a test labelled as on the hoist looks like one on the ground."""

    noticeable_friction: Annotated[float, "N*m"]  # friction that a driver notices [N*m]
    # Friction over that, above which the tyres probably scrub [-]; faults reach 1.1 (12.5 N·m, Mohtat et al., Table 1),
    # the fault-free car on the ground 2.6 (simulated); the limit lies between them.
    ratio: Annotated[float, ""] = 1.7

    def warnings(self, friction: float) -> tuple[str, ...]:
        """Warnings about a friction found on the hoist [N m]."""
        if not friction > self.ratio * self.noticeable_friction:
            return ()
        return (
            f"{friction:.1f} N·m is {friction / self.noticeable_friction:.1f} times the friction that a driver notices "
            f"({self.noticeable_friction:.1f} N·m): this looks like a test on the ground, where the tyres scrub; if "
            "so, judge it with the variant 'ground'",
        )


# Names in the evidence of the friction above the reference, and of its standard deviation.
INCREASES = ("increase_Nm", "increase_standard_deviation_Nm")


class HysteresisSession:
    """Collect the test, which lasts a minute or two, and judge it as a whole."""

    signals: tuple[str, ...] = SIGNALS_USED
    traces: Mapping[str, str] = {}

    def __init__(self, name: str, support: Support, vehicle: Vehicle, rate: float, baseline: Baseline | None):
        self.name, self.support, self.vehicle, self.baseline = name, support, vehicle, baseline
        self._limits = vehicle.parameters_for(IncreaseLimits) if vehicle.calibrated else None
        self._gain = torque_gain_deviation(vehicle)
        self.rule = INCREASE.rule
        self.identification = HysteresisIdentification.of_vehicle(vehicle, rate)
        self._pieces: list[Aligned] = []

    def refuse(self, aligned: Aligned) -> None:
        """Refuse nothing: the finding states what cannot be judged."""

    def absorb(self, aligned: Aligned) -> Mapping[str, np.ndarray]:
        self._pieces.append(aligned)
        return {}

    def conclude(self) -> Conclusion:
        recording = self._recording()
        noise = self.identification.angle_noise(recording)
        if noise.deviation > self.identification.largest_angle_noise:
            most = f"with more than {in_words(self.identification.largest_angle_noise, 'rad')} no reversal is sure"
            cause = f"{_scatter('steering_wheel_angle', noise)}; {most}"
            return Conclusion(self._withheld(cause, Status.NOT_IDENTIFIABLE, action=_cure("steering_wheel_angle")))
        found = self.identification.identify(recording, self.support)
        level = Baseline(
            self.vehicle.name, self.name, found.friction_torque, found.independent_deviation, "N*m",
            sum(abs(balance.path) for balance in found.loops) / max(found.mean_rate, 1e-9), rate=found.mean_rate,
        )  # fmt: skip
        loops = {f"lock to lock, {self.support}": (found.angle, found.torque)}
        verdict = self._verdict(found)
        # On the ground the first test defines the fault-free loop: there is no other reference for the scrub of tyres.
        first = self.support == "ground" and self.baseline is None and self.vehicle.calibrated
        fault_free = verdict.status is Status.HEALTHY or first
        increase, spread = (verdict.evidence.get(name) for name in INCREASES)
        distances = {INCREASE.name: increase / max(spread, 1e-9)} if increase is not None and spread is not None else {}
        defects = torque_defects(*self._torques(), self.vehicle)
        kept = None if defects else level
        return Conclusion(
            replace(verdict, facts=(*defects, *verdict.facts)),
            loops=loops,
            baseline=kept if fault_free else None,
            unproven=kept if self._only_guessed(found, verdict) else None,
            distances=distances,
        )

    def _only_guessed(self, found: HysteresisFriction, verdict: Verdict) -> bool:
        """Whether the loop alone shows an increase, so that only guesses on this car leave it suspect."""
        if self.baseline is not None or verdict.status is not Status.SUSPECT:
            return False
        return alarms_at(self.rule, verdict.evidence[INCREASES[0]] / max(found.independent_deviation, 1e-9))

    def _torques(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        values = np.vstack([piece.values for piece in self._pieces])
        driver, motor = (values[:, self.signals.index(name)] for name in ("driver_torque", "motor_torque"))
        return np.concatenate([piece.time for piece in self._pieces]), driver, motor

    def _recording(self) -> Recording:
        time = np.concatenate([piece.time for piece in self._pieces])
        values = np.vstack([piece.values for piece in self._pieces])
        channels = {}
        for name, column in zip(self.signals, values.T, strict=True):
            seen = np.isfinite(column)
            if seen.any():
                channels[name] = Channel(name, time[seen], column[seen], SIGNALS[name].unit)
        return Recording(channels)

    def _verdict(self, found: HysteresisFriction) -> Verdict:
        limits = self._limits
        if limits is None:
            return self._withheld("the torques are raw counts, not N·m", Status.NOT_IDENTIFIABLE)
        if self.baseline is None and self.support == "ground":
            return self._withheld(
                f"{found.friction_torque:.2f} N·m include the scrub of the tyres on the ground",
                Status.NOT_TESTABLE,
                found,
            )
        increase = self._increase(found, limits)
        status = limits.status(increase.value, increase.fault_free_deviation, self.rule)
        if status is Status.HEALTHY and not limits.excludes_fault(increase.value, increase.deviation, self.rule):
            return self._unseen(found, increase)
        estimate = self._estimate(found, {increase.reference: increase.base} | limits.above(increase.base))
        cause = _narrow(increase) or _CAUSES.get(status, "the loop is wider than expected")
        warnings = (*self._warnings(found.friction_torque), *self._jitter_warnings(found))
        return Verdict(
            self.name,
            status,
            (Fact(status.value, cause, action=self._action(status, increase)),),
            estimate=estimate,
            details=(
                f"on the {self.support} {self._against(increase)}, fault from {estimate.reference['fault']:.1f} N·m",
                self._gain_in_words,
            ),
            evidence=_evidence(found)
            | dict(zip(INCREASES, (increase.value, increase.fault_free_deviation), strict=True)),
            facts=tuple(Fact("note", each) for each in warnings),
            decided_by=(INCREASE.name,) if status in (Status.RISING, Status.FAULT) else (),
        )

    def _increase(self, found: HysteresisFriction, limits: IncreaseLimits) -> Increase:
        if self.baseline is not None:
            return over_baseline(found, self.baseline, self._gain.value)
        deviation = held_deviation(self.vehicle, "nominal_friction")
        return over_nominal(found, limits.nominal_friction, deviation, self._gain.value)

    def _action(self, status: Status, increase: Increase) -> str:
        narrow = bool(_narrow(increase))
        if status is not Status.SUSPECT and not narrow:
            return _ACTIONS[status]
        again = CALIBRATE if narrow else AGAIN
        return again if self.baseline else f"{cure((), (), baseline_command(self.name, self.vehicle))}; {again}"

    @property
    def _gain_in_words(self) -> str:
        cancelled = "" if self.baseline is None else ", cancelled in the baseline"
        return f"torque gains ± {100.0 * self._gain.value:.2g} % included{cancelled}"

    @staticmethod
    def _against(increase: Increase) -> str:
        if increase.reference == "nominal":
            return f"{increase.value:+z.2f} N·m against {increase.base:.1f} N·m nominal"
        return f"{increase.value:+z.2f} ± {increase.deviation:.2f} N·m against {increase.base:.2f} N·m when unfaulted"

    def _warnings(self, friction: float) -> tuple[str, ...]:
        if self.support != "hoist" or "noticeable_friction" not in self.vehicle:
            return ()
        return self.vehicle.parameters_for(GroundSuspicion).warnings(friction)

    def _estimate(self, found: HysteresisFriction, reference: dict[str, float]) -> Estimate:
        estimate, gain = found.estimate, self._gain.value * found.friction_torque
        return Estimate(
            estimate.quantity,
            estimate.value,
            math.hypot(estimate.standard_deviation, gain),
            estimate.unit,
            reference,
            (),
            *self._gain.parts(found.friction_torque),
            held={"column_damping": found.damping_deviation * found.mean_rate},
        )

    def _jitter_warnings(self, found: HysteresisFriction) -> tuple[str, ...]:
        return tuple(
            f"{_scatter(name, noise)}, which moves the friction by ±{share:.2g} N·m; {_cure(name)}"
            for name, noise, share in found.noises
            if noise.jitter > 0.0 and noise.deviation > LOUD * USUAL[name]
        )

    def _unseen(self, found: HysteresisFriction, increase: Increase) -> Verdict:
        part = max(increase.parts, key=lambda name: increase.parts[name])
        cause, action = _PARTS[part]
        worst = max(found.noises, key=lambda each: each.friction_deviation)
        if part == SCATTER and worst.friction_deviation > 0.5 * increase.deviation:
            cause, action = _scatter(worst.name, worst.noise), _cure(worst.name)
        against = f"{increase.value:+z.2f} ± {increase.deviation:.2f} N·m against {increase.base:.2f} N·m"
        return self._withheld(f"{against} may hide a fault: {cause}", Status.NOT_IDENTIFIABLE, found, action)

    def _withheld(
        self, cause: str, status: Status, found: HysteresisFriction | None = None, action: str = ""
    ) -> Verdict:
        because = (Fact("obstacle", cause, shortened(cause), action or _REMEDIES[status]),)
        evidence, estimate = (_evidence(found), self._estimate(found, {})) if found else ({}, None)
        return Verdict(self.name, status, because, estimate, evidence=evidence)


_REMEDIES = {
    Status.NOT_TESTABLE: "compare with the same test of the unfaulted car (--baseline), or repeat it on a hoist",
    Status.NOT_IDENTIFIABLE: "give the torque per count in the channel map",
}
_CAUSES = {
    Status.HEALTHY: "the loop is as wide as expected",
    Status.SUSPECT: (
        "the loop is wider than expected, but damping, scatter, the unknown fault-free friction of this car or a "
        "changed gain of driver_torque or motor_torque may explain it"
    ),
}
AGAIN, CALIBRATE = "turn slowly and several times", "calibrate driver_torque and motor_torque"
_ACTIONS = {
    Status.HEALTHY: "none",
    Status.RISING: "watch it: repeat the test at the next service, and inspect the boots of the steering gear",
    Status.FAULT: "inspect column joints, bearings, steering gear and motor for corrosion, water or damage",
}


_PARTS = {
    SCATTER: ("the scatter of the loops", AGAIN),
    FAULT_FREE_TEST: (
        "the scatter of the fault-free test",
        f"make the test of the fault-free car again, and store its baseline anew: {AGAIN}",
    ),
    RATE: (
        "the wheel turned at another rate than in the fault-free test, and column_damping is a guess",
        "turn as fast as in the fault-free test, or measure column_damping and enter value and standard_deviation in "
        "the vehicle file",
    ),
    GAIN: ("the gains of both torques", CALIBRATE),
}
"""Cause and action of each part of a deviation that may hide a fault."""


def _narrow(increase: Increase) -> str:
    share = 1.0 + increase.value / increase.base
    if share >= SMALLEST_NOMINAL:
        return ""
    return f"the loop is narrower than expected, only {share:.2f} times as wide: {TOO_LOW}"


def _scatter(name: str, noise: Noise) -> str:
    stamps = f", as of time stamps {noise.jitter:.2g} s off" if noise.jitter > 0.0 else ""
    return f"{scatter(name, noise.deviation)}{stamps}"


def _cure(name: str) -> str:
    return f"check the sensor, the time stamps and the line of {name}, and record the test again"


def _evidence(found: HysteresisFriction) -> dict[str, float]:
    evidence = {"loops": float(len(found.loops)), "mean_rate_rad_per_s": found.mean_rate}
    for name, noise, _ in found.noises:
        evidence[f"{name}_noise_{'rad' if name == 'steering_wheel_angle' else 'Nm'}"] = noise.deviation
    if found.pre_sliding is not None:
        evidence["dahl_angle_rad"] = found.pre_sliding.angle
    return evidence


def _open(support: Support) -> Callable[[Vehicle, float, Baseline | None], Session]:
    def open_(vehicle: Vehicle, rate: float, baseline: Baseline | None) -> Session:
        return HysteresisSession(f"hysteresis, {support}", support, vehicle, rate, baseline)

    return open_


HYSTERESIS = Monitor(
    name="hysteresis",
    title="Friction from a turn lock to lock",
    subject="Friction, lock to lock",
    summary="Measures the friction of the standing car from the work of a closed turn of the steering wheel.",
    source=PAPER,
    drive="The standing car, on a hoist or on the ground: the wheel is turned slowly from lock to lock and back, "
    "two times or more.",
    required=("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque"),
    optional=("vehicle_speed",),
    rate=100.0,
    minimum_rate=20.0,
    maximum_age=0.1,
    variants={
        "hoist": Variant(
            "hoist", "Wheels hang free: the loop is the friction of the steering.", PAPER, _open("hoist"), (INCREASE,)
        ),
        "ground": Variant(
            "ground",
            "Tyres scrub: only the difference to the unfaulted car's loop is friction.",
            PAPER,
            _open("ground"),
            (INCREASE,),
        ),
    },
    default=None,
    condition="this is a lock-to-lock test of the standing car",
    learns=True,
)
