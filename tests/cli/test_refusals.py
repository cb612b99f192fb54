"""What was typed wrongly is refused in one sentence, and nothing is written."""

import shlex

import pytest

from live_drives import database_file
from tierod.cli import main

pytest.importorskip("can")
pytest.importorskip("cantools")

WISH = "design detector --false-alarms '1 per 100 h' --shift 1.2 --rate 100"
EPS = "--vehicle midsize-eps"
BUS = "--interface virtual --channel cli"
DBC = "--dbc car.dbc"
SCENARIO = 'name = "mine"\ndescription = "Mine."\ncourse = "iso-7401-step"\n[car]\nname = "midsize-eps-{}"\n'

REFUSED = (
    ("vehicles --toml", "--toml needs a vehicle"),
    ("vehicles rav4 --toml --json", "exclude each other"),
    ("vehicles rav5", "did you mean 'rav4'"),
    ("new car.toml", "--class with one of"),
    ("new car.toml --class midsise", "did you mean 'midsize'"),
    ("new car.toml --like midsize", "did you mean 'midsize-eps'"),
    ("new car.toml --class van mas=2000", "did you mean 'mass'"),
    ("new mass=2000 --class van", "ends in .toml"),
    ("new nowhere/car.toml --class van", "nowhere"),
    ("new car.toml --class van --map absent.toml", "absent.toml"),
    ("new mine.toml --class van", "--overwrite"),
    ("monitors fricton", "did you mean 'friction'"),
    ("study fricton", "did you mean 'friction'?"),
    ("faults --toml", "--toml needs a fault"),
    ("faults friction-step --toml --json", "exclude each other"),
    ("faults friction-step --behaviours", "leave 'friction-step' out"),
    ("faults friction-stp", "did you mean 'friction-step'"),
    ("faults absent.toml", "there is no fault file"),
    ("faults read", "needs the file"),
    ("faults read absent.json", "there is no fault memory absent.json"),
    ("faults clear absent.json", "nothing to clear"),
    ("scenarios --toml", "--toml needs the name of a scenario, car or course"),
    ("scenarios slalom --toml --json", "--toml and --json exclude each other"),
    ("scenarios --cars --courses", "--cars and --courses exclude each other"),
    ("scenarios rack-with-lahs", "or course is called 'rack-with-lahs'; did you mean 'rack-with-lash'"),
    ("scenarios --cars slalom", "no virtual car is called 'slalom'"),
    ("scenarios --courses slalm", "no course is called 'slalm'; did you mean 'slalom'"),
    ("scenarios absent.toml", "there is no scenario file absent.toml"),
    ("simulate mine.toml", "Missing option '--output'"),
    ("simulate mine.toml -o drive.mp4", "drive.mp4 has no ending that can be written; did you mean '.mf4'"),
    ("simulate mine.toml -o absent/drive.csv", "there is no folder absent; create it first"),
    ("simulate mine.toml -o drive.csv --seconds -1", "a run cannot last -1 s"),
    ("simulate mine.toml -o drive.csv --seconds 100", "'iso-7401-step' ends after"),
    ("simulate mine.toml -o drive.csv --seed -1", "Invalid value for '--seed'"),
    ("simulate step-stear -o drive.csv", "no scenario is called 'step-stear'; did you mean 'step-steer'"),
    ("simulate slip.toml -o drive.csv", "slip.toml, line 5: no virtual car is called 'midsize-eps-lite'; did you mean"),
    ("inspect absent.mf4", "check the path"),
    ("inspect drive.csv --write-map mine.toml", "--overwrite"),
    ("inspect drive.csv --write-map map.txt", "ends in .toml"),
    ("inspect drive.csv --write-map nowhere/map.toml", "nowhere"),
    ("inspect drive.csv --write-map map.toml --json", "exclude each other"),
    ("inspect drive.csv --write-map map.toml --map mine.toml", "exclude each other"),
    ("convert drive.csv -o drive.csv", "would overwrite"),
    ("convert drive.csv -o out.bag", "no ending that can be written"),
    ("convert drive.csv -o no/out.mat", "create it first"),
    ("convert nothing.mcap -o out.mat", "there is no file"),
    ("convert empty -o out.mat", "a folder without a recording"),
    (f"diagnose absent.parquet {EPS}", "there is no file absent.parquet"),
    ("diagnose drive.csv --vehicle midsize", "did you mean 'midsize-eps'"),
    ("diagnose drive.csv --no-report", "no vehicle is given, and the recording names none"),
    (f"diagnose drive.csv {EPS} --monitor hysteresis", "choose with --variant"),
    (f"diagnose drive.csv {EPS} --no-report -o x.html", "exclude each other"),
    (f"diagnose drive.csv {EPS} --monitor friction --memory m.json -o m.json", "would overwrite"),
    (f"live {BUS} {EPS}", "names no CAN database; give one with --dbc"),
    (f"live --interface socketcam --channel can0 {EPS} {DBC}", "no interface 'socketcam'; did you mean 'socketcan'"),
    (f"live --interface socketcan --channel can77 {EPS} {DBC}", "can77 cannot be opened"),
    (f"live {BUS} {EPS} {DBC} --period 0", "--period needs a positive time"),
    (f"live {BUS} {EPS} {DBC} --monitor frictoin", "did you mean 'friction'"),
    (f"live {BUS} {EPS} {DBC} --log no/x.mf4", "there is no folder"),
    (f"live {BUS} {EPS} {DBC} --log x.mf4 --memory x.mf4", "would overwrite"),
    (f"live {BUS} {EPS} {DBC} --log x.csv", "--log writes .mf4, not 'x.csv': name it x.mf4; tierod convert writes"),
    (f"live {BUS} {EPS} {DBC} --report x.pdf", "--report writes .html, not 'x.pdf': name it x.html"),
    (f"live {BUS} {EPS} {DBC} --interface-option fd", "expected NAME=VALUE"),
    (f"live {BUS} {EPS} {DBC} --ignition ESP.ignitin", "did you mean 'ESP.ignition'?"),
    (f"replay drive.csv {BUS} --loss 2", "--loss is a share between 0 and 1"),
    (f"replay drive.csv {BUS}", "has no signal of the databases"),
    (f"replay none.mf4 {BUS}", "there is no file"),
    ("fleet drive.csv -o r", "give either --vehicles with a fleet file, or --vehicle"),
    (f"fleet drive.csv {EPS}", "--output is missing"),
    ("fleet drive.csv --vehicle midsize-esp -o r", "midsize-eps"),
    (f"fleet absent {EPS} -o r", "no recording matches absent"),
    (f"fleet drive.csv {EPS} -o r --monitor frction", "did you mean 'friction'"),
    (f"fleet drive.csv {EPS} -o r --monitor hysteresis", "no default variant"),
    ("fleet drive.csv --vehicles absent.toml -o r", "absent.toml cannot be read"),
    ("fleet report", "takes one results folder"),
    ("fleet report empty", "holds no results"),
    ("isolability --without tie_rod_forze", "tie_rod_force"),
    ("isolability --vehicle midsize-eps", "midsize-eps"),
    ("isolability --vehicle smartlod", "smartload"),
    ("isolability --no-report -o x.html", "exclude each other"),
    ("identify colum drive.csv --vehicle column-bench", "did you mean 'column'"),
    ("identify motor drive.csv --vehicle rav4", "motor_resistance"),
    (WISH, "--sigma"),
    (f"{WISH} --sigma -1", "greater than zero"),
    (f"{WISH} --sigma 0.4 --rule cusm", "did you mean 'cusum'"),
    (f"{WISH} --sigma 0.4 --false-alarms never", "1 per 10000 h"),
    (f"{WISH} --sigma 0.4 --residual absent.parquet", "either --sigma"),
    (f"{WISH} --residual absent.parquet", "absent.parquet"),
    (f"{WISH} --sigma 0.4 --sides left", "sides is 'left'"),
    (f"{WISH} --sigma 0.4 --signal yaw_rate", "goes with --residual"),
    (f"{WISH} --sigma 0.4 --shift 1e-6 --false-alarms '1 per 1e5 h'", "look for a larger shift"),
    (f"{WISH} --sigma 0.4 --false-alarms '1 per 0.01 s'", "ask for more"),
    (f"export cc friction {EPS} -o ecu", "there is no export 'cc'"),
    (f"export c fricton {EPS} -o ecu", "did you mean 'friction'"),
    (f"export c hysteresis --variant hoist {EPS} -o ecu", "judges a recording as a whole"),
    (f"export fmu hysteresis {EPS} -o ecu", "ecu does not end in .fmu"),
    (f"export c motor-angle {EPS} -o ecu", "lacks motor_resistance"),
    (f"export c friction --precision half {EPS} -o ecu", "--precision is 'half'"),
    (f"export c friction --drive nowhere.mf4 {EPS} -o ecu", "nowhere.mf4"),
    ("export c friction -o ecu", "name it with --vehicle"),
    ("export c fault-memory --no-libm -o ecu", "--no-libm would have no effect on the fault memory"),
    (f"export c fault-memory {EPS} --precision double -o ecu", "--vehicle and --precision would have no effect"),
    (f"export c friction {EPS} --scenario weave-small-car -o ecu", "--scenario would have no effect on the C"),
    ("export c fault-memry -o ecu", "did you mean 'fault-memory'"),
    (f"export fmu friction {EPS} --precision double -o a.fmu", "--precision would have no effect on the unit"),
    (f"export fmu plant --scenario weave-small-car {EPS} -o a.fmu", "--vehicle would have no effect on the unit"),
    (f"export fmu friction {EPS} --evidence -o a.fmu", "--evidence would have no effect on the unit"),
    ("export fmu friction -o a.fmu", "name it with --vehicle"),
    ("export fmu plant -o a.fmu", "name it with --scenario"),
    ("export fmu assist --scenario steer-by-wire-lane-change -o a.fmu", "has no assist unit"),
    ("export fmu condition --vehicle smartload -o a.fmu", "is a bank of 53 filters, which cannot be exported"),
    (f"export fmu hysteresis {EPS} -o a.fmu", "judges a recording as a whole"),
)


@pytest.mark.parametrize(("typed", "sentence"), REFUSED, ids=lambda each: each[:40])
def test_what_is_typed_wrongly_is_refused_in_a_sentence_and_nothing_is_written(
    tmp_path, monkeypatch, capsys, typed, sentence
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.toml").write_text(SCENARIO.format("light"))
    (tmp_path / "slip.toml").write_text(SCENARIO.format("lite"))
    (tmp_path / "drive.csv").write_text("time [s],yaw_rate [rad/s]\n" + "".join(f"{k / 100},{k}\n" for k in range(50)))
    (tmp_path / "empty").mkdir()
    database_file(tmp_path)
    before = {path: path.is_file() and path.read_bytes() for path in tmp_path.iterdir()}
    assert main(shlex.split(typed)) == 3
    said = capsys.readouterr()
    assert sentence in said.err
    assert said.err.count("\n") == 1
    assert said.out == ""
    assert {path: path.is_file() and path.read_bytes() for path in tmp_path.iterdir()} == before
