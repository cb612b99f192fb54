"""Coverage of a fleet's cars by verdicts: a car without a verdict is not a car without a fault."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from tierod.core.findings import Status
from tierod.fleet.standing import JUDGED, LAST, OFTEN

if TYPE_CHECKING:
    import pyarrow as pa


class Coverage(NamedTuple):
    """Number of cars with a verdict, and gaps in the coverage.

    Args:
        vehicles: number of cars with findings
        judged: number of these with a verdict of at least one monitor
        remarks: monitors without a verdict on some of the cars that they examined, and why; suspect drives
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
    doubted = findings.filter(pc.equal(findings["status"], str(Status.SUSPECT)))
    # A drive has one row per judged element, but counts once.
    single = doubted.group_by(["monitor", "vehicle", "recording_name", "span"]).aggregate([])
    drives = single.group_by("monitor").aggregate([("vehicle", "count"), ("vehicle", "count_distinct")]).to_pylist()
    return Coverage(cars.num_rows, sum(cars["verdict_any"].to_pylist()), (*remarks, *_suspect(drives)))


def _suspect(drives: list[dict[str, Any]]) -> Iterator[str]:
    """Remarks on suspect drives, which put no car on the list: often the recording is at fault, as the cause states."""
    for each in sorted(drives, key=lambda row: row["monitor"]):
        count, cars = each["vehicle_count"], each["vehicle_count_distinct"]
        yield (
            f"{each['monitor']}: suspect on {count} drive{'s' * (count > 1)} of {cars} car{'s' * (cars > 1)}; the "
            f"findings hold the cause; a car is listed only after a fault in {OFTEN} of its last {LAST} drives"
        )


def _most(pairs: list[tuple[str, str]], monitor: str) -> str:
    statuses = Counter(status for name, status in pairs if name == monitor)
    return ", ".join(status for status, _ in statuses.most_common(3))
