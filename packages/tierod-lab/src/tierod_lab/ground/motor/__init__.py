"""Permanent-magnet motor with inverter, current control and heating, with its own step within a step of the car."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, NamedTuple, TypeAlias

from tierod.core.block import Scalar, Tree
from tierod.core.fields import COUNT, NOT_NEGATIVE, POSITIVE, SHARE
from tierod.physics.friction import dahl_update
from tierod.physics.motor import (
    Direction,
    StatorVector,
    direction,
    electrical_angle,
    flux_at,
    lost_voltage,
    resistance_at,
    rotor_acceleration,
    stator_flux_rate,
    turned,
)
from tierod_lab.ground.laws import (
    cogging_torque,
    current_of_flux,
    torque_of_flux,
)
from tierod_lab.ground.motor.control import ControlMemory, CurrentControl
from tierod_lab.ground.parts import signals


@dataclass(frozen=True)
class Machine:
    """Windings, magnets and rotor; resistance and flux at 20 degrees Celsius.

    The defaults are those of a 12 V motor of 450 W in an active front steering; no paper prints such a set.
    """

    resistance: Annotated[float, "ohm", POSITIVE] = 0.05
    inductance_d: Annotated[float, "H", POSITIVE] = 1e-4
    inductance_q: Annotated[float, "H", POSITIVE] = 1e-4
    flux: Annotated[float, "V*s", POSITIVE] = 0.0085
    inertia: Annotated[float, "kg*m**2", POSITIVE] = 1.2e-4
    damping: Annotated[float, "N*m*s/rad", NOT_NEGATIVE] = 4e-4
    friction: Annotated[float, "N*m", NOT_NEGATIVE] = 0.02
    dahl_angle: Annotated[float, "rad", POSITIVE] = 0.05
    cogging: Annotated[float, "N*m", NOT_NEGATIVE] = 0.01
    pole_pairs: Annotated[int, "", COUNT] = 4


@dataclass(frozen=True)
class Inverter:
    """Six switches on a battery; the modulation period is that of the current control."""

    supply_voltage: Annotated[float, "V", POSITIVE] = 13.0
    # dead time between the switches of a leg; 1 us is usual for MOSFETs
    dead_time: Annotated[float, "s", NOT_NEGATIVE] = 1e-6
    forward_drop: Annotated[float, "V", NOT_NEGATIVE] = 0.1
    knee_current: Annotated[float, "A", POSITIVE] = 1.0
    modulation: Annotated[float, "", SHARE] = 0.97

    @property
    def longest_voltage(self) -> Scalar:
        """Maximum length of the voltage vector in use [V], within the circle inside the hexagon of the inverter.

        Source: Holmes and Lipo, Pulse Width Modulation for Power Converters (2003), ch. 6: V_dc / sqrt(3).
        """
        circle: float = 3.0**-0.5
        return self.modulation * (self.supply_voltage * circle)

    def made(self, command: StatorVector, current: StatorVector, period: Scalar) -> StatorVector:
        """Mean voltage over a modulation period [s] that a command makes at a current [A]."""
        knee = (self.forward_drop, self.knee_current)
        lost = lost_voltage(current, self.supply_voltage, self.dead_time, period, *knee)
        return StatorVector(command.alpha - lost.alpha, command.beta - lost.beta)


class Warmth(NamedTuple):
    """Temperatures of winding and housing [K]; the magnets have the temperature of the housing."""

    winding: Scalar
    housing: Scalar


@dataclass(frozen=True)
class Warming:
    """Thermal model of two bodies: the winding on the housing, and the housing in the air."""

    winding_capacity: Annotated[float, "J/K", POSITIVE] = 100.0
    housing_capacity: Annotated[float, "J/K", POSITIVE] = 600.0
    # thermal conductance from winding to housing; the time constant is about 80 s
    winding_conductance: Annotated[float, "W/K", POSITIVE] = 1.2
    # thermal conductance from housing to air; the time constant is about 20 minutes
    housing_conductance: Annotated[float, "W/K", POSITIVE] = 0.5
    ambient_temperature: Annotated[float, "K", POSITIVE] = 298.15

    def init(self) -> Warmth:
        return Warmth(self.ambient_temperature, self.ambient_temperature)

    def after(self, warmth: Warmth, heat: Scalar, step: Scalar) -> Warmth:
        """Temperatures after a step, by the explicit Euler method.

        Args:
            heat: heat in the winding [W]
            step: sampling interval, short compared with the time constants [s]
        """
        inward = self.winding_conductance * (warmth.winding - warmth.housing)
        outward = self.housing_conductance * (warmth.housing - self.ambient_temperature)
        return Warmth(
            warmth.winding + step / self.winding_capacity * (heat - inward),
            warmth.housing + step / self.housing_capacity * (inward - outward),
        )


Load = Callable[[Scalar, Scalar, Scalar], Scalar]
"""(angle [rad], speed [rad/s], time since the start of the step [s]) -> load torque on the rotor [N*m]."""


class Rotor(NamedTuple):
    """Mechanical angle [rad] and speed [rad/s] of the shaft."""

    angle: Scalar
    speed: Scalar


class Winding(NamedTuple):
    """Resistance of a phase [ohm] and flux linkage of the magnets [V*s], at their present temperatures."""

    resistance: Scalar
    flux: Scalar


class Instant(NamedTuple):
    """State of a machine between two periods."""

    rotor: Rotor
    linkage: StatorVector  # stator flux linkage [V*s]
    dry: Scalar  # dry friction divided by its level [-]
    current: StatorVector  # current that follows from flux linkage and angle [A]
    at: Direction


class Mean(NamedTuple):
    """Means over a period: shaft torque without dry friction [N*m], and heat in the winding [W]."""

    torque: Scalar
    heat: Scalar


def begin(machine: Machine, rotor: Rotor, linkage: StatorVector, dry: Scalar, winding: Winding) -> Instant:
    """State at the start of a step; the direction is computed anew, since `turned` accumulates small errors."""
    at = direction(electrical_angle(rotor.angle, machine.pole_pairs))
    return Instant(rotor, linkage, dry, _current(machine, linkage, at, winding), at)


def advance(
    machine: Machine,
    now: Instant,
    voltage: StatorVector,
    winding: Winding,
    period: Scalar,
    elapsed: Scalar,
    load: Load | None,
    free: Scalar,
) -> tuple[Instant, Mean]:
    """State after one period, by the explicit midpoint rule, and the means over the period.

    Args:
        voltage: mean voltage over the period, in the stator's axes [V]
        period: modulation period [s]
        elapsed: time since the start of the step [s]
        load: load torque on the rotor; None for a rotor whose speed is imposed
    """
    half, rotor = 0.5 * period, now.rotor
    slope = _acceleration(machine, now, rotor, load, elapsed)
    middle_rotor = Rotor(rotor.angle + half * rotor.speed, free * (rotor.speed + half * slope))
    dry = dahl_update(now.dry, half * middle_rotor.speed, machine.dahl_angle)
    linkage = _moved(now.linkage, stator_flux_rate(voltage, now.current, winding.resistance), half)
    at = turned(now.at, machine.pole_pairs * half * rotor.speed)
    middle = Instant(middle_rotor, linkage, dry, _current(machine, linkage, at, winding), at)
    slope = _acceleration(machine, middle, middle_rotor, load, elapsed + half)
    after_rotor = Rotor(rotor.angle + period * middle_rotor.speed, free * (rotor.speed + period * slope))
    linkage = _moved(now.linkage, stator_flux_rate(voltage, middle.current, winding.resistance), period)
    at = turned(now.at, machine.pole_pairs * period * middle_rotor.speed)
    dry = dahl_update(dry, half * middle_rotor.speed, machine.dahl_angle)
    after = Instant(after_rotor, linkage, dry, _current(machine, linkage, at, winding), at)
    alpha, beta = middle.current
    heat = 1.5 * winding.resistance * (alpha * alpha + beta * beta)
    return after, Mean(shaft_torque(machine, middle), heat)


def shaft_torque(machine: Machine, now: Instant) -> Scalar:
    """Electromagnetic and cogging torque on the shaft [N*m]."""
    torque = torque_of_flux(now.linkage, now.current, machine.pole_pairs)
    return torque + cogging_torque(now.at, machine.cogging)


def _acceleration(machine: Machine, now: Instant, rotor: Rotor, load: Load | None, elapsed: Scalar) -> Scalar:
    if load is None:
        return 0.0
    opposing = load(rotor.angle, rotor.speed, elapsed) + machine.friction * now.dry
    return rotor_acceleration(shaft_torque(machine, now), opposing, rotor.speed, machine.inertia, machine.damping)


def _current(machine: Machine, linkage: StatorVector, at: Direction, winding: Winding) -> StatorVector:
    return current_of_flux(linkage, at, winding.flux, machine.inductance_d, machine.inductance_q)


def _moved(vector: StatorVector, rate: StatorVector, time: Scalar) -> StatorVector:
    return StatorVector(vector.alpha + time * rate.alpha, vector.beta + time * rate.beta)


def _true(value: Scalar) -> Scalar:
    return value


class Senses(NamedTuple):
    """Functions from the true values to those that the current control reads, through the ports of a control unit."""

    angle: Callable[[Scalar], Scalar] = _true  # mechanical angle of the shaft [rad]
    alpha: Callable[[Scalar], Scalar] = _true  # alpha, beta: currents in the stator's axes [A]
    beta: Callable[[Scalar], Scalar] = _true

    @classmethod
    def through(cls, read: Callable[[str, Scalar], Scalar]) -> Senses:
        """Sensors that pass every signal through the port of its name."""
        return cls(*(partial(read, name) for name in IN_LOOP))


IN_LOOP = ("motor_angle_mechanical", "motor_current_alpha", "motor_current_beta")
"""Canonical names of the signals that the current control reads."""
TRUE_VALUES = Senses()  # Sensors without errors


class DriveState(NamedTuple):
    """State of a motor between two steps."""

    rotor: Rotor
    linkage: StatorVector  # stator flux linkage [V*s]
    dry: Scalar  # dry friction of the rotor divided by its level [-]
    control: ControlMemory
    voltage: StatorVector  # mean voltage over the last period [V]
    command: StatorVector  # voltage command of the inverter in the last period [V]
    warmth: Warmth


Fine: TypeAlias = Tree  # Tuple with one number per sub-sample


FineSignals = signals(
    "FineSignals",
    """motor_current_alpha motor_current_beta motor_voltage_alpha motor_voltage_beta motor_target_voltage_alpha
    motor_target_voltage_beta motor_angle_mechanical motor_speed resolver_cosine resolver_sine""",
)
"""Signals at the motor's own rate: per step a tuple of sub-samples each, the first at the instant of the step.

Voltages are means over the period that ends at the instant; the target is the command of the inverter.
"""


class DriveSignals(NamedTuple):
    """Signals of a motor at the instant of a step, and its fine signals over the step after it."""

    fine: Tree
    motor_torque: Annotated[Scalar, "N*m"]
    motor_temperature: Annotated[Scalar, "K"]
    supply_voltage: Annotated[Scalar, "V"]
    supply_current: Annotated[Scalar, "A"]
    truth_load_torque: Annotated[Scalar, "N*m"]
    truth_motor_friction_torque: Annotated[Scalar, "N*m"]
    truth_motor_resistance: Annotated[Scalar, "ohm"]
    truth_motor_flux: Annotated[Scalar, "V*s"]


@dataclass(frozen=True)
class PmMotor:
    """Motor, inverter, current control and heating as one part, with `substeps` periods in every step of the car.

    The machine is integrated in the stator's axes, in which the mean voltage of the inverter is constant over a period.
    `turn` integrates the rotor against a load; `torque` is for a rotor whose motion a steering imposes.
    """

    machine: Machine = field(default_factory=Machine)
    inverter: Inverter = field(default_factory=Inverter)
    control: CurrentControl = field(default_factory=CurrentControl)
    warming: Warming = field(default_factory=Warming)
    resolver_amplitude: Annotated[float, "V", POSITIVE] = 2.0
    substeps: Annotated[int, "", COUNT] = 10

    def init(self) -> DriveState:
        warmth, none = self.warming.init(), StatorVector(0.0, 0.0)
        linkage = StatorVector(flux_at(warmth.housing, self.machine.flux), 0.0)
        return DriveState(Rotor(0.0, 0.0), linkage, 0.0, self.control.remembered(), none, none, warmth)

    def turn(
        self,
        state: DriveState,
        request: Scalar,
        step: Scalar,
        load: Load,
        senses: Senses = TRUE_VALUES,
        locked: Scalar = 0.0,
    ) -> tuple[DriveState, DriveSignals]:
        """Advance a motor with its own rotor by one step of the car.

        Args:
            request: requested shaft torque [N*m]
            step: step of the car [s]
        """
        after, signals, _ = self._run(state, request, step, senses, load, 1.0 - locked)
        return after, signals

    def torque(
        self, state: DriveState, rotor: Rotor, request: Scalar, step: Scalar, senses: Senses = TRUE_VALUES
    ) -> tuple[DriveState, DriveSignals, Scalar]:
        """Advance a motor by one step of the car, with the rotor moved by a steering at constant speed.

        Args:
            state: state before the step; its rotor is replaced
            request: requested shaft torque [N*m]
            step: step of the car [s]

        Returns:
            state, signals, and the mean shaft torque over the step, without the rotor's own friction [N*m]
        """
        return self._run(state._replace(rotor=rotor), request, step, senses, None, 1.0)

    def _run(
        self, state: DriveState, request: Scalar, step: Scalar, senses: Senses, load: Load | None, free: Scalar
    ) -> tuple[DriveState, DriveSignals, Scalar]:
        machine, pole_pairs, period = self.machine, self.machine.pole_pairs, step / self.substeps
        warm = state.warmth
        winding = Winding(resistance_at(warm.winding, machine.resistance), flux_at(warm.housing, machine.flux))
        now = first = begin(machine, state.rotor, state.linkage, state.dry, winding)
        wanted, longest = self.control.wanted_current(request, pole_pairs), self.inverter.longest_voltage
        control, voltage, command = state.control, state.voltage, state.command
        angle = senses.angle(now.rotor.angle)
        electrical = electrical_angle(angle, pole_pairs)
        sensed_at = direction(electrical)
        seen, means = [], []
        for count in range(self.substeps):
            resolver = (self.resolver_amplitude * now.at.cosine, self.resolver_amplitude * now.at.sine)
            seen.append((*now.current, *voltage, *command, *now.rotor, *resolver))
            # The inverter applies the command of the previous sample during this period.
            command, current = control.command, StatorVector(senses.alpha(now.current[0]), senses.beta(now.current[1]))
            control = self.control.step(control, wanted, current, angle, sensed_at, longest, period, pole_pairs)
            voltage = self.inverter.made(command, now.current, period)
            now, mean = advance(machine, now, voltage, winding, period, count * period, load, free)
            means.append(mean)
            angle = senses.angle(now.rotor.angle)
            before, electrical = electrical, electrical_angle(angle, pole_pairs)
            sensed_at = turned(sensed_at, electrical - before)
        torque, heat = (sum(values[1:], values[0]) / self.substeps for values in zip(*means, strict=True))
        warmth = self.warming.after(warm, heat, step)
        after = DriveState(now.rotor, now.linkage, now.dry, control, voltage, command, warmth)
        command_, current_ = state.command, first.current
        power = 1.5 * (command_.alpha * current_.alpha + command_.beta * current_.beta)
        signals = DriveSignals(
            FineSignals(*map(tuple, zip(*seen, strict=True))),
            torque_of_flux(first.linkage, first.current, machine.pole_pairs),
            warm.winding,
            self.inverter.supply_voltage,
            power / self.inverter.supply_voltage,
            0.0 if load is None else load(*first.rotor, 0.0),
            machine.friction * first.dry,
            *winding,
        )
        return after, signals, torque


AFS_MOTOR = PmMotor(machine=Machine(friction=0.3))
"""Motor of an active front steering, of the same kind as in Reinelt et al.; the friction is mainly that of the worm."""
EPS_MOTOR = PmMotor(
    machine=Machine(
        resistance=0.016,
        inductance_d=7e-5,
        inductance_q=9e-5,
        flux=0.0083,
        inertia=1.5e-4,
        damping=3e-4,
        friction=0.03,
        cogging=0.015,
    ),
    control=CurrentControl(
        resistance=0.016, inductance_d=7e-5, inductance_q=9e-5, flux=0.0083, lag=4e-4, current_limit=80.0
    ),
)
"""Motor of an electric power steering: 4 N*m, slightly salient; 0.05 N*m/A as in Mohtat et al."""
