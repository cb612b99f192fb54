"""Types of requests and answers of the endpoints; the OpenAPI page is made from these."""

from __future__ import annotations

from typing import Any

from pydantic import BaseModel, ConfigDict, Field

from tierod.web.jobs import Job

Name = Field(min_length=1, max_length=4096)


class Given(BaseModel):
    """A body of a request: what is not known is refused."""

    model_config = ConfigDict(extra="forbid")


class Analysed(Given):
    """A recording that shall be analysed; `channel_map` is content of a channel map as the page corrects it.

    `dbc` names databases in the folders that are served. Where neither is given, those of the last time hold.
    """

    file: str = Name
    vehicle: str = Field("", max_length=4096)
    channel_map: dict[str, Any] | None = None
    dbc: list[str] = Field(default_factory=list, max_length=10)
    spread: bool = True


class Asked(Given):
    """A recording that is looked at; arguments as of `Analysed`."""

    file: str = Name
    vehicle: str = Field("", max_length=4096)
    channel_map: dict[str, Any] | None = None
    dbc: list[str] = Field(default_factory=list, max_length=10)


class Identified(Given):
    """Recordings from which parameters of a vehicle are found; `free` names them, the usual ones where empty."""

    subject: str = Field("vehicle", pattern="^(vehicle|column|motor|inverter|thresholds)$")
    files: list[str] = Field(min_length=1, max_length=50)
    vehicle: str = Field("", max_length=4096)
    free: list[str] = Field(default_factory=list, max_length=30)
    channel_map: dict[str, Any] | None = None


class ChosenFault(Given):
    """A fault of a scenario: its size as text with unit, its begin [s]; those of its file where not given."""

    name: str = Field(max_length=100)
    size: str = Field("", max_length=40)
    start: float | None = Field(None, ge=0.0, le=86400.0)


class ChosenScenario(Given):
    """A drive: a shipped scenario, or a car on a course."""

    scenario: str = Field("", max_length=100)
    car: str = Field("", max_length=100)
    course: str = Field("", max_length=100)
    seconds: float | None = Field(None, gt=0.0, le=3600.0)
    seed: int = Field(0, ge=0, le=2**31)
    faults: list[ChosenFault] = Field(default_factory=list, max_length=8)


class JobShape(BaseModel):
    """A job: waiting, running, done, failed or cancelled; `share` is done, `text` in words, `found` is its result."""

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
        """The shape of a job."""
        return cls(**{name: getattr(job, name) for name in cls.model_fields})


class State(BaseModel):
    """State of a recording; keys are "" where nothing is kept; `why` there is no verdict.

    `corrected`: whether it was read with a channel map or database that was chosen in the page.
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
    """One signal: values times `factor` are shown in `label`; `group` is where a list has it."""

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
    """A recording with what is kept of it, so that a picture needs one question less; None where nothing is."""

    state: State
    series: SeriesShape | None
    result: dict[str, Any] | None


class Curve(BaseModel):
    """A stretch of a signal: lowest and highest in bins, or every sample where `exact`."""

    name: str
    exact: bool
    time: list[float | None]
    lower: list[float | None]
    upper: list[float | None]


class Pair(BaseModel):
    """Two signals against each other, over a stretch; `step` is how many samples one point stands for."""

    along: list[float | None]
    up: list[float | None]
    time: list[float]
    step: int


class SiteShape(BaseModel):
    """Description of the served site."""

    version: str
    roots: list[str]
    results: list[str]
    vehicle: str
    vehicles: list[str]
    live: list[str]
    dbc: list[str]
    demo: str
    upload_limit: int
    signals: dict[str, dict[str, str]]


class FleetTable(BaseModel):
    """A part of the table of a fleet; `total` counts all rows that match."""

    total: int
    rows: list[dict[str, Any]]


class Problem(BaseModel):
    """Why a request was refused, in a sentence."""

    error: str
