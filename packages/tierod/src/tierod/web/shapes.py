"""Types of the requests and responses of the endpoints, from which the OpenAPI description is made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from tierod.core.shown import shown
from tierod.core.signals import SIGNALS
from tierod.report.display import words
from tierod.web.jobs import Job
from tierod.web.series import Kept, SeriesReader

Name = Field(min_length=1, max_length=4096)


class Given(BaseModel):
    """Body of a request; unknown fields are refused."""

    model_config = ConfigDict(extra="forbid")


class Analysed(Given):
    """Request to analyse a recording; `channel_map` is the content of a channel map corrected in the page.

    `dbc` names databases in the served folders. If either is missing, that of the previous analysis is used.
    """

    file: str = Name
    vehicle: str = Field("", max_length=4096)
    channel_map: dict[str, Any] | None = None
    dbc: list[str] = Field(default_factory=list, max_length=10)
    spread: bool = True


class Asked(Given):
    """Request to examine a recording; fields as in `Analysed`."""

    file: str = Name
    vehicle: str = Field("", max_length=4096)
    channel_map: dict[str, Any] | None = None
    dbc: list[str] = Field(default_factory=list, max_length=10)


class ChosenFault(Given):
    """A fault of a scenario: size as text with unit, start [s]; by default those of its file."""

    name: str = Field(max_length=100)
    size: str = Field("", max_length=40)
    start: float | None = Field(None, ge=0.0, le=86400.0)


class ChosenScenario(Given):
    """Request for a simulated drive: a shipped scenario, or a car on a course."""

    scenario: str = Field("", max_length=100)
    car: str = Field("", max_length=100)
    course: str = Field("", max_length=100)
    seconds: float | None = Field(None, gt=0.0, le=3600.0)
    seed: int = Field(0, ge=0, le=2**31)
    faults: list[ChosenFault] = Field(default_factory=list, max_length=8)


class JobShape(BaseModel):
    """A job: `state` waiting, running, done, failed or cancelled; `share` done, `text` in words, result `found`."""

    id: str
    kind: str
    about: str
    state: str
    share: float
    text: str
    found: dict[str, Any]
    created: float

    @classmethod
    def of(cls, job: Job) -> JobShape:
        """State of a job as returned by the endpoints."""
        return cls(**{name: getattr(job, name) for name in cls.model_fields})


class State(BaseModel):
    """State of a recording; keys are "" if nothing is stored, and `why` states why there is no verdict.

    `corrected`: whether it was read with a channel map or database chosen in the page.
    """

    file: str
    name: str
    bytes: int
    modified: float
    series: str = ""
    result: str = ""
    vehicle: str = ""
    why: str = ""
    corrected: bool = False


class SignalShape(BaseModel):
    """One signal: values times `factor` are shown in the unit `label`; `group` is its section in lists."""

    name: str
    title: str
    group: str
    unit: str
    factor: float
    label: str
    meaning: str
    positive: str
    source: str
    note: str
    count: int


class SeriesShape(BaseModel):
    """The signals of a recording."""

    key: str
    span: tuple[float, float]
    signals: list[SignalShape]
    facts: dict[str, Any]


class Opened(BaseModel):
    """A recording with its stored signals and result in one response; None if they are not stored."""

    state: State
    series: SeriesShape | None
    result: dict[str, Any] | None


class SiteShape(BaseModel):
    """Description of the served site; `scenarios`: whether drives can be simulated, which needs tierod-lab."""

    version: str
    roots: list[str]
    results: list[str]
    vehicle: str
    vehicles: list[str]
    live: list[str]
    dbc: list[str]
    demo: str
    scenarios: bool
    upload_limit: int
    signals: dict[str, dict[str, str]]


class FleetTable(BaseModel):
    """A part of the table of a fleet; `total` counts all matching rows."""

    total: int
    rows: list[dict[str, Any]]


class Problem(BaseModel):
    """Reason why a request was refused, in a sentence."""

    error: str


OTHERS, TRUTH = "Other channels", "Truth of a simulation"


def signal_shape(kept: Kept) -> SignalShape:
    """Description of a signal for the page."""
    factor, label = shown(kept.unit)
    monitor, slash, estimate = kept.name.partition("/")
    known = SIGNALS.get(estimate if slash else kept.name.removeprefix("truth_"))
    if slash and kept.source.startswith("monitor "):
        group, title = f"Estimates of {monitor}", words(estimate)
    elif kept.name.startswith("truth_"):
        group, title = TRUTH, words(kept.name)
    else:
        group, title = (known.group, words(kept.name)) if known else (OTHERS, kept.name)
    return SignalShape(
        name=kept.name,
        title=title,
        group=group,
        unit=kept.unit,
        factor=factor,
        label=label,
        meaning=known.meaning if known else kept.note,
        positive=known.positive if known else "",
        source=kept.source,
        note=kept.note,
        count=kept.count,
    )


def series_shape(key: str, reader: SeriesReader) -> SeriesShape:
    """Descriptions of all signals of a recording for the page."""
    facts = {name: Path(str(each)).name if name == "path" else each for name, each in reader.facts.items()}
    return SeriesShape(
        key=key, span=reader.span, signals=[signal_shape(each) for each in reader.signals.values()], facts=facts
    )
