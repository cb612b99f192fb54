"""The bench column: swept by its motor while hands turn the wheel, identified, and with hands that come and go."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, NamedTuple

import numpy as np

from tierod.core.block import leaves, skeleton
from tierod.core.graph import Memory, scan
from tierod.core.graph.kernel import kernel
from tierod.core.graph.maths import limit
from tierod.core.recording import Channel, Recording
from tierod.methods.identification.bench_recording import BenchParameters, BenchRecording, bench_recording
from tierod.models.steering_column import ColumnParameters
from tierod.monitors.driver_torque.hands import UNCERTAIN, HandsMonitor
from tierod.vehicles import load
from tierod_lab.ground.cars.benches import Acting, BenchPorts, BenchSignals, BenchState, ColumnBench
from tierod_lab.ground.courses.bench import BenchHands, BenchMultisine, BenchRamps, BenchSweep, BenchTorque
from tierod_lab.ground.parts import NO_FAULT
from tierod_lab.ground.steering.friction import Dahl, DryFriction

STEP = 1e-3  # Sampling interval [s]
AMPLITUDE = math.radians(30.0)  # Amplitude of the sweep, as in figure 10 of the paper [rad]
LOWEST, HIGHEST = 0.1, 3.0  # Lowest and highest frequency of the sweep [Hz]
SETTLE = 1.0  # Time at rest before the sweep [s]
NOISE = {"steering_wheel_angle": math.radians(0.05), "motor_angle_mechanical": math.radians(0.2), "driver_torque": 0.02}
"""Standard deviation of the sensor noise [rad, rad, N·m]."""
SIGNALS = ("motor_torque", "steering_wheel_angle", "motor_angle_mechanical", "driver_torque")
"""Signals in the order of `ColumnSample`."""
HANDS = ("steps", "ramps", "free")
"""Behaviours of the hands: steps of 2 N·m after a sine of 1.5 N·m, the same with ramps of 100 ms, hands off."""


class Demand(NamedTuple):
    """Reference angle of the shaft, its derivatives, and the torque of the hands."""

    angle: Annotated[float, "rad"]
    rate: Annotated[float, "rad/s"]
    acceleration: Annotated[float, "rad/s**2"]
    hand_torque: Annotated[float, "N*m"]


@dataclass(frozen=True)
class SweptBench:
    """A bench whose motor follows an angle by PD control with feed-forward of inertia and damping."""

    bench: ColumnBench = field(default_factory=ColumnBench)  # the plant
    stiffness: Annotated[float, "N*m/rad"] = 150.0  # proportional gain at the steering wheel axis [N m/rad]
    damping: Annotated[float, "N*m*s/rad"] = 5.0  # derivative gain at the steering wheel axis [N m s/rad]
    highest_torque: Annotated[float, "N*m"] = 3.0  # largest torque of the motor at its shaft [N m]

    Sample = Demand

    def init(self) -> BenchState:
        return self.bench.init()

    def step(self, state: BenchState, sample: Demand) -> tuple[BenchState, BenchSignals]:
        ratio = self.bench.gear_ratio
        motion = state.motion
        lag = sample.angle - motion.motor_angle / ratio
        late = sample.rate - motion.motor_rate / ratio
        inertia = self.bench.wheel_inertia + self.bench.gear_inertia + ratio**2 * self.bench.motor_inertia
        losses = self.bench.wheel_damping + ratio**2 * self.bench.motor_damping
        ahead = inertia * sample.acceleration + losses * sample.rate
        wanted = (self.stiffness * lag + self.damping * late + ahead) / ratio
        motor = limit(wanted, -self.highest_torque, self.highest_torque)
        return self.bench.step(state, Acting(motor, 0.0, 0.0, sample.hand_torque, 0.0, 0.0, 0.0, BenchPorts(NO_FAULT)))


def demands(hands: str, seconds: float, seed: int = 0) -> np.ndarray:
    """Rows of `Demand`: a logarithmic sweep after a rest, with hands, one of `HANDS`."""
    time = np.arange(round(seconds / STEP)) * STEP
    since = np.maximum(time - SETTLE, 0.0)
    low = math.tau * LOWEST
    growth = math.log(HIGHEST / LOWEST) / (seconds - SETTLE)
    rate = low * np.exp(growth * since)
    phase = (rate - low) / growth
    rate, rise = (np.where(time < SETTLE, 0.0, each) for each in (rate, growth * rate))
    columns = (
        AMPLITUDE * np.sin(phase),
        AMPLITUDE * rate * np.cos(phase),
        AMPLITUDE * (rise * np.cos(phase) - rate**2 * np.sin(phase)),
        _hands(hands, time, seed),
    )
    return np.column_stack(columns)


def _hands(hands: str, time: np.ndarray, seed: int) -> np.ndarray:
    """A sine of 1.5 N·m at 0.5 Hz in the first half, then two pulls of 2 N·m, to the left and to the right."""
    if hands == "free":
        return np.zeros(len(time))
    end, width = float(time[-1]), 0.1 if hands == "ramps" else 1e-9
    torque = np.where((time > 2.0) & (time < 0.5 * end), 1.5 * np.sin(math.pi * (time - 2.0)), 0.0)
    begins = end * (np.array([0.55, 0.78]) + np.random.default_rng([seed, 17]).uniform(0.0, 0.08, 2))
    for level, begin in zip((2.0, -2.0), begins, strict=True):
        instants = [begin, begin + width, begin + 0.1 * end, begin + 0.1 * end + width]
        torque = torque + np.interp(time, instants, [0.0, level, level, 0.0])
    return torque


def swept(hands: str, seconds: float = 40.0, seed: int = 0, bench: SweptBench | None = None) -> dict[str, np.ndarray]:
    """Simulate a run of the bench: inputs of an observer with sensor noise, and true values.

    Returns:
        columns by name; `hand_torque`, `disturbance_torque` (of friction) and `steering_wheel_rate` are true values
    """
    true = scan(bench or SweptBench(), demands(hands, seconds, seed))
    random = np.random.default_rng([seed, 18])
    columns: dict[str, np.ndarray] = {}
    for name, sigma in NOISE.items():
        columns[name] = true[name] + random.normal(0.0, sigma, len(true))
    columns["motor_torque"] = np.asarray(true["motor_target_torque"])
    columns["hand_torque"] = np.asarray(true["truth_hand_torque"])
    columns["disturbance_torque"] = np.asarray(true["truth_motor_friction_torque"])
    columns["steering_wheel_rate"] = np.asarray(true["steering_wheel_rate"])
    columns["time"] = np.arange(len(true)) * STEP
    return columns


def known_column() -> ColumnParameters:
    """True parameters of the bench column, from its vehicle file."""
    return load("column-bench").parameters_for(ColumnParameters)


def samples(run: Mapping[str, np.ndarray]) -> np.ndarray:
    """Samples of an observer, in the order of `ColumnSample`, (n, 4)."""
    return np.column_stack([run[name] for name in SIGNALS])


EXPERIMENTS: dict[str, BenchTorque] = {
    "sweep, wheel free": BenchSweep(amplitude=0.3, lowest=0.3, highest=20.0, settle=0.2, time=6.2, wheel="free"),
    "sweep, wheel locked": BenchSweep(amplitude=0.3, lowest=0.5, highest=30.0, settle=0.2, time=6.2, wheel="locked"),
    "ramps, wheel locked": BenchRamps(amplitude=0.35, period=3.0, settle=0.2, time=6.2, wheel="locked"),
    "many sines, wheel free": BenchMultisine(amplitude=0.25, settle=0.2, time=6.2, wheel="free"),
}
"""Experiments by name, about 25 s in all."""

BUILD_UP = 0.05
"""Angle over which the bench's friction builds up [rad]: 0.1 N m of friction over 2 N m/rad of stiffness."""


def truth() -> BenchParameters:
    """True parameters of the bench, from the vehicle file of the same set; the plant shares no code with the model."""
    return load("column-bench").parameters_for(BenchParameters)


def bench() -> ColumnBench:
    """The virtual bench with Dahl's friction."""
    return replace(ColumnBench(), friction=DryFriction(level=0.1, law=Dahl(BUILD_UP)))


def recorded(plant: ColumnBench, seed: int, seconds: float | None = None) -> dict[str, Recording]:
    """Simulate all experiments and record them; each lasts as long as it does by itself where no duration is given."""
    random = np.random.default_rng([seed, 2])
    found = {}
    for name, whole in EXPERIMENTS.items():
        test = whole if seconds is None else replace(whole, time=seconds)
        time = np.arange(round(test.duration / STEP)) * STEP
        columns = test.columns(time, time, 0.0, 0.0)
        torque = columns["motor_torque"]
        # An unrecorded torque of zero: its draw keeps the noise of the sensors that of every such bench.
        random.standard_normal(len(time))
        result = scan(plant, _samples(columns, len(time)))
        channels = {
            signal: Channel(signal, time, result[signal] + noise * random.standard_normal(len(time)), "")
            for signal, noise in NOISE.items()
        }
        channels["motor_torque"] = Channel("motor_torque", time, torque, "N*m")
        found[name] = Recording(channels)
    return found


def _samples(columns: dict[str, np.ndarray], count: int) -> np.ndarray:
    names = [name for name, _ in leaves(skeleton(Acting))]
    usual = [np.full(count, float(name.endswith(".gain"))) for name in names]
    return np.column_stack([columns.get(name, column) for name, column in zip(names, usual, strict=True)])


def experiments(recordings: dict[str, Recording], start: BenchParameters) -> list[BenchRecording]:
    """Prepare recordings for the identification."""
    return [bench_recording(name, each, start) for name, each in recordings.items()]


PIECE = 60.0  # Duration of a simulated piece, so short that its arrays fit into the processor's cache [s]
ANGLE_NOISE, ANGLE_STEP, TORQUE_NOISE = math.radians(0.005), math.radians(0.01), 0.01
"""Noise and resolution of the angle sensor, noise of the torque sensor, as on the proving ground [rad, rad, N m]."""
SCATTERED = (
    "wheel_inertia",
    "wheel_damping",
    "bar_stiffness",
    "gear_stiffness",
    "gear_inertia",
    "motor_inertia",
    "motor_damping",
)
"""Parameters of the bench that are made wrong for the observer of the hands, with the gain of its torque sensor."""


class Bench(NamedTuple):
    """A randomly drawn bench."""

    plant: ColumnBench  # bench with its own parameters
    gain: float  # gain of the torque sensor
    offset: float  # offset of the torque sensor [N m]
    course: BenchHands  # course of hands and motor
    seed: int  # seed of the noise


class Score(NamedTuple):
    """Detection delays and false changes of a monitor."""

    grabs: np.ndarray  # grabs, releases: detection delays of hands on and hands off [s]; infinite where undetected
    releases: np.ndarray
    # false_on, false_off: changes to "on" without hands and to "off" with hands, after the correct first detection
    false_on: int
    false_off: int
    seconds: Annotated[float, "s"]  # total time [s]


def drawn(seed: int, share: float, seconds: float) -> Bench:
    """Draw a bench whose parameters and torque sensor gain are wrong by a share, either way, with a torque offset."""
    draw = np.random.default_rng([seed, 7])
    plant = ColumnBench()
    ways = draw.choice([-1.0, 1.0], len(SCATTERED) + 1)
    off = {name: getattr(plant, name) * (1.0 + share * way) for name, way in zip(SCATTERED, ways[:-1], strict=True)}
    gain, offset = 1.0 + share * float(ways[-1]), float(draw.normal(0.0, 0.03))
    return Bench(replace(plant, **off), gain, offset, BenchHands(time=seconds, seed=seed, tremor=0.03), seed)


def _pieces(bench: Bench) -> Iterator[np.ndarray]:
    """Samples of angle [rad] and torque [N m] of a bench, piece by piece."""
    names = kernel(bench.plant).graph.sample
    draw, state = np.random.default_rng([bench.seed, 8]), None
    count, size = round(bench.course.duration / STEP), round(PIECE / STEP)
    for begin in range(0, count, size):
        time = np.arange(begin, min(begin + size, count)) * STEP
        given = bench.course.columns(time, time, 0.0, 0.0)
        inputs = np.zeros((len(time), len(names)))
        for column, name in enumerate(names):
            inputs[:, column] = given.get(name, 1.0 if name.endswith("gain") else 0.0)
        result = scan(bench.plant, inputs, state)
        state = result.state
        noise = draw.standard_normal((2, len(time)))
        angle = result["steering_wheel_angle"] + ANGLE_NOISE * noise[0]
        torque = bench.gain * result["driver_torque"] + bench.offset + TORQUE_NOISE * noise[1]
        yield np.column_stack([np.round(angle / ANGLE_STEP) * ANGLE_STEP, torque])


def scored(monitor: HandsMonitor, bench: Bench) -> Score:
    """Score of a monitor on a bench."""
    state: Memory | None = None
    hands = []
    for samples in _pieces(bench):
        result = scan(monitor, samples, state)
        state = result.state
        hands.append(result["hands"].astype(np.float32))
    return score(np.concatenate(hands), bench.course)


def score(hands: np.ndarray, course: BenchHands) -> Score:
    """Score the decisions of a monitor, its state of the hands by sample, against the true course of the hands."""
    decided = decisions(hands)
    switches, ends = course.switches[:-1], course.switches[1:]
    # An episode that the end of the run cuts off has no complete delay.
    whole = ends < len(hands) * STEP
    delays: tuple[list[float], list[float]] = ([], [])
    false = [0, 0]
    for number, (start, end) in enumerate(zip(switches[whole], ends[whole], strict=True)):
        on = number % 2 == 0
        part = decided[round(start / STEP) : round(end / STEP)]
        right = np.flatnonzero(part == float(on))
        delays[on].append(right[0] * STEP if len(right) else math.inf)
        if len(right):
            false[not on] += int(np.count_nonzero(np.diff(part[right[0] :]) == (-1.0 if on else 1.0)))
    return Score(np.array(delays[1]), np.array(delays[0]), false[1], false[0], len(hands) * STEP)


def decisions(hands: np.ndarray) -> np.ndarray:
    """States of the hands, in which an uncertain sample keeps the last decision."""
    decided: np.ndarray = hands[np.maximum.accumulate(np.where(hands == UNCERTAIN, 0, np.arange(len(hands))))]
    return decided
