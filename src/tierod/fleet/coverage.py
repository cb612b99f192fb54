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
        remarks: monitors without a verdict on some of the cars that they examined, and why
    """

    vehicles: int
    judged: int
    remarks: tuple[str, ...]


def coverage(findings: pa.Table) -> Coverage:
    """Count cars with a verdict, and list monitors without one.

    Args:
        findings: findings as given by `tierod.fleet.results.findings_of`
    """
    import pyarrow as pa
    import pyarrow.compute as pc

    verdict = pc.is_in(findings["status"], pa.array([str(each) for each in JUDGED]))
    table = findings.select(["vehicle", "monitor", "status"]).append_column("verdict", verdict)
    cars = table.group_by("vehicle").aggregate([("verdict", "any")])
    pairs = table.group_by(["vehicle", "monitor"]).aggregate([("verdict", "any"), ("status", "max")]).to_pylist()
    looked = Counter(pair["monitor"] for pair in pairs)
    open_ = [(pair["monitor"], pair["status_max"]) for pair in pairs if not pair["verdict_any"]]
    remarks = tuple(
        f"{monitor}: no verdict on {count} of {looked[monitor]} cars ({_most(open_, monitor)})"
        for monitor, count in sorted(Counter(monitor for monitor, _ in open_).items())
    )
    return Coverage(cars.num_rows, sum(cars["verdict_any"].to_pylist()), remarks)


def _most(pairs: list[tuple[str, str]], monitor: str) -> str:
    statuses = Counter(status for name, status in pairs if name == monitor)
    return ", ".join(status for status, _ in statuses.most_common(3))
