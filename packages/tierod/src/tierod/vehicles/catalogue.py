"""Catalogue of vehicle parameters: name, unit, meaning and plausible range.

Parameter dataclasses of models and monitors, and vehicle files, use these names.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Quantity:
    """One parameter of a vehicle file."""

    name: str  # of the field in parameter dataclasses
    unit: str  # SI, in the notation of pint; "" for a dimensionless number
    meaning: str  # one sentence fragment, with the point of reference
    # smallest and largest value of a real vehicle, in the unit; others indicate a wrong unit
    plausible: tuple[float, float]
    torque: bool = False  # whether it is a steering torque, which an uncalibrated car gives in counts
    whole: bool = False  # whether it is a whole number, which has no spread


_CATALOGUE = (
    Quantity("mass", "kg", "mass of the vehicle as driven", (200.0, 60e3)),
    Quantity("yaw_inertia", "kg*m**2", "moment of inertia about the vertical axis", (50.0, 1e6)),
    Quantity("front_distance", "m", "centre of gravity to front axle", (0.2, 8.0)),
    Quantity("rear_distance", "m", "centre of gravity to rear axle", (0.2, 8.0)),
    Quantity("wheelbase", "m", "distance of the axles: sum of both distances of the centre of gravity", (0.8, 12.0)),
    Quantity("front_cornering_stiffness", "N/rad", "both front tyres together (axle)", (5e3, 2e6)),
    Quantity("rear_cornering_stiffness", "N/rad", "both rear tyres together (axle)", (5e3, 2e6)),
    Quantity("trail", "m", "mechanical and pneumatic trail together", (1e-3, 0.5)),
    Quantity("mechanical_trail", "m", "caster trail alone", (-0.1, 0.3)),
    Quantity("pneumatic_trail", "m", "trail of the tyres alone, at small slip", (0.0, 0.2)),
    Quantity("road_wheel_inertia", "kg*m**2", "steering without column, at the road wheels", (0.1, 100.0)),
    Quantity("road_wheel_damping", "N*m*s/rad", "viscous damping of the steering without column", (0.0, 5e3)),
    Quantity("road_wheel_friction", "N*m", "dry friction of the steering without column", (0.0, 1e3)),
    Quantity("centre_height", "m", "centre of gravity above ground", (0.1, 3.0)),
    Quantity("relaxation_length", "m", "rolled distance over which an axle's force builds up", (0.02, 3.0)),
    Quantity("tyre_friction", "", "greatest lateral force over load, front axle on dry road", (0.05, 3.0)),
    Quantity("rear_friction_ratio", "", "greatest force over load of the rear axle over the front one's", (0.3, 3.0)),
    Quantity("front_force_shape", "", "C of the Magic Formula of the front axle", (0.8, 1.9)),
    Quantity("rear_force_shape", "", "C of the Magic Formula of the rear axle", (0.8, 1.9)),
    Quantity("trail_shape", "", "Ct of the pneumatic trail", (0.8, 1.9)),
    Quantity("stiffness_growth", "", "relative growth of cornering stiffness per relative growth of load", (-1.0, 2.0)),
    Quantity("roll_share", "", "lateral acceleration that gravity adds by body roll, per acceleration", (-0.3, 0.5)),
    Quantity("sensor_forward", "m", "accelerometer ahead of the centre of gravity", (-5.0, 5.0)),
    Quantity("drive_front_share", "", "share of the driving force at the front axle", (0.0, 1.0)),
    Quantity("brake_front_share", "", "share of the braking force at the front axle", (0.0, 1.0)),
    Quantity("yaw_rate_noise", "rad/s", "standard deviation of one reading, vibration included", (1e-5, 0.2)),
    Quantity("yaw_rate_resolution", "rad/s", "step between two readings of the sensor", (1e-6, 0.1)),
    Quantity("lateral_acceleration_noise", "m/s**2", "standard deviation of a reading, with vibration", (1e-3, 20.0)),
    Quantity("lateral_speed_drift", "m/s**1.5", "growth of the tyre model's error in the lateral speed", (1e-4, 5.0)),
    Quantity("yaw_rate_drift", "rad/s**1.5", "growth of the tyre model's error in the yaw rate", (1e-4, 5.0)),
    Quantity(
        "stiffness_wander", "", "relative standard deviation of the cornering stiffness; 0 if constant", (0.0, 1.0)
    ),
    Quantity("stiffness_wander_time", "s", "time in which the stiffness returns to its value", (0.1, 1e6)),
    Quantity("friction_wander", "", "relative standard deviation of the tyres' friction; 0 if constant", (0.0, 1.0)),
    Quantity("bank_wander", "rad", "standard deviation of the road's bank; 0 without", (0.0, 0.5)),
    Quantity("bank_wander_time", "s", "time over which the bank changes", (0.1, 1e4)),
    Quantity("lateral_acceleration_wander", "m/s**2", "standard deviation of the sensor's bias; 0 without", (0.0, 5.0)),
    Quantity("lateral_acceleration_wander_time", "s", "time over which the bias changes", (0.1, 1e6)),
    Quantity("road_wheel_angle_wander", "rad", "standard deviation of the error of the steering angle", (0.0, 0.3)),
    Quantity(
        "road_wheel_angle_wander_time", "s", "time over which the error of the steering angle changes", (0.01, 1e6)
    ),
    Quantity("wind_wander", "N", "standard deviation of the lateral force of the wind; 0 without", (0.0, 1e4)),
    Quantity("gearhead_ratio", "", "turns of a steer-by-wire motor per turn of the pinion", (1.0, 500.0)),
    Quantity("gearhead_efficiency", "", "share of the motor's torque that passes the gearhead", (0.05, 1.0)),
    Quantity("power_assist_factor", "", "torque at the pinion over that of the actuator", (1.0, 50.0)),
    Quantity("steering_ratio", "", "road wheel angle per steering wheel angle, about 1/15.5", (0.01, 1.0)),
    Quantity(
        "steering_ratio_growth",
        "1/rad**2",
        "relative growth of the steering ratio with the squared angle; 0 if absent",
        (-1.0, 1.0),
    ),
    Quantity("column_inertia", "kg*m**2", "wheel, column, rotor and road wheels at the wheel axis", (1e-3, 5.0)),
    Quantity("column_damping", "N*m*s/rad", "viscous damping at the steering wheel axis", (0.0, 20.0)),
    Quantity("steering_wheel_inertia", "kg*m**2", "part of the column's inertia above the torsion bar", (0.0, 1.0)),
    Quantity("steering_wheel_damping", "N*m*s/rad", "part of the column's damping above the torsion bar", (0.0, 10.0)),
    Quantity(
        "torsion_bar_stiffness", "N*m/rad", "stiffness of the bar that measures the driver's torque", (20.0, 2000.0)
    ),
    Quantity("motor_ratio", "", "turns of the assist motor per turn of the steering wheel", (0.5, 200.0)),
    Quantity("gear_stiffness", "N*m/rad", "stiffness between motor and gear, at the motor's shaft", (0.05, 1e4)),
    Quantity("gear_inertia", "kg*m**2", "worm wheel and worm at the steering wheel axis", (1e-6, 0.5)),
    Quantity("motor_inertia", "kg*m**2", "rotor of the assist motor at its own shaft", (1e-6, 0.05)),
    Quantity("motor_damping", "N*m*s/rad", "viscous damping of the assist motor at its own shaft", (0.0, 1.0)),
    Quantity("motor_friction", "N*m", "dry friction at the shaft of the assist motor", (0.0, 5.0)),
    Quantity(
        "motor_friction_stiffness",
        "N*m/rad",
        "slope with which dry friction at the motor builds up from rest",
        (1e-3, 1e5),
    ),
    Quantity("motor_resistance", "ohm", "resistance of a phase of the motor at 20 °C", (1e-3, 10.0)),
    Quantity(
        "motor_inductance",
        "H",
        "inductance of a phase of the motor; along the flux where motor_saliency is given",
        (1e-6, 0.1),
    ),
    Quantity("motor_saliency", "", "inductance of the motor across the flux over that along it", (0.3, 10.0)),
    Quantity("motor_flux", "V*s", "flux linkage of the rotor's magnets at 20 °C", (1e-4, 2.0)),
    Quantity("motor_pole_pairs", "", "electrical turns per turn of the motor", (1.0, 40.0), whole=True),
    Quantity("inverter_voltage_loss", "V", "voltage loss of a phase by dead time and semiconductors", (0.0, 20.0)),
    Quantity("inverter_knee_current", "A", "phase current below which that loss is proportional to it", (1e-3, 100.0)),
    Quantity("superposition_motor_ratio", "", "turns of a superposition's motor per turn of the pinion", (1.0, 200.0)),
    Quantity(
        "superposition_input_ratio", "", "turns of the steering wheel's shaft per turn of the pinion", (0.1, 10.0)
    ),
    Quantity("superposition_gain_standing", "", "turn of the pinion over its turn without motor, at rest", (0.1, 10.0)),
    Quantity(
        "superposition_gain_fast", "", "turn of the pinion over its turn without motor, at very high speed", (0.1, 10.0)
    ),
    Quantity("superposition_gain_speed", "m/s", "speed at which the gain is half-way between both", (0.1, 100.0)),
    Quantity("motor_torque_constant", "N*m/A", "torque of the assist motor per ampere", (1e-3, 2.0)),
    Quantity("assist_linear_gain", "", "assist over driver's torque at rest, at the steering wheel", (0.1, 50.0)),
    Quantity("assist_quadratic_gain", "1/(N*m)", "growth of the assist gain with the driver's torque", (0.01, 50.0)),
    Quantity("assist_half_speed", "m/s", "speed at which assist has fallen to a half", (1.0, 100.0)),
    Quantity("maximum_assist_torque", "N*m", "largest assist at the steering wheel axis", (1.0, 500.0), torque=True),
    Quantity("nominal_friction", "N*m", "fault-free friction at the steering wheel axis", (0.1, 50.0), torque=True),
    Quantity("rising_friction", "N*m", "friction from which it is reported as rising", (0.1, 100.0), torque=True),
    Quantity("fault_friction", "N*m", "friction from which it is reported as a fault", (0.1, 100.0), torque=True),
    Quantity(
        "torque_gain_deviation",
        "",
        "relative standard deviation of the gain that driver_torque and motor_torque share; 0.08 without an entry",
        (0.0, 0.3),
    ),
    Quantity("baseline_variance", "N**2*m**2", "variance of self-aligning torques that means a fault", (1.0, 1e7)),
    Quantity("rear_relaxation_ratio", "", "relaxation length of the rear axle over that of the front", (0.1, 10.0)),
    Quantity(
        "front_load_transfer", "", "load transferred to the outer front wheel per lateral force of the axle", (0.0, 1.0)
    ),
    Quantity("roll_frequency", "rad/s", "natural frequency of the body's roll", (3.0, 60.0)),
    Quantity("roll_damping_ratio", "", "damping of the body's roll over the critical one", (0.0, 2.0)),
    Quantity("roll_arm", "m", "centre of gravity above the roll axis", (-0.5, 2.0)),
    Quantity("road_wheel_friction_angle", "rad", "angle over which friction at the road wheels builds up", (1e-5, 0.1)),
    Quantity("noticeable_friction", "N*m", "friction from which a driver feels it", (0.1, 100.0), torque=True),
    Quantity("rolling_mass", "kg", "equivalent mass of the rotation of all wheels", (0.0, 5e3)),
    Quantity("track_width", "m", "distance of the wheels of an axle", (0.3, 3.5)),
    Quantity("turn_slip_stiffness", "N*m**2", "torque of one wheel per turn on a metre of road", (0.0, 1e4)),
    Quantity("jacking_torque", "N*m/rad", "torque of the front wheels' load, per road wheel angle", (-2e3, 2e3)),
    Quantity("scrub_radius", "m", "contact centre outside the kingpin axis, at the ground", (-0.2, 0.3)),
    Quantity("wheel_radius", "m", "effective radius of the driven wheels", (0.1, 1.0)),
    Quantity("rolling_resistance", "N", "rolling resistance of all wheels together", (0.0, 2e4)),
    Quantity("drag", "N*s**2/m**2", "air resistance per squared speed", (0.0, 20.0)),
    Quantity("rack_ratio", "m/rad", "travel of the rack per angle of the column", (1e-3, 0.05)),
    Quantity("steering_motor_inertia", "kg*m**2", "steering motors at the column, above a torque sensor", (0.0, 1.0)),
    Quantity("rack_damping", "N*s/m", "viscous damping of the rack by itself", (0.0, 1e6)),
    Quantity("rack_stiffness", "N/m", "spring that centres the rack by itself", (0.0, 1e7)),
    Quantity("column_friction_angle", "rad", "angle over which dry friction at the column builds up", (1e-4, 0.5)),
    Quantity("wheel_speed_scale", "", "reading of both rear wheel speeds over the true speed", (0.7, 1.4)),
    Quantity("wheel_speed_difference", "", "excess of the right over the left rear wheel's reading", (-0.2, 0.2)),
    Quantity("yaw_rate_offset", "rad/s", "reading of the sensor at rest", (-0.3, 0.3)),
    Quantity("steering_wheel_angle_offset", "rad", "reading of the sensor straight ahead", (-1.0, 1.0)),
    Quantity("steering_shaft_torque_offset", "N*m", "reading of the sensor without load", (-10.0, 10.0)),
    Quantity("tie_rod_force_offset", "N", "reading of the sensor without load", (-2e3, 2e3)),
    Quantity("longitudinal_acceleration_offset", "m/s**2", "reading of the sensor on level ground", (-3.0, 3.0)),
    Quantity("lateral_acceleration_offset", "m/s**2", "reading of the sensor on level ground", (-3.0, 3.0)),
    Quantity("greatest_steering_motor_torque", "N*m", "largest torque of one steering motor at its shaft", (0.1, 1e3)),
    Quantity("greatest_drive_torque", "N*m", "largest torque of one drive at its wheel", (1.0, 1e5)),
    Quantity("steering_motor_lag", "s", "time constant of a steering motor's torque behind its target", (0.0, 0.5)),
    Quantity("drive_lag", "s", "time constant of a drive's torque behind its target", (0.0, 1.0)),
)

# All parameters that a vehicle file may contain, by name
QUANTITIES: dict[str, Quantity] = {quantity.name: quantity for quantity in _CATALOGUE}
