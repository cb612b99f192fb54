"""Titles of columns as loggers write them, and the signals that they mean."""

import numpy as np
import pytest

from tierod.io.proposal.units import candidates
from tierod.io.proposal.words import counts_turns, meant_by
from tierod.io.readers.source import Column

TITLES = {
    "steering_wheel_angle": (
        "Lenkradwinkel",
        "LWS.Winkel",
        "StrWhlAng",
        "StrWhlAngl",
        "SW_pos_obd",
        "volant_angle",
        "Steering.Angle",
    ),
    "steering_wheel_rate": ("Lenkradwinkelgeschwindigkeit", "SteeringWheelSpeed"),
    "driver_torque": (
        "Handmoment",
        "Fahrerhandmoment",
        "LenkradMoment",
        "SteerTrqDrv",
        "EPS_1.TorsionBarTorque",
        "EPS_Fahrermoment",
        "DrvTrq",
        "DrvrTq",
        "TBT",
    ),
    "motor_torque": ("EPS_Motormoment", "Unterstützungsmoment", "SteerTorqueMotor", "MotTrq", "EPSMotTrq"),
    "yaw_rate": ("Gierrate", "Giergeschwindigkeit", "psi_dot", "omega_z", "Vitesse_Lacet", "YawRate", "YR"),
    "lateral_acceleration": ("Querbeschleunigung", "LatAcc_obd", "accY", "AccLat"),
    "longitudinal_acceleration": ("Längsbeschleunigung", "Laengsbeschleunigung", "LongAccel"),
    "vehicle_speed": ("Fahrzeuggeschwindigkeit", "Geschwindigkeit", "GPS_Speed", "v_Fzg"),
    "wheel_speed_front_left": ("Radgeschwindigkeit_VL", "WhlSpdFL", "VelFL_obd"),
    "wheel_speed_front_right": ("Radgeschwindigkeit vorne rechts", "v_FR"),
    "wheel_speed_rear_left": ("RadGeschwindigkeitHL", "n_HL", "wheel_speed_rl"),
    "wheel_speed_rear_right": ("Raddrehzahl_hinten_rechts", "WheelSpeed_RR"),
    "sideslip_angle": ("Schwimmwinkel", "Correvit_slip_angle_COG"),
    "rack_force": ("Zahnstangenkraft",),
    "brake_pressure": ("Bremsdruck", "brake_pressure_obd"),
    "motor_speed": ("EPS_Motordrehzahl",),
}

STRANGERS = (
    "Engine_Speed", "EngineTorque", "Tire_Pressure_FL", "WheelSlip_FL", "Radius", "Radar_Speed", "Wind_Speed",
    "Bremsdruck_VL", "Bremsmoment", "Kilometerstand", "Lenkradwinkel_Status", "steering_ratio", "Drehzahl",
    "MotTrqReq", "DrvTrqReq", "DriveMotTrq", "EngineMotTrq", "MotTrq_Front", "DrvShaftTrq",
)  # fmt: skip


@pytest.mark.parametrize(
    ("signal", "title"), [(signal, title) for signal, titles in TITLES.items() for title in titles]
)
def test_a_foreign_title_means_a_signal(signal, title):
    found = meant_by(Column(title))
    assert found is not None
    assert found.signal == signal
    assert title.rpartition(".")[2] in found.reason or found.exact


@pytest.mark.parametrize("title", STRANGERS)
def test_what_looks_alike_means_nothing(title):
    assert meant_by(Column(title)) is None


@pytest.mark.parametrize(("fastest", "units"), [(100.0, ["rad/s", "rpm", "deg/s"]), (3000.0, ["rpm", "deg/s"])])
def test_a_motor_may_turn_in_rpm(fastest, units):
    assert [each.name for each in candidates("motor_speed", "", np.array([-fastest, 0.0, fastest]))] == units


def test_titles_of_turns():
    assert counts_turns("Raddrehzahl_VL")
    assert counts_turns("n_HL")
    assert not counts_turns("Radgeschwindigkeit_VL")
