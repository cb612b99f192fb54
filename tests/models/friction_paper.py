"""Parameters of the mid-size car, written out so that no file decides a test."""

from tierod.models.steering_column import FrictionParameters

CAR = FrictionParameters(
    mass=1600.0,
    yaw_inertia=2800.0,
    front_distance=1.14,
    rear_distance=1.69,
    trail=0.05,
    steering_ratio=1.0 / 15.5,
    column_inertia=0.10,
    column_damping=0.8,
    motor_ratio=20.0,
    sample_time=0.01,
)
