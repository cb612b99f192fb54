"""Assignment of the title of a column to a signal, by words of English, German and some other languages."""

from __future__ import annotations

import contextlib
import re
import unicodedata
from typing import NamedTuple

from tierod.core.errors import InputError
from tierod.core.signals import SIGNALS
from tierod.core.units import COUNT, scale, split_name, tidy
from tierod.io.readers.mapping import meant
from tierod.io.readers.source import Column


class Meant(NamedTuple):
    """A signal, and why a title stands for it; `exact` where the title is a name of the catalogue."""

    signal: str
    reason: str
    exact: bool


class _Rule(NamedTuple):
    """Patterns that a title must all contain, and a pattern that it must not contain."""

    signal: str
    words: tuple[str, ...]
    without: str = ""
    about: str = ""  # pattern of the whole name, with message or group: a bare "motor" may be the engine


_STEER = r"steer|lenk|hand_?wheel|volant|sterzo|_swa_|_sw_|_lws_|_sas_|_lrw_|_str_"
_ANGLE = r"angle|winkel|_angl?_|_pos_|position|angolo|angulo|_lw_|_lrw_|stellung"
_RATE = r"rate|_rte_|geschw|velocity|_speed_|_spd_|_vel_|_dot_|punkt|vitesse|velocita|velocidad|_gier_?v_"
_TORQUE = r"torque|moment|_trq_|_tq_|couple|coppia|_m_"
_ASSIST = r"motor|^_mot_(trq|tq)_$|assist|_eps_|unterst|servo|hilfs|_emot_"
_OF_STEERING = r"assist|_eps|unterst|servo|hilfs|_emot_|steer|lenk|mdps|epas|_mot_(trq|tq)_$|^_motor_torque_$"
_OF_DRIVER = r"driver|_drvr?_(trq|tq)_$|fahrer|_hand|torsion|drehstab"
_WANTED = (
    r"_rq_|_req_|_trg_|_lim(it)?(mn|mx)?_|intended|request|target|soll|_cmd_|command|demand|desired|wunsch|_ref_|reference|"
    r"_set_?(point|_)|_des_|consigne|actuators"
)
_STATE = (
    r"_sta(t|te|tus)?_|_sts_|_qual|valid|_flag|_bit_|_vz_|_sign_|vorzeichen|_crc_|_counter_|_cnt_|toggle|_err(or)?_|"
    r"fehler|_(q|qf|ub|cs|fa|fp|msk|grp|dir|pul|fault|flt|group|mask|src)_|check_?sum|direction|richtung|pulse|impuls|"
    r"time_?stamp|bias|initiali|pressed|_pcnt_"
)
# Words of objects that a radar or a camera sees, and of other parts of the car than its steering and chassis
_OTHERS = r"_(rel|obj|trk|fus|tos|facctos|lead|ln|lane|trlr|trailer|hv|bat|chrg)_|_hv_?bat"
_SIGN = r"_vz_|_sign_|vorzeichen|_dir(ection)?_|richtung"
_SPEED = r"speed|geschw|velocity|_vel_|_spd_|vitesse|velocita|velocidad|drehzahl|_v_|_n_|_rpm_|omega|revs"
_WHEEL = r"wheel|(?<!len[k_])rad(?!ar|ius|_s_|_per)|_whl_|_wss_|_ws_|roue|ruota|rueda"
_ACCELERATION = r"accel|beschl|_acc_|_a_|accelerazione|aceleracion"
_LATERAL = r"_lat|lateral|quer|trasv|transv"
_LONGITUDINAL = r"_long|_lon_|laengs|_lngs|longitud"
_CAR = (
    r"vehicle|vehicule|ground|fahrzeug|_veh_|_fzg_|_car_|wagen|veicolo|vehiculo|_gps_|_gnss_|tacho|speedo|_ego_|_fahr"
)

_FRENCH = r"(roue|vitesse)\w*_"
_CORNERS = {
    "front_left": (
        rf"_(fl|lf|vl|lv|fr_l)_|{_FRENCH}avg_|front_?(left|links)|left_?front|vorne?_?(left|links)|links_?vorn"
    ),
    "front_right": (
        rf"_(fr(?!_l_)|rf|vr|rv)_|{_FRENCH}avd_|front_?(right|rechts)|right_?front|vorne?_?(right|rechts)|rechts_?vorn"
    ),
    "rear_left": rf"_(rl|lr|hl|lh|rr_l|re_l)_|{_FRENCH}arg_|rear_?left|left_?rear|hinten?_?links|links_?hint",
    "rear_right": rf"_(rr(?!_l_)|hr|rh|re_r)_|{_FRENCH}ard_|rear_?right|right_?rear|hinten?_?rechts|rechts_?hint",
}
_NO_WHEEL = r"press|druck|temp|torque|moment|brems|brake|slip|schlupf"

# Rules in order: the first one that fits decides, so that special rules precede general ones
_RULES: tuple[_Rule, ...] = (
    *(
        _Rule(f"wheel_speed_{corner}", (pattern, f"{_SPEED}|{_WHEEL}"), _NO_WHEEL)
        for corner, pattern in _CORNERS.items()
    ),
    _Rule("target_steering_wheel_angle", (_STEER, _ANGLE, _WANTED), _TORQUE),
    _Rule("steering_torque_request", (_STEER, _TORQUE, _WANTED), "motor"),
    _Rule("motor_target_torque", (_ASSIST, _TORQUE, _WANTED)),
    # The name of the sender has no meaning: EPS_TorsionBarTorque is the torque of the driver.
    _Rule("driver_torque", (_OF_DRIVER, _TORQUE), _ASSIST.replace("_eps_|", "")),
    _Rule("motor_torque", (_ASSIST, _TORQUE), "engine|verbrenn|drehmoment_?motor|fahrmotor|wheel_motor", _OF_STEERING),
    _Rule("driver_torque", (_STEER, _TORQUE), _ASSIST),
    _Rule("driver_torque", (r"^_tbt_$",)),
    _Rule("rack_force", (r"rack|zahnstange", r"force|kraft|_f_")),
    _Rule("rack_position", (r"rack|zahnstange", r"_pos|weg|travel|displacement")),
    _Rule("tie_rod_force", (r"tie_?rod|spurstange|track_?rod", r"force|kraft|_f_"), "left|right|links|rechts"),
    _Rule("steering_wheel_rate", (_STEER, _RATE), f"{_TORQUE}|yaw|gier|{_CAR}|motor"),
    _Rule("road_wheel_angle", (r"t[iy]re|reifen", _ANGLE), "left|right|links|rechts|slip|schr"),
    _Rule("steering_wheel_angle", (_STEER, _ANGLE), f"{_TORQUE}|{_RATE}|motor|rack|road|offset"),
    _Rule("yaw_acceleration", (r"yaw|gier", _ACCELERATION)),
    _Rule("yaw_rate", (r"yaw|gier|_psi_?(p|dot|punkt)_|lacet|imbardata|guinada", _RATE + r"|_psi_?(p|dot|punkt)_")),
    _Rule("yaw_rate", (r"_(w|omega|gyro?)_?z_|gierrate|_yaw_?(r|rt)_|^_yr_$|gyro_yaw|yaw_gyro|heading_(rate|dot)",)),
    _Rule("yaw_rate", (r"angular_(velocity|rate)_z_|rotation_rate_z_",)),
    _Rule("roll_rate", (r"_roll|wank", _RATE), "inertia"),
    _Rule("lateral_acceleration", (_LATERAL, f"{_ACCELERATION}|g_force"), "yaw|gier"),
    _Rule("longitudinal_acceleration", (_LONGITUDINAL, f"{_ACCELERATION}|g_force"), "yaw|gier"),
    _Rule("lateral_acceleration", (r"linear_accel\w*_y_",)),
    _Rule("longitudinal_acceleration", (r"linear_accel\w*_x_",)),
    _Rule("sideslip_angle", (r"schwimm|side_?slip|slip_?angle|_beta_|^_slip_$",), "wheel|rate|tyre|tire|reifen"),
    _Rule("lateral_speed", (_LATERAL, _SPEED), _WHEEL),
    _Rule("brake_pressure", (r"brems|brake|_brk_|frein|freno", r"druck|press|_p_"), f"{_CORNERS['front_left']}|_fr_"),
    _Rule("accelerator_pedal", (r"gas_?pedal|fahrpedal|accel\w*_?pedal|throttle_?pedal",)),
    _Rule("motor_speed", (_ASSIST, r"motor|rotor", _SPEED), "engine|verbrenn|fahrmotor", _OF_STEERING),
    _Rule("motor_temperature", (r"motor|winding|wicklung", r"temp"), "engine|oil|oel|kuehl|cool"),
    _Rule("ambient_temperature", (r"aussen|ambient|outside|umgebung", r"temp")),
    _Rule("supply_voltage", (r"bordnetz|batt|supply|_kl_?30_|_ubat_", r"volt|spannung|_u_|_ubat_")),
    _Rule("vehicle_speed", (rf"{_CAR}|forward|vorwaerts", _SPEED), f"{_WHEEL}|lateral|quer|_wind|engine|motor"),
    _Rule("vehicle_speed", (r"^_(geschwindigkeit|speed|velocity|vitesse|velocita|velocidad|v)_$|_v_sig(nal)?_$",)),
)

_GM_VALIDITY = re.compile(r"[a-z]V$")  # "YawRateV" is the validity of "YawRate" in databases of General Motors

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue"})


def words_of(title: str) -> str:
    """A title in lower case with an underscore between and around its words, without accents."""
    text = unicodedata.normalize("NFKD", title.translate(_UMLAUTS)).encode("ascii", "ignore").decode()
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]{2,})", "_", text)
    return f"_{re.sub(r'[^a-z0-9]+', '_', text.lower()).strip('_')}_"


def meant_by(column: Column) -> Meant | None:
    title, found = column.title or column.name, meant(column)
    if found is not None:
        return Meant(found.name, f"'{title}' is a known name", True)
    text = words_of(title)
    stated = column.unit or split_name(column.name)[1]
    if state_of(title) or re.search(_OTHERS, text) or (not stated and _GM_VALIDITY.search(title)):
        return None
    demand = re.search(_WANTED, text) is not None
    for rule in _RULES:
        if demand and not any(word in rule.signal for word in ("target", "request")):
            continue
        hits = [re.search(pattern, text) for pattern in rule.words]
        apart = rule.about and not re.search(rule.about, words_of(column.name))
        if all(hits) and not apart and not (rule.without and re.search(rule.without, text)):
            if not _is_of_kind(stated, rule.signal):
                continue
            words = dict.fromkeys(hit[0].strip("_") for hit in hits if hit)
            return Meant(rule.signal, f"'{title}' holds {' and '.join(map(repr, words))}", False)
    return None


def _is_of_kind(stated: str, signal: str) -> bool:
    """Whether a unit can be that of a signal; one that is not known can."""
    try:
        tidy(stated)
    except InputError:
        return True
    turns = ("rad/s",) if signal.startswith("wheel_speed_") else ()
    for wanted in (SIGNALS[signal].unit, *turns):
        with contextlib.suppress(InputError):
            if not stated or tidy(stated, wanted) == COUNT or scale(stated, wanted):
                return True
    return False


def demand_of(title: str) -> str:
    """Word by which a title stands for a demand, not for a measured value; "" without one."""
    found = re.search(_WANTED, words_of(title))
    return found[0].strip("_") if found else ""


def state_of(title: str) -> str:
    """Word by which a title stands for a state, a quality or a bit, not for a value; "" without one."""
    # "carState.yawRate" is a value in the group of the car's states.
    found = re.search(_STATE, words_of(title.rpartition(".")[2]))
    return found[0].strip("_") if found else ""


_TURNS = re.compile(r"drehzahl|_n_|_rpm_|omega|revs|u_min")


def sign_of(bit: str, title: str) -> int:
    """Number of words that the title of a sign bit shares with the title of a magnitude; 0 where it is no sign bit."""
    text = words_of(bit)
    if not re.search(_SIGN, text):
        return 0
    return len(set(re.sub(_SIGN, "_", text).split("_")) & set(words_of(title).split("_")) - {""})


def counts_turns(title: str) -> bool:
    """Whether the title of a wheel's speed indicates turns of the wheel, not metres of road."""
    return _TURNS.search(words_of(title)) is not None
