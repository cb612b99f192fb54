"""Writes the recording of `tierod demo`: a simulated drive whose friction rises from 4 to 8 N·m half-way.

It holds the signals of a production car alone, rounded as on its CAN bus, so that the file is small and holds no truth.
"""

from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet

from tierod.core.recording import Channel, Recording
from tierod.io.writers import write
from tierod_lab.ground import FrictionCourse, drive

TARGET = Path(__file__).parents[1] / "packages/tierod/src/tierod/io/demo-drive.parquet"
MINUTES = 13.0
# Resolution of each signal on the bus [its unit]
STEPS = {
    "steering_wheel_angle": np.radians(0.05),
    "steering_wheel_rate": np.radians(0.5),
    "driver_torque": 0.01,
    "motor_torque": 0.002,
    "yaw_rate": np.radians(0.02),
    "lateral_acceleration": 0.01,
    "vehicle_speed": 0.01,
}

if __name__ == "__main__":
    driven = drive(minutes=MINUTES, friction=FrictionCourse.step(4.0, 8.0, at=30.0 * MINUTES), seed=1)
    channels = {
        name: Channel(name, driven[name].time, np.round(driven[name].values / step) * step, driven[name].unit)
        for name, step in STEPS.items()
    }
    write(Recording(channels, {"source": "tierod virtual test vehicle"}), TARGET)
    parquet.write_table(parquet.read_table(TARGET), TARGET, compression="zstd", compression_level=19)
    print(TARGET, TARGET.stat().st_size)
