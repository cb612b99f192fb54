"""The catalogue of canonical signals: name in words, SI unit, meaning, direction (ISO 8855: left positive).

Every reader, monitor, plant and report uses these names. `docs/reference/signals.md` is generated from here."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from math import inf

import numpy as np

from tierod.core.errors import InputError, nearest
from tierod.core.units import COUNT, scale


@dataclass(frozen=True)
class Signal:
    name: str  # in words, as used in every public signature
    unit: str  # SI, in the notation of pint ("rad/s", "N*m", "m/s**2"); "" for a number without unit
    meaning: str
    positive: str = ""
    plausible: tuple[float, float] = (-inf, inf)  # the range that a fault-free road vehicle can reach, in the unit
    aliases: tuple[str, ...] = ()  # names found in recordings, matched without regard to case and punctuation
    group: str = ""  # heading under which the nomenclature lists it


Row = tuple[str, str, str, str, tuple[float, float], str]

# fmt: off
_STEERING: tuple[Row, ...] = (
    ("steering_wheel_angle", "rad", "Angle of the steering wheel.",
     "wheel turned left", (-16.0, 16.0),
     "steer_angle steering_angle swa sw_angle hand_wheel_angle handwheel_angle sas_angle sw_pos sw_pos_obd "
     "lws_angle LenkradWinkel steer_angle_sensor steering_wheel_position str_whl_ang delta_sw strg_whl_ang "
     "steer_wheel_angle steer_whl_ang str_angl_val steered_angle"),
    ("steering_wheel_rate", "rad/s", "Rate of the steering wheel.",
     "turning left", (-25.0, 25.0),
     "steer_rate steering_rate steer_angle_rate steering_angle_rate steering_wheel_speed "
     "steering_wheel_angle_rate steering_wheel_angle_speed steering_wheel_velocity swr hand_wheel_rate "
     "handwheel_rate sas_speed lws_speed str_whl_ang_rate"),
    ("driver_torque", "N*m", "Torque of the driver, measured by the torsion bar.",
     "towards left", (-30.0, 30.0),
     "steer_torque_driver steering_torque_driver torque_driver driver_input_torque hand_torque "
     "hand_wheel_torque handwheel_torque steering_wheel_torque steering_torque steer_torque_sensor "
     "torsion_bar_torque tsu_torque swt str_whl_torque"),
    ("column_assist_torque", "N*m", "Assist torque at the steering column.",
     "towards left", (-120.0, 120.0), "assist_torque_column eps_torque_column column_torque"),
    ("pinion_angle", "rad", "Angle of the pinion, below the torsion bar.",
     "wheel turned left", (-16.0, 16.0), "pinion_position"),
    ("pinion_rate", "rad/s", "Rate of the pinion, below the torsion bar.",
     "turning left", (-25.0, 25.0), ""),
    ("pinion_torque", "N*m", "Torque at the pinion.", "towards left", (-150.0, 150.0), ""),
    ("torsion_bar_twist", "rad", "Twist of the torsion bar, upper end less lower end.",
     "driver steers to the left", (-0.3, 0.3), "torsion_bar_angle"),
    ("rack_position", "m", "Displacement of the rack from straight ahead.",
     "road wheels turned left", (-0.12, 0.12), "rack_displacement rack_travel rack_pos"),
    ("rack_speed", "m/s", "Speed of the rack.", "turning left", (-0.8, 0.8), "rack_velocity"),
    ("rack_force", "N", "Axial force that the rack must overcome.",
     "opposes a turn to the left", (-20000.0, 20000.0), ""),
    ("tie_rod_force", "N", "Axial force of the tie rods, summed over both sides.",
     "opposes a turn to the left", (-20000.0, 20000.0), "tierod_force track_rod_force"),
    ("tie_rod_force_left", "N", "Axial force of the left tie rod.",
     "opposes a turn to the left", (-15000.0, 15000.0), "tierod_force_left"),
    ("tie_rod_force_right", "N", "Axial force of the right tie rod.",
     "opposes a turn to the left", (-15000.0, 15000.0), "tierod_force_right"),
    ("road_wheel_angle", "rad", "Mean steering angle of the front road wheels.",
     "left turn", (-0.9, 0.9), "road_wheel_steer_angle front_wheel_angle rwa delta delta_f steering_tire_angle "
     "steering_tyre_angle tire_angle tyre_angle"),
    ("road_wheel_angle_left", "rad", "Steering angle of the left front wheel.",
     "left turn", (-0.9, 0.9), "delta_fl front_left_wheel_angle"),
    ("road_wheel_angle_right", "rad", "Steering angle of the right front wheel.",
     "left turn", (-0.9, 0.9), "delta_fr front_right_wheel_angle"),
    ("road_wheel_rate", "rad/s", "Rate of the mean steering angle of the front road wheels.",
     "turning left", (-3.0, 3.0), ""),
    ("self_aligning_torque", "N*m", "Torque of both front tyres about the kingpins.",
     "opposes a turn to the left", (-1500.0, 1500.0), "sat aligning_torque aligning_moment"),
    ("road_wheel_torque", "N*m", "Torque of steering system and motors about the kingpins.",
     "towards left", (-3000.0, 3000.0), ""),
)

_ACTUATORS: tuple[Row, ...] = (
    ("motor_torque", "N*m", "Torque of the assist motor at the motor shaft.",
     "towards left", (-15.0, 15.0),
     "assist_torque assist_motor_torque steer_torque_eps steering_torque_eps eps_torque eps_motor_torque "
     "motor_trq emot_torque torque_eps"),
    ("motor_target_torque", "N*m", "Requested torque of the assist motor at the motor shaft.",
     "towards left", (-15.0, 15.0), "motor_torque_request motor_torque_target motor_torque_command"),
    ("feedback_torque", "N*m", "Torque of the feedback motor of a steering without a column.",
     "towards left", (-30.0, 30.0), "feedback_motor_torque"),
    ("steering_torque_request", "N*m", "Steering torque requested by a driver assistance system.",
     "towards left", (-30.0, 30.0),
     "steer_torque_request steer_torque_cmd steer_torque_command lka_torque lkas_torque steering_torque_command"),
    ("steering_motor_1_torque", "N*m", "Torque of the first steering motor at its shaft.",
     "towards left", (-15.0, 15.0), "steer_motor_1_torque"),
    ("steering_motor_2_torque", "N*m", "Torque of the second steering motor at its shaft.",
     "towards left", (-15.0, 15.0), "steer_motor_2_torque"),
    ("steering_motor_1_target_torque", "N*m", "Requested torque of the first steering motor.",
     "towards left", (-30.0, 30.0), ""),
    ("steering_motor_2_target_torque", "N*m", "Requested torque of the second steering motor.",
     "towards left", (-30.0, 30.0), ""),
    ("steering_shaft_torque", "N*m", "Torque in the steering shaft, measured below the steering motors.",
     "towards left", (-150.0, 150.0), ""),
    ("target_steering_wheel_angle", "rad", "Requested steering-wheel angle.",
     "wheel turned left", (-30.0, 30.0),
     "steering_wheel_angle_target steering_angle_command steer_angle_cmd steering_angle_request"),
    ("target_road_wheel_angle", "rad", "Requested mean steering angle of the front road wheels.",
     "left turn", (-0.9, 0.9), "road_wheel_angle_target"),
    ("target_motor_angle_mechanical", "rad", "Requested mechanical angle of the motor shaft.",
     "as motor torque", (-inf, inf), "target_motor_angle motor_angle_target"),
    ("target_rack_position", "m", "Requested displacement of the rack.",
     "road wheels turned left", (-0.12, 0.12), "rack_position_target"),
    ("drive_torque_left", "N*m", "Drive torque of the left wheel motor at the wheel.",
     "accelerates forward", (-4000.0, 4000.0), ""),
    ("drive_torque_right", "N*m", "Drive torque of the right wheel motor at the wheel.",
     "accelerates forward", (-4000.0, 4000.0), ""),
    ("target_drive_torque_left", "N*m", "Requested drive torque of the left wheel.",
     "accelerates forward", (-4000.0, 4000.0), ""),
    ("target_drive_torque_right", "N*m", "Requested drive torque of the right wheel.",
     "accelerates forward", (-4000.0, 4000.0), ""),
    ("target_vehicle_speed", "m/s", "Requested forward speed.",
     "forward", (-20.0, 90.0), "speed_target target_speed vehicle_speed_target"),
)

_MOTOR: tuple[Row, ...] = (
    ("motor_angle_mechanical", "rad", "Mechanical angle of the motor shaft.",
     "as motor torque", (-inf, inf), "motor_angle motor_position rotor_angle rotor_position motor_shaft_angle"),
    ("motor_angle_electrical", "rad", "Electrical angle of the rotor: pole pairs times the mechanical angle.",
     "as motor torque", (-inf, inf), "electrical_angle motor_electrical_angle theta_el theta_elec"),
    ("motor_speed", "rad/s", "Mechanical speed of the motor shaft.",
     "as motor torque", (-1500.0, 1500.0), "motor_velocity rotor_speed servo_motor_speed motor_rpm emot_speed"),
    ("motor_current_a", "A", "Current of phase a.", "into the motor", (-300.0, 300.0), "i_a ia phase_current_a"),
    ("motor_current_b", "A", "Current of phase b.", "into the motor", (-300.0, 300.0), "i_b ib phase_current_b"),
    ("motor_current_c", "A", "Current of phase c.", "into the motor", (-300.0, 300.0), "i_c ic phase_current_c"),
    ("motor_current_alpha", "A", "Current along the stator axis alpha (amplitude-invariant).",
     "into the motor", (-300.0, 300.0), "i_alpha ialpha sless_i_alpha"),
    ("motor_current_beta", "A", "Current along the stator axis beta (amplitude-invariant).",
     "into the motor", (-300.0, 300.0), "i_beta ibeta sless_i_beta"),
    ("motor_current_d", "A", "Current along the rotor flux.",
     "into the motor", (-300.0, 300.0), "current_d direct_current"),
    ("motor_current_q", "A", "Current across the rotor flux, which makes the torque.",
     "as motor torque", (-300.0, 300.0), "i_q iq current_q"),
    ("motor_voltage_a", "V", "Voltage of phase a to the star point.", "into the motor", (-100.0, 100.0), "u_a v_a"),
    ("motor_voltage_b", "V", "Voltage of phase b to the star point.", "into the motor", (-100.0, 100.0), "u_b v_b"),
    ("motor_voltage_c", "V", "Voltage of phase c to the star point.", "into the motor", (-100.0, 100.0), "u_c v_c"),
    ("motor_voltage_alpha", "V", "Voltage along the stator axis alpha.",
     "into the motor", (-100.0, 100.0), "u_alpha v_alpha valpha ualpha sless_v_alpha"),
    ("motor_voltage_beta", "V", "Voltage along the stator axis beta.",
     "into the motor", (-100.0, 100.0), "u_beta v_beta vbeta ubeta sless_v_beta"),
    ("motor_target_voltage_alpha", "V", "Voltage along the stator axis alpha that is commanded to the inverter.",
     "into the motor", (-100.0, 100.0), ""),
    ("motor_target_voltage_beta", "V", "Voltage along the stator axis beta that is commanded to the inverter.",
     "into the motor", (-100.0, 100.0), ""),
    ("motor_duty_cycle_a", "", "Share of the period for which phase a is tied to the supply.",
     "", (0.0, 1.0), "duty_a pwm_duty_a"),
    ("motor_duty_cycle_b", "", "Share of the period for which phase b is tied to the supply.",
     "", (0.0, 1.0), "duty_b pwm_duty_b"),
    ("motor_duty_cycle_c", "", "Share of the period for which phase c is tied to the supply.",
     "", (0.0, 1.0), "duty_c pwm_duty_c"),
    ("motor_voltage_d", "V", "Voltage along the rotor flux.", "into the motor", (-100.0, 100.0), "u_d v_d"),
    ("motor_voltage_q", "V", "Voltage across the rotor flux.", "as motor torque", (-100.0, 100.0), "u_q v_q"),
    ("motor_current", "A", "Current of a brushed motor, or the torque-making current.",
     "as motor torque", (-300.0, 300.0), "eps_motor_current"),
    ("resolver_sine", "V", "Sine output of the motor angle sensor.", "", (-6.0, 6.0), "resolver_sin sin_signal"),
    ("resolver_cosine", "V", "Cosine output of the motor angle sensor.", "", (-6.0, 6.0), "resolver_cos cos_signal"),
    ("motor_temperature", "K", "Temperature of the motor winding.",
     "", (220.0, 480.0), "motor_temp winding_temperature"),
    ("controller_temperature", "K", "Temperature of the power stage.",
     "", (220.0, 440.0), "ecu_temperature ecu_temp inverter_temperature"),
    ("ambient_temperature", "K", "Temperature of the outside air.",
     "", (210.0, 340.0), "outside_temperature ambient_temp outside_temp"),
    ("supply_voltage", "V", "Voltage of the supply at the controller.",
     "", (0.0, 70.0), "battery_voltage u_batt ubat dc_voltage vdc terminal_voltage"),
    ("supply_current", "A", "Current drawn from the supply.", "drawn", (-200.0, 300.0), "battery_current dc_current"),
)

_WHEEL_ALIASES = "wheel_speed_{0} ws_{0} wss_{0} vel_{0} vel_{0}_obd whl_spd_{0} v_{0} v_wheel_{0} speed_{0}"

_WHEELS = tuple(
    (f"wheel_speed_{end}_{side}", "m/s", f"Circumferential speed of the {end} {side} wheel.", "forward", (-20.0, 90.0),
     _WHEEL_ALIASES.format(end[0] + side[0]) + f" {end}_{side}_wheel_speed")
    for end in ("front", "rear")
    for side in ("left", "right")
)

_VEHICLE: tuple[Row, ...] = (
    ("vehicle_speed", "m/s", "Forward speed at the centre of gravity.",
     "forward", (-20.0, 90.0),
     "speed v velocity v_x vx vehicle_velocity vehspd veh_spd car_speed speedo speedo_obd speed_kps "
     "longitudinal_velocity v_ego vego ground_speed gps_speed v_ist veh_spd_val fahrzeuggeschwindigkeit"),
    *_WHEELS,
    ("yaw_rate", "rad/s", "Yaw rate.",
     "left turn", (-2.0, 2.0), "yaw yawrate psi_dot psidot yaw_velocity gyro_z gier_rate yaw_rate_sensor "
     "gyro_yaw heading_rate yaw_rt gps_gyro angular_velocity_z angular_velocity.z yaw_rt_val"),
    ("yaw_acceleration", "rad/s**2", "Yaw acceleration.",
     "left turn", (-15.0, 15.0), "yaw_ang_acc yaw_rate_derivative"),
    ("roll_rate", "rad/s", "Roll rate.", "right side down", (-2.0, 2.0), "roll_velocity"),
    ("roll_angle", "rad", "Roll of the body against the road.", "right side down", (-0.4, 0.4), "roll"),
    ("pitch_angle", "rad", "Pitch of the body against the road.", "nose down", (-0.4, 0.4), "pitch"),
    ("longitudinal_acceleration", "m/s**2", "Longitudinal acceleration at the centre of gravity.",
     "speeding up", (-15.0, 15.0), "ax a_x acc_x accel_x long_acc longacc long_accel longitudinal_accel ax_cg "
     "g_force_long acceleration_longitudinal gps_long_acc gps_lon_acc linear_acceleration.x"),
    ("lateral_acceleration", "m/s**2", "Lateral acceleration at the centre of gravity.",
     "left turn", (-15.0, 15.0), "ay a_y acc_y accel_y lat_acc latacc lat_acc_obd lat_accel lateral_accel ay_cg "
     "g_force_lat acceleration_lateral gps_lat_acc linear_acceleration.y lat_accel_val"),
    ("vertical_acceleration", "m/s**2", "Vertical acceleration at the centre of gravity, without gravity.",
     "up", (-30.0, 30.0), "az a_z acc_z accel_z"),
    ("lateral_speed", "m/s", "Lateral speed at the centre of gravity.",
     "to the left", (-20.0, 20.0), "v_y vy lateral_velocity"),
    ("sideslip_angle", "rad", "Sideslip angle at the centre of gravity.",
     "moving to the left of the heading", (-0.8, 0.8), "beta slip_angle side_slip side_slip_angle beta_true"),
    ("brake_pressure", "Pa", "Pressure of the master brake cylinder.",
     "", (-5.0e5, 3.0e7), "brake_pressure_obd master_cylinder_pressure brk_press"),
    ("accelerator_pedal", "", "Position of the accelerator pedal, 0 to 1.",
     "", (0.0, 1.0), "gas_pedal throttle_pedal accelerator_position"),
    ("lane_keeping_active", "", "Whether a system other than the driver steers, 0 or 1.",
     "", (0.0, 1.0), "lka_active lkas_active"),
    ("heading", "rad", "Direction of travel against the x axis of the map.",
     "turned left", (-inf, inf), "yaw_angle psi"),
    ("position_x", "m", "Position on the map, x.", "", (-inf, inf), ""),
    ("position_y", "m", "Position on the map, y.", "", (-inf, inf), ""),
)

_TRUTH: tuple[Row, ...] = (
    ("friction_torque", "N*m", "Friction of the steering at the steering-wheel axis.",
     "opposes a turn to the left", (-40.0, 40.0), ""),
    ("friction_level", "N*m", "Level of Coulomb friction of the steering at the steering-wheel axis.",
     "", (0.0, 40.0), ""),
    ("bank_angle", "rad", "Bank of the road.", "right side down", (-0.4, 0.4), "bank road_bank"),
    ("grade_angle", "rad", "Grade of the road.", "uphill", (-0.4, 0.4), "grade road_grade"),
    ("road_friction", "", "Coefficient of friction between tyre and road.", "", (0.0, 2.0), "mu"),
    ("crosswind_force", "N", "Lateral force of the wind.", "to the left", (-5000.0, 5000.0), ""),
    ("front_lateral_force", "N", "Lateral force of the front axle.", "left turn", (-30000.0, 30000.0), ""),
    ("rear_lateral_force", "N", "Lateral force of the rear axle.", "left turn", (-30000.0, 30000.0), ""),
    ("load_torque", "N*m", "Load of the motor at its shaft.", "opposes motor torque", (-15.0, 15.0), "m_load"),
)

# fmt: on

_GROUPS: dict[str, tuple[Row, ...]] = {
    "Steering": _STEERING,
    "Actuators and their targets": _ACTUATORS,
    "Steering motor": _MOTOR,
    "Vehicle": _VEHICLE,
    "Truth of a simulation": _TRUTH,
}

# Every canonical signal by name
SIGNALS: dict[str, Signal] = {
    name: Signal(name, unit, meaning, positive, plausible, tuple(aliases.split()), group)
    for group, rows in _GROUPS.items()
    for name, unit, meaning, positive, plausible, aliases in rows
}


def signal(name: str) -> Signal:
    try:
        return SIGNALS[name]
    except KeyError:
        raise InputError(f"'{name}' is not a canonical signal{nearest(name, SIGNALS)}") from None


def plain(name: str) -> str:
    """A name in lower case without punctuation, for comparison."""
    return "".join(character for character in name.lower() if character.isalnum())


# Ambiguous aliases: they name a quantity, but not what it belongs to
_GENERAL = (
    "speed", "velocity", "v", "yaw", "roll", "pitch", "psi", "beta", "delta", "mu", "bank", "grade", "sat"
)  # fmt: skip

_SEPARATORS = ("::", ".", "/", ":", "\\")


@cache
def _by_alias() -> dict[str, Signal]:
    table = {plain(alias): found for found in SIGNALS.values() for alias in found.aliases}
    return table | {plain(name): found for name, found in SIGNALS.items()}


def match(source: str, unit: str = "", qualified: bool = False) -> Signal | None:
    """The canonical signal that a name from a recording stands for, by name or alias; None where none is known.

    An ambiguous alias after a qualifier counts only with a suitable unit: "Engine.Speed" is the speed of the vehicle
    only in a unit of speed, such as km/h.

    Args:
        source: name in the file; of "EPS.DriverTorque" the part after the last separator is tried too
        unit: as the file writes it; "" where it has none
    """
    found = _known(source, unit, qualified)
    for separator in _SEPARATORS:
        if found is None and separator in source:
            found = _known(source.rsplit(separator, 1)[1], unit, True)
    return found


def _known(source: str, unit: str, qualified: bool) -> Signal | None:
    name = plain(source)
    found = _by_alias().get(name)
    doubtful = qualified and name in _GENERAL
    return None if found is None or (doubtful and not _fits(unit, found)) else found


def _fits(unit: str, found: Signal) -> bool:
    try:
        return bool(unit.strip()) and unit != COUNT and bool(scale(unit, found.unit))
    except InputError:
        return False


# Relative residues: two units in the last place of single precision, 256 of double precision. Conversions, means and
# interpolations of equal readings differ by less. The resolution of a 20-bit converter is four times the former.
SINGLE, DOUBLE = 2.0**-22, 2.0**-44

# Magnitude assumed for a signal without a plausible range [its unit]: five turns of the pinion in motor angle
UNBOUNDED = 100.0


@lru_cache
def residue_of(name: str) -> float:
    """Largest difference of two readings of a canonical signal that counts as rounding residue [its unit].

    It follows from the plausible range, not from the recording: the range is known at the first sample, and no fault
    changes it.
    """
    size = max(map(abs, SIGNALS[name].plausible))
    return SINGLE * (size if math.isfinite(size) else UNBOUNDED)


def residue_between(least: float, most: float) -> float:
    """Largest difference of two values of any channel that counts as rounding residue [its unit].

    Single precision applies to the range of the values, not to their magnitude: a position of five million metres may
    change by centimetres.
    """
    return max(SINGLE * (most - least), DOUBLE * max(abs(least), abs(most)))


def levels_of(values: np.ndarray, residue: float) -> tuple[np.ndarray, np.ndarray]:
    """Distinct values in increasing order, merged where they differ by a residue, and the number of each.

    Args:
        values: finite, (n,)
    """
    distinct, counts = np.unique(values, return_counts=True)
    first = np.flatnonzero(np.diff(distinct, prepend=-math.inf) > residue)
    return distinct[first], np.add.reduceat(counts, first) if len(first) else counts
