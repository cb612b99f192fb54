"""Coverage of a fleet's cars by verdicts: a car without a verdict is not a car without a fault."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from tierod.fleet.standing import JUDGED

if TYPE_CHECKING:
    import pyarrow as pa


class Coverage(NamedTuple):
    """Number of cars with a verdict, and gaps in the coverage.

    Args:
        vehicles: number of cars with findings
        judged: number of these with a verdict of at least one monitor
        confirmed: number of these of which a monitor said healthy, or consistent: an estimate alone confirms nothing
        remarks: monitors without a verdict on some of the cars that they examined, and why
    """

    vehicles: int
    judged: int
    confirmed: int
    remarks: tuple[str, ...]


def coverage(findings: pa.Table) -> Coverage:
    """Count cars with a verdict, and list monitors without one.

    Args:
        findings: findings as given by `tierod.fleet.results.findings_of`
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    verdict = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED]))
    good = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED if each.colour == "good"]))
    table = findings.select(["vehicle", "monitor", "status"]).append_column("verdict", verdict)
    table = table.append_column("good", good)
    cars = table.group_by("vehicle").aggregate([("verdict", "any"), ("good", "any")])
    pairs = table.group_by(["vehicle", "monitor"]).aggregate([("verdict", "any"), ("status", "max")]).to_pylist()
    looked = Counter(pair["monitor"] for pair in pairs)
    open_ = [(pair["monitor"], pair["status_max"]) for pair in pairs if not pair["verdict_any"]]
    remarks = tuple(
        f"{monitor}: no verdict on {count} of {looked[monitor]} cars ({_most(open_, monitor)})"
        for monitor, count in sorted(Counter(monitor for monitor, _ in open_).items())
    )
    judged, confirmed = (sum(cars[f"{name}_any"].to_pylist()) for name in ("verdict", "good"))
    return Coverage(cars.num_rows, judged, confirmed, remarks)


def _most(pairs: list[tuple[str, str]], monitor: str) -> str:
    statuses = Counter(status for name, status in pairs if name == monitor)
    return ", ".join(status for status, _ in statuses.most_common(3))
