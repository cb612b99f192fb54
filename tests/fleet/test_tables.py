"""Arrow in, Arrow out: the same findings as of a file, whatever engine calls it."""

import json
import subprocess
import sys

import pyarrow as pa
import pytest

from experiments.worker_tasks import environment
from fleet.drives import NOVEMBER, SIGNALS, driven, judged, written
from tierod.core.errors import InputError
from tierod.fleet import schema
from tierod.fleet.results import findings_of
from tierod.fleet.tables import judge_batches, judge_table

SAME = ("monitor", "variant", "status", "judged_s", "estimate", "deviation", "cause", "start", "tuning")


def samples(seed=1):
    recording = driven(seed)
    columns = {"time": recording[SIGNALS[0]].time}
    return pa.table(columns | {name: recording[name].values for name in SIGNALS})


def lists(*seeds):
    tables = [samples(seed) for seed in seeds]
    columns = {name: pa.array([each[name].to_pylist() for each in tables]) for name in tables[0].column_names}
    start = pa.array([int(NOVEMBER * 1e6)] * len(seeds)).cast(pa.timestamp("us", "UTC"))
    return pa.table(
        {"recording": [f"drive {seed}" for seed in seeds], "vehicle": ["car 7"] * len(seeds), "start": start} | columns
    )


def test_findings_are_those_of_the_file(tmp_path):
    judged(written(tmp_path / "a.parquet"), tmp_path / "results")
    (file,) = findings_of(tmp_path / "results").to_pylist()
    found = judge_table(lists(1), "midsize-eps", ["friction"])
    assert found.schema.equals(schema.findings())
    (row,) = found.to_pylist()
    assert {name: row[name] for name in SAME} == {name: file[name] for name in SAME}
    assert (row["vehicle"], row["recording_name"]) == ("car 7", "drive 1")


def test_samples_are_taken_as_one_recording_or_by_their_name():
    one = judge_table(samples(), "midsize-eps", ["friction"]).to_pylist()
    both = pa.concat_tables(
        [samples(seed).append_column("recording", pa.array([f"drive {seed}"] * len(samples(seed)))) for seed in (1, 2)]
    )
    two = judge_table(both, "midsize-eps", ["friction"]).to_pylist()
    assert len(one) == 1
    assert [row["recording_name"] for row in two] == ["drive 1", "drive 2"]
    assert (two[0]["key"], two[0]["cause"]) == (one[0]["key"], one[0]["cause"])
    assert judge_table(lists(1), "midsize-eps", ["friction"])["key"][0].as_py() == one[0]["key"]


def test_what_cannot_be_judged_is_a_row_with_its_reason():
    short = samples().slice(0, 500)
    (row,) = judge_table(short, "midsize-eps", ["friction"]).to_pylist()
    assert (row["status"], row["monitor"]) == ("not available", None)
    assert "less than 30 s are not judged" in row["cause"]
    (row,) = judge_table(samples().select(["time", "yaw_rate"]), "midsize-eps", ["friction"]).to_pylist()
    assert "needs steering_wheel_angle" in row["cause"]
    with pytest.raises(InputError, match="no column 'time', only yaw_rate"):
        judge_table(samples().select(["yaw_rate"]), "midsize-eps")


def test_batches_of_samples_are_refused_since_a_recording_may_be_cut():
    found = list(judge_batches(lists(1, 2).to_batches(max_chunksize=1), "midsize-eps", ["friction"]))
    assert [batch["recording_name"][0].as_py() for batch in found] == ["drive 1", "drive 2"]
    with pytest.raises(InputError, match="applyInArrow"):
        list(judge_batches(samples().to_batches(), "midsize-eps"))


SPARK = """
import json, sys
from functools import partial
from pyspark.sql import SparkSession
from pyspark.sql.pandas.types import from_arrow_schema
from fleet.test_tables import lists, samples
from tierod.fleet import schema
from tierod.fleet.tables import judge_batches, judge_table

def grouped(table):
    return judge_table(table, "midsize-eps", ["friction"])

if __name__ == "__main__":
    spark = SparkSession.builder.master("local[2]").config("spark.ui.enabled", "false").getOrCreate()
    kind = from_arrow_schema(schema.findings())
    frame = spark.createDataFrame(lists(1, 2)).repartition(2)
    judge = partial(judge_batches, parameters="midsize-eps", monitors=["friction"])
    found = frame.mapInArrow(judge, kind).select("recording_name", "status", "cause").collect()
    print(json.dumps(sorted([list(row) for row in found])))
"""


@pytest.mark.slow
def test_findings_under_spark_are_the_same(tmp_path):
    have = subprocess.run([sys.executable, "-c", "import pyspark"], env=environment(), capture_output=True, check=False)
    if have.returncode:
        pytest.skip("pyspark is not installed")
    (tmp_path / "job.py").write_text(SPARK)
    done = subprocess.run(
        [sys.executable, tmp_path / "job.py"], env=environment() | {"PYSPARK_PYTHON": sys.executable},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    here = judge_table(lists(1, 2), "midsize-eps", ["friction"])
    expected = sorted([row["recording_name"], row["status"], row["cause"]] for row in here.to_pylist())
    assert json.loads(done.stdout.splitlines()[-1]) == expected
