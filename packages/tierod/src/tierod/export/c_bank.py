"""C code of a bank: one function for all lanes, called in a loop, the judge, and the copying of lane states."""

from __future__ import annotations

from tierod.export.bank_interface import BankInterface
from tierod.export.c_header import HASH, declared, outer_structs, rows_of, state_rows, struct
from tierod.export.c_parameters import braced, parameter_rows
from tierod.export.c_source import assembled, constants, initial, prepare, step

_ADOPT = """\
static void PREFIX_adopt(PREFIX_state_t *x, const PREFIX_real_t a[COUNTU])
{
    uint16_t from[COUNTU];
    uint16_t needed[COUNTU];
    uint16_t left = 0U;

    for (uint16_t i = 0U; i < COUNTU; i++) {
        from[i] = i;
        needed[i] = 0U;
    }
    for (uint16_t i = 0U; i < COUNTU; i++) {
        if ((a[i] >= ZERO) && (a[i] < LIMIT)) {
            from[i] = (uint16_t)a[i];
        }
        if (from[i] != i) {
            needed[from[i]]++;
            left++;
        }
    }
    /* A lane whose state no other one still takes over is overwritten first. */
    for (uint16_t n = 0U; (n < COUNTU) && (left > 0U); n++) {
        for (uint16_t i = 0U; i < COUNTU; i++) {
            if ((from[i] != i) && (needed[i] == 0U)) {
                x->lanes[i] = x->lanes[from[i]];
                needed[from[i]]--;
                from[i] = i;
                left--;
            }
        }
    }
    /* What is left are lanes that exchange their states in a circle. */
    for (uint16_t i = 0U; (i < COUNTU) && (left > 0U); i++) {
        if (from[i] != i) {
            uint16_t to = i;

            x->kept = x->lanes[i];
            for (uint16_t n = 0U; (n < COUNTU) && (from[to] != i); n++) {
                const uint16_t next = from[to];

                x->lanes[to] = x->lanes[next];
                from[to] = to;
                to = next;
                left--;
            }
            x->lanes[to] = x->kept;
            from[to] = to;
            left--;
        }
    }
}
"""


def bank_structs(face: BankInterface) -> str:
    lane, prefix, count = face.lane, face.prefix, face.bank.count
    tuned, real = face.subject.tuning, face.spelling.real
    alike, own = lane.slots
    shared = rows_of(face, lane.shared_members, lane.known(lane.shared))
    parameters = [
        HASH, *shared, f"    /* what lanes differ in */\n    {prefix}_lane_parameters_t lane[{count}];\n",
        *rows_of(face, face.parameters, tuned[face.tuned :]),
    ]  # fmt: skip
    values = [f"    {real} value[{max(len(alike) + len(face.program.carried()), 1)}];\n"]
    values.append(f"    {prefix}_lane_constants_t lane[{count}];\n")
    feedback = rows_of(face, lane.feedback, face.known_feedback)
    state = [
        f"    {prefix}_lane_state_t lanes[{count}];\n",
        f"    /* what the lanes state at this step */\n    {prefix}_lane_output_t said[{count}];\n",
        f"    /* of a lane, while lanes exchange their states */\n    {prefix}_lane_state_t kept;\n",
        *([f"    {prefix}_feedback_t feedback;\n"] if feedback else []), *state_rows(face),
    ]  # fmt: skip
    fed = struct(face, "feedback", "What every lane is given with the next sample.", feedback) if feedback else ""
    own_values = [f"    {real} value[{max(len(own), 1)}];\n"]
    rows = (
        ("lane_parameters", "Of one lane.", rows_of(face, lane.own_members, lane.known(lane.own))),
        ("parameters", "Of the vehicle and of the monitor; those with lanes_ are shared by all lanes.", parameters),
        ("lane_constants", "What depends on the parameters of one lane.", own_values),
        ("constants", "What depends on the parameters alone; shared by all instances.", values),
        ("lane_state", "Memory of one lane.", state_rows(lane, lane.known_state)),
        ("lane_output", "What one lane states.", rows_of(face, lane.output, lane.known_output)),
        ("state", "Memory of one instance; it belongs to the caller.", state),
    )
    return outer_structs(face) + fed + "".join(struct(face, *each) for each in rows)


def bank_parameter_rows(face: BankInterface) -> str:
    """C code of the parameter values of a bank."""
    lane, subject = face.lane, face.subject
    width, tuned = len(face.bank.lane.tuning), face.tuned
    values = [subject.values[k] for k in lane.shared]
    shared = parameter_rows(face, lane.shared_members, lane.known(lane.shared), values)
    rows = []
    for number in range(face.bank.count):
        own = [subject.values[number * width + k] for k in lane.own]
        members = ", ".join(f".{each.name} = {braced(face, each, own)}" for each in lane.own_members) or "0U"
        rows.append(f"        {{{members}}},\n")
    judge = parameter_rows(face, face.parameters, subject.tuning[tuned:], subject.values[tuned:])
    return f"{shared}    .lane = {{\n{''.join(rows)}    }},\n{judge}"


def bank_source(face: BankInterface) -> str:
    """C code of a bank's source file."""
    parts = (_prepare(face), _init(face), _steps(face), _whole(face))
    return assembled(face, "\n".join(parts))


def _arguments(face: BankInterface, letters: str, writes: str = "") -> dict[str, str]:
    kinds = {
        "p": "parameters", "q": "lane_parameters", "c": "constants", "k": "lane_constants", "x": "lane_state",
        "u": "sample", "o": "lane_output", "f": "feedback",
    }  # fmt: skip
    return {
        each: f"{'' if each in writes else 'const '}{face.prefix}_{kinds[each]}_t *{each}"
        for each in letters
        if each != "f" or face.lane.feedback
    }


def _prepare(face: BankInterface) -> str:
    """Functions that compute the values depending on parameters only: shared by all lanes, per lane, of the judge."""
    lane, prefix = face.lane, face.prefix
    alike, own = lane.slots
    lanes = constants(lane, alike, "prepare_lanes", _arguments(face, "pc", "c"), True)
    each = constants(lane, own, "prepare_lane", _arguments(face, "pqk", "k"), True)
    judge = prepare(face, "prepare_judge", static=True)
    given = f"{declared(face, 'p')}, {declared(face, 'c', writes=True)}"
    return (
        f"{lanes}\n{each}\n{judge}\nvoid {prefix}_prepare({given})\n{{\n"
        f"    {prefix}_prepare_lanes(p, c);\n    for (uint16_t i = 0U; i < {face.bank.count}U; i++) {{\n"
        f"        {prefix}_prepare_lane(p, &p->lane[i], &c->lane[i]);\n    }}\n    {prefix}_prepare_judge(p, c);\n}}\n"
    )


def _init(face: BankInterface) -> str:
    prefix = face.prefix
    lane = initial(face.lane, "init_lane", _arguments(face, "pqx", "x"), "", True)
    judge = initial(face, "init_judge", {"p": declared(face, "p"), "x": declared(face, "x")}, "", True)
    fed = "".join(
        f"    x->feedback.{each.name} = {face.spelling.number(value)};\n"
        for each, value in zip(face.lane.feedback, face.fed_first, strict=True)
    )
    return (
        f"{lane}\n{judge}\nvoid {prefix}_init({declared(face, 'p')}, {declared(face, 'x')})\n{{\n"
        f"    *x = ({prefix}_state_t){{0}};\n    for (uint16_t i = 0U; i < {face.bank.count}U; i++) {{\n"
        f"        {prefix}_init_lane(p, &p->lane[i], &x->lanes[i]);\n    }}\n    {prefix}_init_judge(p, x);\n{fed}}}\n"
    )


def _steps(face: BankInterface) -> str:
    lane = step(face.lane, "lane", _arguments(face, "ckxuof", "xo"))
    judged = {word: declared(face, word) for word in "cxuy"} | {"a": f"{face.spelling.real} a[{face.bank.count}U]"}
    judge = step(face, "judge", judged, face.gathered)
    adopt = _ADOPT.replace("PREFIX", face.prefix).replace("COUNT", str(face.bank.count))
    limit = face.spelling.number(float(face.bank.count))
    return f"{lane}\n{judge}\n{adopt.replace('ZERO', face.spelling.number(0.0)).replace('LIMIT', limit)}"


def _whole(face: BankInterface) -> str:
    prefix, count = face.prefix, face.bank.count
    given = ", ".join(declared(face, word) for word in "cxuy")
    fed = ", &x->feedback" if face.lane.feedback else ""
    return (
        f"void {prefix}_step({given})\n{{\n    {face.spelling.real} a[{count}U];\n\n"
        f"    for (uint16_t i = 0U; i < {count}U; i++) {{\n"
        f"        {prefix}_lane(c, &c->lane[i], &x->lanes[i], u, &x->said[i]{fed});\n    }}\n"
        f"    {prefix}_judge(c, x, u, y, a);\n    {prefix}_adopt(x, a);\n}}\n"
    )
