"""Charts of sensors and actuators: states over time, and a reading beside what replaced it."""

import numpy as np
import pytest

from tierod.core.findings import Diagnosis, Element, Episode, Estimate, Finding, Status, Trace
from tierod.report.charts.elements import state_figure, substitute_figures
from tierod.report.charts.over_time import result_figure
from tierod.report.diagnosis import render

TIME = np.arange(100) * 0.1


def trace(name, unit, values):
    values = np.broadcast_to(np.asarray(values, float), TIME.shape)
    return Trace(name, unit, TIME, values, values, values)


def diagnosis(**more):
    states = np.where((TIME > 3.0) & (TIME < 6.0), 1.0, 0.25)
    states[-10:] = np.nan
    traces = [
        trace("yaw_rate", "rad/s", 1.0),
        trace("state_of_yaw_rate", "", states),
        trace("state_of_drive_left", "", 0.0),
        trace("supplied_yaw_rate", "rad/s", 0.5),
        trace("deviation_of_supplied_yaw_rate", "rad/s", 0.1),
    ]
    size = Estimate("offset of yaw rate", 0.5, 0.01, "rad/s")
    elements = (
        Element(
            "yaw_rate", "sensor", Status.FAULT, "", (Episode("positive offset", 3.0, 6.0, size),), "filter", "C1A32-64"
        ),
        Element("drive_left", "actuator", Status.HEALTHY),
    )
    finding = Finding("condition, bank", Status.FAULT, "Yaw rate sensor: positive offset.")
    return Diagnosis((finding,), elements, {each.name: each for each in traces}, **more)


def test_every_element_has_a_row_of_its_states():
    figure = state_figure(diagnosis())
    heat = figure.data[0]
    assert heat["y"] == ["Yaw rate", "Drive left"]
    assert heat["z"][0][40] == 1.0
    assert heat["text"][0][40] == "fault"
    assert heat["text"][0][10] == "not testable"
    assert (heat["z"][0][-1], heat["text"][0][-1]) == (None, "not judged")
    assert heat["text"][1][0] == "healthy"
    assert [each["name"] for each in figure.data[1:]] == [
        "healthy",
        "not testable",
        "suspect",
        "fault",
    ]


@pytest.mark.parametrize(("value", "place"), [(0.0, 0), (0.25, 1), (0.5, 2), (1.0, 3)])
def test_every_state_has_the_colour_of_its_key(value, place):
    figure = state_figure(diagnosis())
    scale = figure.data[0]["colorscale"]
    found = [colour for edge, colour in scale if edge <= value][-1]
    nearest = next(colour for edge, colour in scale if edge >= value)
    assert figure.data[1 + place]["marker"]["color"] in (found, nearest)
    assert [edge for edge, _ in scale] == sorted(edge for edge, _ in scale)


def test_a_replaced_sensor_shows_reading_substitute_and_band_in_usual_units():
    (figure,) = substitute_figures(diagnosis())
    lines = {each["name"]: each for each in figure.data}
    assert lines["reading"]["y"][0] == pytest.approx(57.296, rel=1e-4)
    assert lines["supplied"]["y"][0] == pytest.approx(28.648, rel=1e-4)
    assert max(lines["95 % interval"]["y"]) == pytest.approx(np.degrees(0.5 + 0.196), rel=1e-4)
    assert figure.layout["annotations"][0]["text"] == "positive offset"
    assert (figure.layout["shapes"][0]["x0"], figure.layout["shapes"][0]["x1"]) == (3.0, 6.0)
    assert "°/s" in figure.layout["yaxis"]["title"]["text"]
    assert "filter" in figure.caption


def test_these_traces_are_not_drawn_a_second_time():
    assert result_figure(diagnosis()) is None


def test_a_monitor_without_elements_has_none_of_these_charts():
    other = Diagnosis((), (), {"friction": trace("friction", "N*m", 1.0)})
    assert state_figure(other) is None
    assert substitute_figures(other) == []


def test_the_page_shows_table_states_and_substitute():
    page = render(diagnosis())
    for text in ("Sensors and actuators over time", "Yaw rate: its reading, and what replaced it", "C1A32-64"):
        assert text in page
