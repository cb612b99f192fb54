"""Proposed assignment of the variables of another tool's unit to signals, from names and units."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from tierod.core.errors import InputError
from tierod.core.screen import printable
from tierod.core.toml import Document, quoted
from tierod.core.units import scale, split_suffix
from tierod.io.proposal.words import meant_by, words_of
from tierod.io.readers.source import Column
from tierod.proving_ground.foreign import Unit, read_unit
from tierod.proving_ground.foreign.description import Variable
from tierod.proving_ground.foreign.offers import channels, offered, port_of

_AS_INPUT = {
    "steering_wheel_angle": "steering_wheel_angle",
    "target_steering_wheel_angle": "steering_wheel_angle",
    "steering_wheel_rate": "steering_wheel_rate",
    "driver_torque": "hand_torque",
    "motor_torque": "motor_torque",
    "motor_target_torque": "motor_torque",
    "column_assist_torque": "motor_torque",
}
"""Signal for an input whose name means one of these signals."""


class _Rule(NamedTuple):
    """Signal for an input whose name contains these words."""

    signal: str
    words: tuple[str, ...]


_FRICTION = r"_mu_|friction|adhesion|reibwert|kraftschluss"
_FORCE = r"force|kraft|_f_|_fx_"
_RULES = (
    _Rule("braking_force", (r"brak|brems|_brk_", _FORCE)),
    _Rule("traction_force", (r"traction|propuls|throttle", _FORCE)),
    _Rule("drive_force", (r"drive|driving|antrieb|longitud|_long_|_fx_|wheel", _FORCE)),
    _Rule("road.bank_angle", (r"bank|querneigung|superelev",)),
    _Rule("road.grade_angle", (r"grade|slope|steigung|laengsneigung|incline",)),
    _Rule("road.curvature", (r"curvature|kruemmung|_kappa_",)),
    _Rule("road.adhesion_right", (_FRICTION, r"right|rechts|_r_|_fr_|_rr_")),
    _Rule("road.adhesion_left", (_FRICTION,)),
    _Rule("wind.crosswind_speed", (r"cross_?wind|side_?wind|seitenwind|wind_?(y|lat)",)),
    _Rule("wind.headwind_speed", (r"head_?wind|gegenwind|wind_?(x|long)",)),
    _Rule("demand.speed", (r"target|soll|_ref_|desired|demand|set_?point|wunsch", r"speed|geschw|_v_|veloc")),
)
"""Rules in order; the first one that matches applies."""


@dataclass(frozen=True)
class Proposed:
    """A proposed entry.

    Args:
        variable: variable of the unit
        signal: signal of tierod
        unit: unit of the variable, from its description or the suffix of its name; "" for that of the signal
        reason: reason in words
        is_assumed: whether neither description nor name contain a unit
    """

    variable: str
    signal: str
    unit: str
    reason: str
    is_assumed: bool


@dataclass(frozen=True)
class PlantProposal:
    """Proposed assignment of a unit's variables to signals.

    Args:
        unit: unit that replaces a plant
        inputs, outputs: proposed entries
        free: inputs of the unit without a proposal
        start: the parameter that is the initial speed
    """

    unit: Unit
    inputs: tuple[Proposed, ...]
    outputs: tuple[Proposed, ...]
    free: tuple[Variable, ...]
    start: Proposed | None = None

    @property
    def content(self) -> dict[str, Any]:
        """The plant file as nested tables."""
        return {
            "fmu": str(self.unit.path.absolute()),
            **({"start_speed": _table("variable", self.start.variable, self.start)} if self.start else {}),
            "inputs": {each.variable: _table("signal", each.signal, each) for each in self.inputs},
            "outputs": {each.signal: _table("variable", each.variable, each) for each in self.outputs},
        }

    def text(self, fmu: str) -> str:
        """The plant file as text, with the reason of every entry as a comment.

        Args:
            fmu: path of the unit as written in the file
        """
        lines = [
            f"# Plant file proposed from {printable(self.unit.path.name)}: edit it, and keep what is right.",
            "# SI units and ISO 8855 hold behind it: forward and left are positive; sign = -1 turns a variable over.",
            f"fmu = {quoted(fmu)}",
            *([_line("start_speed", "variable", self.start.variable, self.start)] if self.start else []),
            "\n[inputs]  # variable of the unit = what it is given",
            *(_line(each.variable, "signal", each.signal, each) for each in self.inputs),
            *(f"# {quoted(each.name)} = {quoted('...')}  # {printable(each.meaning) or 'nothing found'}"
              for each in self.free),
            "\n[outputs]  # our signal = variable of the unit",
            *(_line(each.signal, "variable", each.variable, each) for each in self.outputs),
        ]  # fmt: skip
        return "\n".join(lines) + "\n"


def plant_document(path: str | Path) -> tuple[Document, list[str]]:
    """The plant file of a path, proposed if the path is a unit itself, and remarks on assumptions, in sentences.

    Args:
        path: path of a plant file (.toml), or of a unit (.fmu)

    Raises:
        ParameterError: an invalid file
        InputError: the unit cannot be used
    """
    if Path(path).suffix.lower() == ".toml":
        return Document.read(path, "plant"), []
    proposal = propose_plant(read_unit(path))
    doubtful = [each.variable for each in (*proposal.inputs, *proposal.outputs) if each.is_assumed]
    said = [
        f"{proposal.unit.path.name}: {len(proposal.inputs)} inputs and {len(proposal.outputs)} outputs are connected "
        f"by their names; 'tierod inspect {proposal.unit.path.name} --write-map {proposal.unit.path.stem}.plant.toml' "
        "writes this map, for editing"
    ]
    if doubtful:
        said.append(f"SI units are assumed for {', '.join(doubtful)}, since the unit states none")
    return Document(proposal.content, "", Path(path)), said


def propose_plant(unit: Unit) -> PlantProposal:
    """Propose an assignment of a unit's variables to signals, from names and units.

    Args:
        unit: description of the unit
    """
    inputs = [(each, _given(each)) for each in unit.of("input").values()]
    found: dict[str, Proposed] = {}
    # Names of the catalogue come first, so that no similar name takes their signal.
    for each, _ in sorted(_outputs(unit), key=lambda pair: not pair[1]):
        found.setdefault(each.signal, each)
    return PlantProposal(
        unit,
        tuple(proposed for _, proposed in inputs if proposed is not None),
        tuple(sorted(found.values(), key=lambda each: list(unit.variables).index(each.variable))),
        tuple(each for each, proposed in inputs if proposed is None),
        next(filter(None, map(_start, unit.of("parameter").values())), None),
    )


def _start(each: Variable) -> Proposed | None:
    """Entry of a parameter that is the initial speed, or None."""
    text = words_of(each.name)
    named = all(re.search(pattern, text) for pattern in (r"start|init|_0_|anfang", r"speed|geschw|veloc|_v_|_vx_"))
    if not each.is_number or not (named or re.search(r"_vx?_?0_", text)):
        return None
    return _fitting(each, "start.speed", "m/s", f"'{each.name}' holds its words")


def _outputs(unit: Unit) -> Iterator[tuple[Proposed, bool]]:
    """(entry, whether the name is one of the catalogue) of the outputs."""
    known = channels()
    for name, each in unit.of("output").items():
        last = name.rpartition(".")[2]
        if not each.is_number or not re.fullmatch(r"\w+", last):
            continue
        if last in known or last.startswith("truth_"):
            signal, reason, exact = last, "its name", True
        else:
            meant = meant_by(Column(name, each.unit, last, "." in name))
            if meant is None:
                continue
            signal, reason, exact = meant.signal, meant.reason, meant.exact
        found = _fitting(each, signal, known.get(signal), reason)
        if found is not None:
            yield found, exact


def _given(each: Variable) -> Proposed | None:
    """Proposal for an input; None if nothing matches."""
    known = offered()
    if not each.is_number:
        return None
    if port_of(each.name):
        return Proposed(each.name, each.name, "", "its name", False)
    if each.name in known:
        return _fitting(each, each.name, known[each.name], "its name")
    meant = meant_by(Column(each.name, each.unit))
    if meant is not None and meant.signal in _AS_INPUT:
        signal = _AS_INPUT[meant.signal]
        return _fitting(each, signal, known[signal], meant.reason)
    text = words_of(each.name)
    for rule in _RULES:
        if all(re.search(pattern, text) for pattern in rule.words):
            return _fitting(each, rule.signal, known[rule.signal], f"'{each.name}' holds its words")
    return None


def _fitting(each: Variable, signal: str, wanted: str | None, reason: str) -> Proposed | None:
    """The entry, or None if the unit of the variable does not match that of the signal."""
    stated = each.unit or split_suffix(each.name)[1]
    try:
        if stated and wanted is not None:
            scale(stated, wanted)
    except InputError:
        return None
    assumed = not stated and bool(wanted)
    return Proposed(each.name, signal, (wanted or "") if assumed else stated, reason, assumed)


def _table(key: str, name: str, each: Proposed) -> dict[str, str]:
    return {key: name, **({"unit": each.unit} if each.unit else {})}


def _line(key: str, short: str, name: str, each: Proposed) -> str:
    unit = f", unit = {quoted(each.unit)}" if each.unit else ""
    doubt = "; its unit is assumed: check" if each.is_assumed else ""
    name_of = key if key == "start_speed" else quoted(key)
    return f"{name_of} = {{ {short} = {quoted(name)}{unit} }}  # {printable(each.reason)}{doubt}"
