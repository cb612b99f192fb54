"""Drives of the motor bench as observers and the monitor receive them, with sensor noise, faults and the truth."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from tierod.core.block import Block
from tierod.core.graph import Result, scan
from tierod.core.graph.trace import trace
from tierod.models.stator_frame_motor import MotorParameters, SampledMotorParameters
from tierod.monitors.motor_angle.observer import MotorAngleObserver, MotorAngleSample
from tierod.physics.motor import REFERENCE_TEMPERATURE
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import MotorBench
from tierod_lab.ground.motor import AFS_MOTOR, Inverter, Warming

DEGREE = math.radians(1.0) / 4.0  # One degree of the electrical angle of four pole pairs, as angle of the shaft [rad]
FIVE_DEGREES = 5.0 * DEGREE
"""Five degrees electrical, the smallest offset that deserves an alarm, as angle of the shaft [rad]."""


@dataclass(frozen=True)
class Fault:
    """Effect of a fault on a signal, over the time since its start."""

    name: str  # name in words
    # gain, offset: gain and offset of the signal, as functions of the time [s]
    gain: Callable[[np.ndarray], np.ndarray] = np.ones_like
    offset: Callable[[np.ndarray], np.ndarray] = np.zeros_like
    # whether the gain acts about the angle at the start of the fault, so that the signal does not jump
    from_here: bool = False
    held: bool = False  # whether the signal is stuck
    quantum: float = 0.0  # resolution of the recorded signal; the control still reads the fine one [rad]
    signal: str = "motor_angle_mechanical"  # name of the faulty signal
    size: float = 0.0  # time until the fault is as large as an offset of five degrees electrical [s]


def _constant(value: float) -> Callable[[np.ndarray], np.ndarray]:
    return lambda time: np.full_like(time, value)


def offset(degrees: float) -> Fault:
    """Constant electrical offset [deg], as of a magnet that has slipped."""
    return Fault(f"offset of {degrees:g}° electrical", offset=_constant(degrees * DEGREE))


def drift(degrees: float) -> Fault:
    """Electrical offset that grows at a rate [deg/s]."""
    name = f"drift of {degrees:g}°/s electrical"
    return Fault(name, offset=lambda time: degrees * DEGREE * time, size=5.0 / degrees)


def gain(percent: float) -> Fault:
    """Gain that is too large [%], about the angle at the start of the fault."""
    return Fault(f"gain {percent:g} % too large", gain=_constant(1.0 + 0.01 * percent), from_here=True)


def noise(degrees: float) -> Fault:
    """Additional white noise of an electrical standard deviation [deg]."""
    return Fault(
        f"noise of {degrees:g}° electrical",
        offset=lambda time: degrees * DEGREE * np.random.default_rng(5).normal(size=len(time)),
    )


def coarse(degrees: float) -> Fault:
    """Coarse electrical resolution [deg], as of lost bits."""
    return Fault(f"steps of {degrees:g}° electrical", quantum=degrees * DEGREE)


def intermittent(degrees: float) -> Fault:
    """Electrical offset [deg] that lasts 5 ms, ten times a second."""
    return Fault(
        f"{degrees:g}° electrical for 5 ms, ten times a second",
        offset=lambda time: degrees * DEGREE * ((time + 1e-9) % 0.1 < 5e-3),
    )


STUCK = Fault("stuck", held=True)
SWAPPED_SINE = Fault("sine and cosine swapped", gain=_constant(-1.0), offset=_constant(90.0 * DEGREE))
SWAPPED_PHASES = Fault("current phases b and c swapped", gain=_constant(-1.0), signal="motor_current_beta")

FAULTS = (
    *map(offset, (2.0, 5.0, 10.0, 60.0)),
    *map(drift, (5.0, 20.0, 100.0)),
    *map(gain, (2.0, 10.0)),
    *map(noise, (10.0, 30.0)),
    *map(coarse, (20.0, 60.0)),
    *map(intermittent, (20.0, 60.0)),
    STUCK,
    SWAPPED_SINE,
    SWAPPED_PHASES,
)
"""All faults, by kind and from small to large."""


RATE, SUBSTEPS = 1e4, 10  # Sampling rate of the recording [Hz], and samples per step of the bench
SAMPLE_TIME = 1.0 / RATE
NOISES = {
    "motor_current_alpha": 0.15,
    "motor_current_beta": 0.15,
    "motor_voltage_alpha": 0.03,
    "motor_voltage_beta": 0.03,
    "motor_angle_mechanical": 5e-4,
}
"""Standard deviations of the sensor noise by signal, in its unit."""
_COLUMN = {name: place for place, name in enumerate(MotorAngleSample._fields)}
_NOISE = tuple(NOISES[name] for name in MotorAngleObserver.Sample._fields)


def bench_time(seconds: float) -> np.ndarray:
    """Times of the steps of the bench, every millisecond [s]."""
    return np.arange(round(seconds * RATE / SUBSTEPS)) * SUBSTEPS / RATE


def course(time: np.ndarray, seed: int) -> np.ndarray:
    """Target angle of the motor of an active front steering at work: four sines, up to some 100 rad/s [rad]."""
    random = np.random.default_rng(seed)
    parts = [
        random.uniform(0.4, 1.0) / (0.4 + f) * np.sin(2.0 * np.pi * f * time + random.uniform(0.0, 2.0 * np.pi))
        for f in (0.15, 0.4, 0.9, 1.7)
    ]
    return np.asarray(12.0 * np.sum(parts, axis=0) * np.clip(2.0 * time, 0.0, 1.0))


@dataclass(frozen=True)
class BenchDrive:
    """A drive as the monitor receives it, with the truth."""

    samples: np.ndarray  # signals of `MotorAngleSample` at `RATE`, (n, signals)
    speed: np.ndarray  # true speed of the shaft [rad/s], (n,)
    angle: np.ndarray  # true angle of the shaft [rad], (n,)

    @property
    def time(self) -> np.ndarray:
        """Time from the first sample [s]."""
        return np.arange(len(self.speed)) / RATE


def drive(seed: int, seconds: float, fault: Fault | None = None, start: float = 0.0) -> BenchDrive:
    """Simulate and record a drive of the bench, with a fault from `start` on [s]."""
    return noisy(clean_drive(seed, seconds, fault, start), np.random.default_rng([seed, 77]))


def clean_drive(
    seed: int,
    seconds: float,
    fault: Fault | None = None,
    start: float = 0.0,
    plant: MotorBench | None = None,
    load: np.ndarray | None = None,
    target: np.ndarray | None = None,
) -> BenchDrive:
    """Simulate a drive of the bench without sensor noise.

    Args:
        plant: the bench; the default one where None
        load: load torque besides the spring, a value per step of the bench; none where None [N*m]
        target: target angle of the motor, a value per step of the bench; that of `course` where None [rad]
    """
    plant, time = plant or MotorBench(), bench_time(seconds)
    inputs = bench_inputs(course(time, seed) if target is None else target)
    if load is not None:
        inputs["load_torque"] = load
    if fault is not None:
        inputs |= faulty_ports(fault, time - start, inputs["target_motor_angle"])
    found = scan(plant, np.column_stack(list(inputs.values())))
    return recorded(found, inputs, 0.0 if fault is None else fault.quantum, start)


def bench_inputs(target: np.ndarray) -> dict[str, np.ndarray]:
    """Fault-free inputs of a bench that follows a target angle [rad], a value per step of the bench."""
    return _inputs_of(MotorBench(), target_motor_angle=target, control=np.ones(len(target)))


def _inputs_of(plant: Block, **given: np.ndarray) -> dict[str, np.ndarray]:
    steps = len(next(iter(given.values())))
    return {name: np.full(steps, 1.0 if name.endswith(".gain") else 0.0) for name in trace(plant).sample} | given


def _fine(found: Result, name: str) -> np.ndarray:
    return np.column_stack([found[f"motor.fine.{name}.{k}"] for k in range(SUBSTEPS)]).ravel()


def faulty_ports(fault: Fault, since: np.ndarray, target: np.ndarray) -> dict[str, np.ndarray]:
    """Gain, offset and hold of a fault at the port of its signal, a value per step of the bench.

    Args:
        since: time since the start of the fault, a value per step of the bench; negative before it [s]
        target: target angle of the motor, a value per step of the bench [rad]
    """
    # The tolerance keeps rounding of the time from delaying the fault by a step.
    on, since, port = since >= -1e-9, np.maximum(since, 0.0), f"ports.{fault.signal}"
    gain, offset = fault.gain(since), fault.offset(since)
    # The offset makes up for the gain at the angle of the start, so that the faulty reading does not jump there.
    if fault.from_here:
        offset = offset + (1.0 - gain) * target[np.argmax(on)]
    return {
        f"{port}.gain": np.where(on, gain, 1.0),
        f"{port}.offset": np.where(on, offset, 0.0),
        f"{port}.held": np.where(on & fault.held, 1.0, 0.0),
    }


def recorded(found: Result, inputs: Mapping[str, np.ndarray], quantum: float = 0.0, start: float = 0.0) -> BenchDrive:
    """Record the signals of the bench behind their ports; the target angle only at its own instants.

    Args:
        quantum: resolution of the angle from `start` on, 0 for exact readings [rad]
    """

    def through(name: str) -> np.ndarray:
        port, values = f"ports.{name}", _fine(found, name)
        held = np.repeat(inputs[f"{port}.held"], SUBSTEPS) > 0.5
        if held.any():
            values = np.where(held, values[np.argmax(held) - 1], values)
        gain, offset = (np.repeat(inputs[f"{port}.{each}"], SUBSTEPS) for each in ("gain", "offset"))
        return np.asarray(gain * values + offset)

    speed = _fine(found, "motor_speed")
    samples = np.full((len(speed), len(_COLUMN)), np.nan)
    for name in NOISES:
        samples[:, _COLUMN[name]] = _fine(found, name) if "voltage" in name else through(name)
    if quantum:
        angle = samples[round(start * RATE) :, _COLUMN["motor_angle_mechanical"]]
        angle[:] = quantum * np.round(angle / quantum)
    samples[::SUBSTEPS, _COLUMN["target_motor_angle_mechanical"]] = inputs["target_motor_angle"]
    return BenchDrive(samples, speed, _fine(found, "motor_angle_mechanical"))


def noisy(clean: BenchDrive, random: np.random.Generator) -> BenchDrive:
    """The drive with sensor noise."""
    samples = clean.samples.copy()
    for name, noise in NOISES.items():
        samples[:, _COLUMN[name]] += noise * random.normal(size=len(samples))
    return replace(clean, samples=samples)


@dataclass(frozen=True)
class ObserverDrive:
    """Inputs of an observer over a drive, and the truth."""

    samples: np.ndarray  # signals of `MotorAngleObserver.Sample` at `RATE`, (n, 5)
    angle: np.ndarray  # angle, speed: true angle and speed of the shaft [rad], [rad/s], (n,)
    speed: np.ndarray
    load: np.ndarray  # torque that opposes the rotor, except its viscous friction [N*m], (n,)
    commands: np.ndarray  # voltages commanded to the inverter, in the stator frame [V], (n, 2)
    resistance: np.ndarray  # true phase resistance at the temperature of the winding [ohm], (n,)

    @property
    def commanded(self) -> np.ndarray:
        """The samples with the commanded instead of the measured voltages."""
        return np.column_stack([self.samples[:, :2], self.commands, self.samples[:, 4]])

    @property
    def time(self) -> np.ndarray:
        """Time from the first sample [s]."""
        return np.arange(len(self.angle)) / RATE

    def observed(self, observer: Block) -> Result:
        """Outputs of an observer."""
        return scan(observer, self.samples)

    def error(self, observer: Block) -> np.ndarray:
        """Error of an observer's angle [rad]."""
        return np.asarray(self.observed(observer)["motor_angle"] - self.angle)


def bench(
    temperature: float = REFERENCE_TEMPERATURE, stiffness: float = 0.05, inverter: Inverter = AFS_MOTOR.inverter
) -> MotorBench:
    """A bench whose motor keeps a constant temperature.

    Args:
        temperature: temperature of winding and magnets [K]; the vehicle file holds at 20 degrees
        stiffness: stiffness of the spring that loads the shaft [N*m/rad]
    """
    # Huge heat capacities keep the temperature.
    constant = Warming(winding_capacity=1e9, housing_capacity=1e9, ambient_temperature=temperature)
    return MotorBench(motor=replace(AFS_MOTOR, warming=constant, inverter=inverter), load_stiffness=stiffness)


@lru_cache(maxsize=8)
def to_and_fro(
    seed: int, seconds: float, temperature: float = REFERENCE_TEMPERATURE, inverter: Inverter = AFS_MOTOR.inverter
) -> ObserverDrive:
    """Simulate a drive in both directions against a spring, along `course`, at a temperature of the motor [K]."""
    time = bench_time(seconds)
    return observed_drive(bench(temperature, inverter=inverter), course(time, seed), np.zeros(len(time)), seed)


def observed_drive(plant: Block, target: np.ndarray, load: np.ndarray, seed: int, **more: np.ndarray) -> ObserverDrive:
    """Simulate a bench under angle control, as an observer receives it; all inputs are values per step of the bench.

    Args:
        plant: the bench, or a `Varied` one with parameters as inputs
        target: target angle [rad]
        load: load torque besides the spring [N*m]
        more: further inputs of the bench by name
    """
    return _run(plant, seed, target_motor_angle=target, load_torque=load, control=np.ones(len(target)), **more)


def locked(plant: Block, torque: np.ndarray, seed: int) -> ObserverDrive:
    """Simulate a bench with locked shaft under a torque command, a value per step of the bench [N*m]."""
    return _run(plant, seed, motor_torque=torque, locked=np.ones(len(torque)))


def _run(plant: Block, seed: int, **given: np.ndarray) -> ObserverDrive:
    found = scan(plant, np.column_stack(list(_inputs_of(plant, **given).values())))
    true = np.column_stack([_fine(found, name) for name in MotorAngleObserver.Sample._fields])
    opposing = found["motor.truth_load_torque"] + found["motor.truth_motor_friction_torque"]
    commands = np.column_stack([_fine(found, f"motor_target_voltage_{axis}") for axis in ("alpha", "beta")])
    load, resistance = (np.repeat(each, SUBSTEPS) for each in (opposing, found["motor.truth_motor_resistance"]))
    noise = np.random.default_rng([seed, 5]).normal(size=true.shape) * _NOISE
    angle, speed = _fine(found, "motor_angle_mechanical"), _fine(found, "motor_speed")
    return ObserverDrive(true + noise, angle, speed, load, commands, resistance)


RESISTANCE, FLUX, INDUCTANCE = (0.8, 1.3), (0.94, 1.02), (0.93, 1.07)
"""Ranges of the true values over those that an observer assumes, by temperature and tolerance."""


def with_true(p: SampledMotorParameters, resistance: float, flux: float, inductance: float) -> SampledMotorParameters:
    """Parameters for an observer, such that the true ones are larger by the given factors."""
    return replace(
        p,
        motor_resistance=p.motor_resistance / resistance,
        motor_flux=p.motor_flux / flux,
        motor_inductance=p.motor_inductance / inductance,
    )


def parameters(name: str = "motor-bench") -> tuple[MotorParameters, SampledMotorParameters]:
    """Parameters of a vehicle's motor, for observers in the rotor frame and in the stator frame."""
    vehicle = load(name)
    return vehicle.parameters_for(MotorParameters), vehicle.parameters_for(SampledMotorParameters)


def rms(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))
