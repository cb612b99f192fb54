"""Short recordings of virtual cars for tests of fleets: made once for each seed, copied with another date."""

from functools import cache
from pathlib import Path

from tierod.core.errors import OutputError
from tierod.core.recording import Recording
from tierod.fleet.fleet_file import one_vehicle
from tierod.fleet.judging import Asked
from tierod.fleet.running import run
from tierod.io.writers import write
from tierod.monitors.runner import Chosen
from tierod.work.pool import done

SECONDS = 40.0
DAY = 86400.0
NOVEMBER = 1761955200.0  # 2025-11-01 00:00 UTC
SIGNALS = ("steering_wheel_angle", "steering_wheel_rate", "driver_torque", "motor_torque", "yaw_rate",
           "lateral_acceleration", "vehicle_speed")  # fmt: skip


@cache
def driven(seed=1, seconds=SECONDS):
    """A recording of the mid-size car with the signals of the friction monitor and the truth."""
    from tierod_lab.ground.scenarios import load

    recording = load("mixed-drive-healthy").with_run(seed=seed, seconds=seconds).run().recording
    kept = (*SIGNALS, "truth_friction_torque")
    return Recording({name: recording[name] for name in kept}, {"vehicle_file": "midsize-eps"})


def written(path, seed=1, start=NOVEMBER, seconds=SECONDS, **metadata):
    """A recording as a Parquet file that begins at a time, seconds since 1970."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    recording = driven(seed, seconds)
    write(Recording(recording.channels, {**recording.metadata, "origin": start, **metadata}), path)
    return path


class Here:
    """Workers in this process, one task after the other; what a test counts."""

    def __init__(self):
        self.tasks = []

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def start(self, work, count):
        pass

    def run(self, work, tasks):
        for number, task in enumerate(tasks):
            self.tasks.append(task.found.name)
            result = done(work, task)
            if isinstance(result, OSError | OutputError):
                raise result
            yield number, result


FRICTION = Asked((Chosen("friction"),), spread=False)


def judged(recordings, results, fleet=None, asked=FRICTION, workers=None, **options):
    """A run in this process; one vehicle for all where no fleet is given."""
    given = [str(recordings)] if isinstance(recordings, str | Path) else [str(each) for each in recordings]
    return run(given, fleet or one_vehicle("midsize-eps"), results, asked, workers or Here(), **options)
