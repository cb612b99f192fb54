"""Winding and magnets from -40 to 120 degrees Celsius: error of the angle, estimated parameters, false alarms."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from tierod.core.claims import Claim, at_most, exactly
from tierod.core.content import Chart, Heading, Item, Lines, Panel, Points, Table
from tierod.core.graph import scan
from tierod.monitors.motor_angle.observer import MotorAngleObserver
from tierod.physics.pm_motor import flux_at, resistance_at
from tierod_lab.ground.cars.motor_bench import MotorBench
from tierod_lab.ground.motor import AFS_MOTOR, Warming
from tierod_lab.ground.varied import Varied
from tierod_lab.papers.motor_angle.fault_drives import bench_time, course
from tierod_lab.papers.motor_angle.healthy_drives import AlarmWatch, bench_monitor
from tierod_lab.papers.motor_angle.observer_drives import ObserverDrive, drive, parameters, to_and_fro
from tierod_lab.papers.motor_angle.reported import SEEDS, TARGET, TEMPERATURE
from tierod_lab.studies.effort import Effort

ZERO = 273.15
"""Zero of the Celsius scale [K]."""
COLD, HOT = -40.0, 120.0
"""Ends of the temperature range [degree Celsius]."""
RAMP = 60.0
"""Duration of a temperature ramp from one end to the other [s]."""


@dataclass(frozen=True)
class AtTemperature:
    """Accuracy of the default observer over drives at one temperature, or over a ramp.

    Args:
        name: name in words
        rms, most: rms and largest error of the angle [rad]
        resistance, flux: true values at the end over those of the vehicle file [-]
        learnt_resistance, learnt_flux: estimated values at the end over those of the vehicle file [-]
        alarms: number of drives with an alarm of any test
        drives: number of drives
    """

    name: str
    rms: float
    most: float
    resistance: float
    flux: float
    learnt_resistance: float
    learnt_flux: float
    alarms: int
    drives: int


def items(effort: Effort) -> Iterator[Item]:
    yield Heading(
        "Temperature",
        (
            "Winding and magnets of the bench's motor are as warm as named; resistance and flux follow. The observer "
            "knows those at 20 °C. A ramp goes through the whole range within a minute, far faster than any motor.",
        ),
    )
    temperatures = (COLD, 20.0, HOT) if effort.quick else (COLD, -20.0, 0.0, 20.0, 40.0, 60.0, 80.0, 100.0, HOT)
    seconds, seeds = (8.0, SEEDS.of(TEMPERATURE, 1)) if effort.quick else (20.0, SEEDS.of(TEMPERATURE, 3))
    constant = [
        judged(f"{degrees:g} °C", degrees, [to_and_fro(seed, seconds, ZERO + degrees) for seed in seeds])
        for degrees in temperatures
    ]
    ramps = [
        judged(f"{begin:g} to {end:g} °C", end, [ramp(seed, begin, end) for seed in seeds])
        for begin, end in ((COLD, HOT), (HOT, COLD))
    ]
    yield _table([*constant, *ramps])
    yield _chart(temperatures, constant)
    yield _ramp_chart(ramp(seeds[0], COLD, HOT))
    yield from _claims(constant, ramps)


def ramp(seed: int, begin: float, end: float) -> ObserverDrive:
    """Simulate a drive in which winding and magnets warm up or cool down.

    Args:
        seed: seed of course and noise
        begin, end: first and last temperature [degree Celsius]
    """
    time = bench_time(RAMP)
    # Small heat capacities let winding and magnets follow the temperature of the air without delay.
    light = Warming(1.0, 1.0, 20.0, 20.0, ambient_temperature=ZERO + begin)
    path = "motor.warming.ambient_temperature"
    plant = Varied(MotorBench(motor=replace(AFS_MOTOR, warming=light)), (path,))
    air = ZERO + begin + (end - begin) * time / RAMP
    return drive(plant, course(time, seed), np.zeros(len(time)), seed, **{f"parameters.{path}": air})


def judged(name: str, degrees: float, drives: list[ObserverDrive]) -> AtTemperature:
    """Evaluate the default observer and the alarms of its monitor.

    Args:
        name: name of the drives
        degrees: temperature at their end [degree Celsius]
        drives: the drives
    """
    p = parameters()[1]
    square, most, alarms, learnt = 0.0, 0.0, 0, np.zeros(2)
    for seen in drives:
        found = seen.observed(MotorAngleObserver(p))
        away = found["motor_angle"] - seen.angle
        square += float(np.mean(away**2))
        most = max(most, float(np.abs(away).max()))
        learnt += found["motor_resistance"][-1] / p.motor_resistance, found["motor_flux"][-1] / p.motor_flux
        alarms += alarmed(seen)
    learnt /= len(drives)
    resistance, flux = resistance_at(ZERO + degrees, 1.0), flux_at(ZERO + degrees, 1.0)
    rms = float(np.sqrt(square / len(drives)))
    return AtTemperature(name, rms, most, resistance, flux, float(learnt[0]), float(learnt[1]), alarms, len(drives))


def alarmed(seen: ObserverDrive) -> bool:
    """Whether any test of the monitor alarms in a drive."""
    watch = AlarmWatch(bench_monitor())
    samples = np.full((len(seen.angle), len(watch.Sample._fields)), np.nan)
    samples[:, : seen.samples.shape[1]] = seen.samples
    return bool(scan(watch, samples)["alarmed"][-1])


def _table(found: list[AtTemperature]) -> Table:
    rows = tuple(
        (
            each.name,
            f"{each.resistance:.2f}, {each.learnt_resistance:.2f}",
            f"{each.flux:.3f}, {each.learnt_flux:.3f}",
            f"{each.rms:.4f}",
            f"{each.most:.3f}",
            f"{each.alarms} of {each.drives}",
        )
        for each in found
    )
    return Table(
        "The default over temperature",
        (
            "",
            "resistance: true, estimated",
            "flux: true, estimated",
            "angle, rms [rad]",
            "angle, most [rad]",
            "false alarms",
        ),
        rows,
        "Resistance and flux at the end, over those of the vehicle file. Of ramps the true ones are those of the air.",
    )


def _chart(temperatures: tuple[float, ...], found: list[AtTemperature]) -> Chart:
    lines = [
        ("resistance", [each.resistance for each in found], [each.learnt_resistance for each in found]),
        ("flux", [each.flux for each in found], [each.learnt_flux for each in found]),
    ]
    marks = [
        mark
        for name, true, learnt in lines
        for mark in (
            Lines(f"{name}, true", temperatures, true, dashed=True),
            Points(f"{name}, estimated", temperatures, learnt),
        )
    ]
    errors = (
        Lines("root mean square", temperatures, [each.rms for each in found]),
        Lines("most", temperatures, [each.most for each in found]),
    )
    return Chart(
        "motor-angle-temperature",
        "The default over temperature",
        "Above: error of the angle. Below: resistance and flux over those of the vehicle file, true and as estimated.",
        "The error hardly depends on the temperature, since resistance and flux are learnt.",
        (
            Panel("", "temperature (°C)", "error of the angle (rad)", errors),
            Panel("", "temperature (°C)", "over the vehicle file's", tuple(marks)),
        ),
    )


def _ramp_chart(seen: ObserverDrive) -> Chart:
    p, kept = parameters()[1], slice(None, None, 100)
    found = seen.observed(MotorAngleObserver(p))
    time = seen.time[kept]
    air = ZERO + COLD + (HOT - COLD) * time / RAMP
    learnt = (
        Lines("resistance, true", time, resistance_at(air, 1.0), dashed=True),
        Lines("resistance, estimated", time, found["motor_resistance"][kept] / p.motor_resistance),
        Lines("flux, true", time, flux_at(air, 1.0), dashed=True),
        Lines("flux, estimated", time, found["motor_flux"][kept] / p.motor_flux),
    )
    away = Lines("error", time, (found["motor_angle"] - seen.angle)[kept])
    return Chart(
        "motor-angle-ramp",
        "A motor that warms from -40 to 120 °C within a minute",
        "Above: resistance and flux over those of the vehicle file. Below: error of the angle.",
        "The observer follows resistance and flux of a motor that warms, and keeps its angle.",
        (
            Panel("", "time (s)", "over the vehicle file's", learnt),
            Panel("", "time (s)", "error of the angle (rad)", (away,)),
        ),
    )


def _claims(constant: list[AtTemperature], ramps: list[AtTemperature]) -> Iterator[Claim]:
    for key, text, found in (
        ("angle", "From -40 to 120 °C: error of the angle, root mean square, at the worst temperature.", constant),
        ("ramp", "Over a ramp through that range within a minute: the same, of the worse direction.", ramps),
    ):
        worst = max(found, key=lambda each: each.rms)
        note = f"{worst.name}; at most {max(each.most for each in found):.3f} rad"
        yield Claim(f"temperature.{key}", text, TARGET, None, worst.rms, at_most(0.006), "rad", note)
    every = [*constant, *ramps]
    yield Claim(
        "temperature.false-alarms",
        "No false alarm at any temperature, nor over ramps.",
        TARGET,
        None,
        float(sum(each.alarms for each in every)),
        exactly(0.0),
        "",
        f"{sum(each.drives for each in every)} drives",
    )
