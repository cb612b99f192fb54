"""Report of a campaign, made from its document: pass criteria first, then matrix, delays, states, and failures."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from tierod.core.content import (
    Boxes,
    Chart,
    Facts,
    Flag,
    Fold,
    Heading,
    Item,
    Lines,
    Link,
    Panel,
    Points,
    Table,
    Verdict,
)
from tierod.core.shown import shown
from tierod.core.statuses import SEVERITY, Status
from tierod.report.display import bracketed, duration, number, share
from tierod.report.html import Origin, page

NEVER = "never"
RIGHT = {"quiet", "found"}  # Correct outcomes
FAULT_FREE = "fault-free"  # State of a drive without a fault
MOST_CELLS = 3000  # Largest number of drives listed on the page; the table file contains all
MOST_LOST = 10  # Largest number of failed drives that the terminal lists
_GATES = {True: Flag("met", "✓", "good"), False: Flag("missed", "✕", "bad"), None: Flag("not judged", "?", "open")}
_STATUSES = {
    "met": ("✓", "good", "All pass criteria are met", ""),
    "missed": ("✕", "bad", "A pass criterion is missed",
               "See below which group of drives misses the criterion, and open the report of one of its drives."),
    "not judged": ("?", "open", "Not everything could be judged",
                   "See below which drives failed and why; the same command again simulates the missing drives."),
    "no gates": ("–", "open", "No pass criteria were set", ""),
}  # fmt: skip
_SYMBOLS = {"bad": "✕", "open": "?", "good": "✓"}
_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*)")
_QUANTILES = {"median": "median", "p95": "95 %", "worst": "worst"}


def value(given: float | str | None) -> float:
    """A number of the document: null means NaN, "inf" infinity."""
    return math.nan if given is None else float(given)


def seconds(given: float | str | None) -> str:
    """A time as text; "never" where it is infinite."""
    time = value(given)
    return NEVER if math.isinf(time) else duration(time)


def count(number_: int, one: str, many: str | None = None) -> str:
    """A number with its noun: "1 drive", "3 drives"."""
    return f"{number_} {one if number_ == 1 else many or one + 's'}"


def place(where: Mapping[str, object]) -> str:
    """A cell of the matrix as text: "car midsize, fault step 4"."""
    if not where:
        return "all drives"
    parts, fault = [], ""
    for axis, level in where.items():
        if axis in ("fault", "size"):
            fault = f"{fault} {_levels(level)}".strip()
        elif level != "":
            parts.append(f"{axis} {_levels(level)}")
    return ", ".join([*parts, *([fault] if fault else [])])


def _levels(levels: object) -> str:
    several = levels if isinstance(levels, list) else [levels]
    return " or ".join(f"{level:g}" if isinstance(level, float) else str(level) for level in several)


def amount(given: float, unit: str) -> str:
    """A value with its unit, as text."""
    factor, label = shown(unit)
    return f"{number(given * factor, 3)} {label}".strip()


def render_campaign(content: Mapping[str, Any]) -> str:
    """HTML page of a campaign."""
    origin = Origin(content["created"], content["version"], content["command"])
    note = (
        "Everything was measured on virtual cars. Every drive has a record in the folder drives beside this page: "
        "scenario, seeds, version, machine and compiler."
    )
    came: list[Item] = [Heading("Provenance", (note,)), Fold("The campaign file", (), (f"{content['text']}\n",))]
    name = f"campaign {content['name']}"
    return page(_items(content), origin, f"{content['status']}: {name}", name, came=came)


def _items(content: Mapping[str, Any]) -> Iterator[Item]:
    symbol, colour, headline, action = _STATUSES[content["status"]]
    yield Verdict(
        headline,
        Flag(content["status"], symbol, colour),
        (("campaign", f"campaign {content['name']}"),),
        (content["description"],),
        reasons=(("What to do", action),) if action else (),
    )
    if content["gates"]:
        yield _gates(content)
    yield Facts(_facts(content))
    for index, monitor in enumerate(content["monitors"]):
        yield from _of_monitor(index, content, monitor)
    if failures := _failures(content["cells"]):
        yield Heading("What diverged, failed or could not be judged")
        yield Table("", ("what", "how many", "why", "last good time", "where"), tuple(failures))
    yield Heading("Every drive", ("The file cells.parquet has every figure and what is needed to repeat a drive.",))
    yield _cells(content)


def shown_items(content: Mapping[str, Any]) -> Iterator[Item]:
    """What a terminal shows: figures by group, failures, pass criteria."""
    for monitor in content["monitors"]:
        pools = [each for each in content["pools"] if each["monitor"] == monitor["label"]]
        kept = (0, 1, 3, 4, 5, 6, 7, 8, 9)
        whole = _columns("")
        rows = (_pool(pool) for pool in pools)
        yield Table(monitor["label"], tuple(whole[k] for k in kept), tuple(tuple(row[k] for k in kept) for row in rows))
    lost = [cell for cell in content["cells"] if cell["reason"] or any(each["reason"] for each in cell["verdicts"])]
    if lost:
        reasons = (cell["reason"] or next(v["reason"] for v in cell["verdicts"] if v["reason"]) for cell in lost)
        rows_ = [(cell["outcome"], place(cell["place"]), why) for cell, why in zip(lost, reasons, strict=True)]
        title = f"{count(len(lost), 'drive')} of {len(content['cells'])} failed"
        more = f"{len(lost) - MOST_LOST} more are in the report." if len(lost) > MOST_LOST else ""
        yield Table(title, ("outcome", "drive", "why"), tuple(rows_[:MOST_LOST]), more)
    if content["gates"]:
        yield _gates(content)


def _gates(content: Mapping[str, Any]) -> Table:
    rows = []
    for gate in content["gates"]:
        goal, measured = gate["goal"].replace("<=", "≤").replace(">=", "≥"), gate["measured"]
        shown_ = seconds(measured) if gate["figure"].endswith("_s") else number(value(measured))
        over = (gate["figure"], place(gate["where"]), gate["monitor"])
        rows.append((*over, goal, shown_, _GATES[gate["met"]], gate["note"]))
    return Table("Pass criteria", ("gate", "over", "monitor", "goal", "measured", "met", "rests on"), tuple(rows))


def _facts(content: Mapping[str, Any]) -> list[tuple[str, str]]:
    outcomes = [cell["outcome"] for cell in content["cells"]]
    facts = [("Drives", str(len(outcomes))), ("Driving", f"{number(value(content['hours']), 3)} h")]
    for axis, levels in content["axes"].items():
        many = f"{len(levels)}, from {levels[0]} to {levels[-1]}" if len(levels) > 8 else ""
        facts += [(axis.capitalize(), many or ", ".join(filter(None, levels)))] if axis != "size" else []
    for outcome, title in (("diverged", "Diverged"), ("failed", "Failed"), ("open", "Not driven yet")):
        facts += [(title, str(outcomes.count(outcome)))] if outcome in outcomes else []
    return facts


def _of_monitor(index: int, content: Mapping[str, Any], monitor: Mapping[str, Any]) -> Iterator[Item]:
    label = monitor["label"]
    pools = [each for each in content["pools"] if each["monitor"] == label]
    states = next(each for each in content["states"] if each["monitor"] == label)
    unit = shown(states["unit"])[1]
    yield Heading(label, (f"Assumes the vehicle {monitor['vehicle']}; baseline: {monitor['baseline']}.",))
    yield Facts(_figures(pools[0]["figures"], unit))
    yield grid(content["cells"], label)
    if chart := detection_chart(index, label, pools, content["gates"]):
        yield chart
    if chart := box_chart(index, states):
        yield chart
    yield Heading("State given, verdict found", look="together")
    yield _confusion(states["confusion"])
    note = (
        "Lost: drives that diverged, failed or were not judged. False alarms: how many, in how many judged hours "
        "without fault, and the 95 % upper bound per hour. Times from the fault to the first alarm; a fault that was "
        "never found counts as never."
    )
    yield Heading("Figures of every group", (note,))
    yield Table("", _columns(unit), tuple(map(_pool, pools)))


def _figures(figures: Mapping[str, Any], unit: str) -> list[tuple[str, str]]:
    def times(name: str) -> str:
        return ", ".join(f"{word} {seconds(figures[f'{name}_{key}_s'])}" for key, word in _QUANTILES.items())

    hours, area = number(value(figures["fault_free_judged_hours"]), 3), number(value(figures["area"]))
    return [
        ("Faults found", _found(figures)),
        ("Time to the alarm", times("detection")),
        ("The same in enabled time", times("detection_enabled")),
        ("False alarms", f"{figures['false_alarms']} in {hours} judged hours without fault; with 95 % confidence below "
         f"{number(value(figures['false_alarm_bound']), 3)} per hour"),
        ("Estimate less truth", f"{_spread(figures)} {unit}".strip()),
        ("Area under the ROC curve", f"{area} between drives, at least "
         f"{number(value(figures['smallest_area']))} within one"),
        ("Judged", f"{share(value(figures['judged_share']))} of the time, enabled "
         f"{share(value(figures['enabled_share']))}"),
        ("Drives without a judgement", str(figures["not_judged"] + figures["failed"] + figures["diverged"])),
    ]  # fmt: skip


def grid(cells: Sequence[Mapping[str, Any]], monitor: str) -> Table:
    """Matrix of one monitor's verdicts: right ones of all seeds, and what the others were."""
    axes = [axis for axis in (cells[0]["place"] if cells else ()) if axis not in ("fault", "size", "seed")]
    # Axes with a single level would repeat it in every row.
    axes = [axis for axis in axes if len({cell["place"][axis] for cell in cells}) > 1]
    rows: dict[tuple[str, ...], dict[str, list[str]]] = {}
    columns: dict[str, None] = {}
    for cell in cells:
        column = " ".join(filter(None, (cell["place"]["fault"], cell["place"]["size"])))
        columns[column] = None
        verdict = next((each for each in cell["verdicts"] if each["monitor"] == monitor), None)
        lost = cell["outcome"] if cell["outcome"] != "driven" else "not judged"
        outcome = verdict["outcome"] if verdict and verdict["status"] is not None else f"lost: {lost}"
        levels = tuple(cell["place"][axis] for axis in axes)
        rows.setdefault(levels, {}).setdefault(column, []).append(outcome)
    table = tuple(
        (*(levels or ("all",)), *(_square(found.get(c, [])) for c in columns)) for levels, found in rows.items()
    )
    note = "Drives with the right result (no alarm without a fault, one after a fault) of all seeds at each place."
    return Table("The matrix", (*(axes or ("",)), *columns), table, note)


def _square(outcomes: Sequence[str]) -> str:
    if not outcomes:
        return ""
    wrong = [each.removeprefix("lost: ") for each in outcomes if each not in RIGHT]
    open_ = all(each in RIGHT or each.startswith("lost: ") or each == "not judged" for each in outcomes)
    colour = "good" if not wrong else "open" if open_ else "bad"
    text = f"{len(outcomes) - len(wrong)}/{len(outcomes)}"
    others = ", ".join(count(wrong.count(what), what, what) for what in dict.fromkeys(wrong))
    return Flag(f"{text}{f': {others}' if others else ''}", _SYMBOLS[colour], colour)


def _confusion(confusion: Mapping[str, Mapping[str, int]]) -> Table:
    seen = {status for counts in confusion.values() for status in counts}
    statuses = [status for status in (*map(str, SEVERITY), "no verdict") if status in seen]
    rows = []
    for state, counts in confusion.items():
        cells = [_counted(counts[status], _right(state, status)) if status in counts else "" for status in statuses]
        rows.append((state, *cells, str(sum(counts.values()))))
    return Table("", ("given", *statuses, "drives"), tuple(rows))


def _counted(number_: int, colour: str) -> Flag:
    return Flag(str(number_), _SYMBOLS[colour], colour)


def _right(state: str, status: str) -> str:
    if status not in SEVERITY or not Status(status).judged:
        return "open"
    return "good" if Status(status).alarm == (state != FAULT_FREE) else "bad"


def _columns(unit: str) -> tuple[str, ...]:
    alarms = ("false alarms", "at most")
    error = bracketed("bias ± deviation", unit)
    return ("group", "drives", "lost", "found", *_QUANTILES.values(), *alarms, error, "ROC area", "judged")


def _pool(pool: Mapping[str, Any]) -> tuple[str, ...]:
    figures = pool["figures"]
    hours = value(figures["fault_free_judged_hours"])
    bound = f"{number(value(figures['false_alarm_bound']), 3)}/h"
    return (
        place(pool["where"]),
        str(figures["drives"]),
        str(figures["failed"] + figures["diverged"] + figures["not_judged"]),
        _found(figures),
        *(seconds(figures[f"detection_{name}_s"]) for name in _QUANTILES),
        *((f"{figures['false_alarms']} in {number(hours, 3)} h", bound) if hours > 0.0 else ("–", "–")),
        _spread(figures),
        number(value(figures["area"])),
        share(value(figures["judged_share"])),
    )


def _spread(figures: Mapping[str, Any]) -> str:
    bias, deviation = value(figures["bias"]), value(figures["deviation"])
    return "–" if math.isnan(bias) else f"{'+' if bias >= 0.0 else ''}{number(bias, 3)} ± {number(deviation, 3)}"


def _found(figures: Mapping[str, Any]) -> str:
    could = figures["faulty"] - figures["early"]
    return f"{figures['found']} of {could}" if could else "–"


def detection_chart(
    index: int, monitor: str, pools: Sequence[Mapping[str, Any]], gates: Sequence[Mapping[str, Any]] = ()
) -> Chart | None:
    """Detection delay over fault size, one panel per fault; None where there are no faults."""
    panels, rows = [], []
    for fault, sizes in _faults(pools).items():
        along, unit = _places([size for size, _ in sizes])
        marks: list[Lines | Points] = []
        for key, name in _QUANTILES.items():
            times = [value(figures[f"detection_{key}_s"]) for _, figures in sizes]
            known = [math.nan if math.isinf(time) else time for time in times]
            marks += [Lines(name, along, known)] if not isinstance(along[0], str) else []
            marks.append(Points(name, along, known))
        lost = sum(figures["faulty"] - figures["early"] - figures["found"] for _, figures in sizes)
        title = f"{fault}: {lost} {NEVER} found" if lost else fault
        goals = tuple(_goals(gates, monitor, fault))
        panels.append(Panel(title, bracketed("size", unit), "time [s]", tuple(marks), goals))
        for size, figures in sizes:
            times_ = (seconds(figures[f"detection_{name}_s"]) for name in _QUANTILES)
            rows.append((f"{fault} {size}".strip() + f" ({_found(figures)} found)", *times_))
    if not panels:
        return None
    return Chart(
        f"detection-{index}",
        "How soon faults are found",
        "Time from the beginning of a fault to the first alarm; with half of the faults never found there is no "
        "median, with more than 5 % no 95 % value. Dashed: goal of a pass criterion.",
        f"Detection times of {monitor} over the size of each fault; all figures in the table beneath.",
        tuple(panels),
        ("fault", "median", "95 %", "worst"),
        tuple(rows),
    )


def _goals(gates: Sequence[Mapping[str, Any]], monitor: str, fault: str) -> Iterator[tuple[str, float]]:
    for gate in gates:
        part, of = _NUMBER.fullmatch(gate["goal"].lstrip("<>= ")), gate["where"].get("fault", fault)
        on = fault in of if isinstance(of, list) else fault == of
        name = re.fullmatch(r"detection_(median|p95|worst)_s", gate["figure"])
        if part and name and on and gate["monitor"] in ("", monitor):
            yield f"goal of the {_QUANTILES[name[1]]} time", float(part[1])


def _faults(pools: Sequence[Mapping[str, Any]]) -> dict[str, list[tuple[str, Mapping[str, Any]]]]:
    """Sizes of every fault with their figures; a fault without sizes has the single size ""."""
    found: dict[str, list[tuple[str, Mapping[str, Any]]]] = {}
    for pool in pools:
        where, figures = pool["where"], pool["figures"]
        sized = set(where) == {"fault", "size"} and where["fault"] in found
        if sized or (set(where) == {"fault"} and figures["faulty"]):
            found.setdefault(where["fault"], []).append((where.get("size", ""), figures))
    return {fault: [each for each in sizes if each[0]] or sizes for fault, sizes in found.items()}


def _places(sizes: Sequence[str]) -> tuple[list[Any], str]:
    parts = [_NUMBER.fullmatch(size) for size in sizes]
    units = {part[2].strip() for part in parts if part}
    if all(parts) and len(units - {""}) <= 1:
        return [float(part[1]) for part in parts if part], next(iter(units - {""}), "").replace("*", "·")
    return [size or "as it is" for size in sizes], ""


def box_chart(index: int, states: Mapping[str, Any]) -> Chart | None:
    """Distribution of the estimates in every state, with the true value; None without estimates."""
    boxes = states["boxes"]
    if not boxes:
        return None
    factor, label = shown(states["unit"])
    names = [box["state"] for box in boxes]
    columns = [[factor * value(box[key]) for box in boxes] for key in ("low", "lower", "median", "upper", "high")]
    truth = Points("truth", names, [factor * value(box["truth"]) for box in boxes])
    rows = []
    for box in boxes:
        names_ = ("truth", "median", "bias", "deviation")
        real, median, bias, deviation = (number(factor * value(box[key]), 3) for key in names_)
        cells = (f"{each} {label}".strip() for each in (real, median, f"{bias} ± {deviation}"))
        rows.append((box["state"], *cells))
    panel = Panel("", "", bracketed("estimate", label), (Boxes("estimates", names, *columns), truth))
    return Chart(
        f"estimates-{index}",
        "What was estimated in each state",
        "Settled estimates of all drives: middle half as the box, 5 to 95 % as whiskers. "
        "The column `fault_free` includes the drives with a fault, until it comes.",
        "Boxes of the estimates by state; truth, median and errors in the table beneath.",
        (panel,),
        ("state", "truth", "median", "bias ± deviation"),
        tuple(rows),
    )


def _failures(cells: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    alike: dict[tuple[str, str, str], list[str]] = {}
    for cell in cells:
        if cell["outcome"] != "driven":
            last = "" if cell["last_good_s"] is None else seconds(cell["last_good_s"])
            alike.setdefault((cell["outcome"], cell["reason"], last), []).append(place(cell["place"]))
            continue
        for verdict in cell["verdicts"]:
            if verdict["reason"]:
                key = (f"{verdict['monitor']} gave no verdict", verdict["reason"], "")
                alike.setdefault(key, []).append(place(cell["place"]))
    return [
        (outcome, count(len(places), "drive"), reason, last,
         "; ".join(places[:6]) + (f"; and {len(places) - 6} more" if len(places) > 6 else ""))
        for (outcome, reason, last), places in alike.items()
    ]  # fmt: skip


def _cells(content: Mapping[str, Any]) -> Fold:
    rows = []
    for cell in content["cells"][:MOST_CELLS]:
        row = [place(cell["place"])]
        for each in cell["verdicts"]:
            status = Status(each["status"] or Status.NOT_AVAILABLE)
            wrong = "" if each.get("outcome") in RIGHT else f": {each.get('headline') or each['reason']}"
            row.append(Flag(each["status"] or "no verdict", status.symbol, status.colour))
            row.append(f"{each.get('outcome', '')}{wrong}")
            row.append(seconds(each["detection_s"]) if each.get("outcome") == "found" else "")
        rows.append((*row, Link("open", cell["recording"]) if cell["recording"] else cell["outcome"]))
    header = [name for each in content["monitors"] for name in (each["label"], "outcome", "alarm after")]
    more = len(content["cells"]) - MOST_CELLS
    table = Table(
        "", ("drive", *header, "recording"), tuple(rows), f"{more} more stand in cells.parquet." if more > 0 else ""
    )
    return Fold(f"{len(rows)} drives with their verdicts and recordings", [table], printed=False)
