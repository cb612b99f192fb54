"""Checks of a monitor's input signals over a recording: quality, stuck values, defects, missing stretches."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from tierod.core.findings import Defect, Finding
from tierod.core.recording import Aligned, Recording
from tierod.io.derive import ingredients
from tierod.monitors.harness.input_defects import InputDefects, contradicted, with_defects
from tierod.monitors.harness.judged_time import JudgedTime
from tierod.monitors.harness.missing_stretches import MissingStretches
from tierod.monitors.harness.named_vehicle import other_vehicle
from tierod.monitors.harness.quality_over_chunks import QualityOverChunks
from tierod.monitors.harness.session import Conclusion, Monitor, StatusChange
from tierod.monitors.harness.stuck_over_drive import StuckOverDrive


class InputChecks:
    """Checks the input signals piece by piece beside the monitor, and limits its conclusion accordingly.

    Args:
        monitor: monitor on the grid of the recording
        signals: input signals of its session

    `needs` holds the names of the channels to be read.
    """

    def __init__(self, monitor: Monitor, signals: Sequence[str]):
        used = ingredients([*monitor.required, *monitor.optional])
        self.monitor = monitor
        self.quality = QualityOverChunks(used)
        self.stuck = StuckOverDrive(signals, monitor.rate, monitor.subjects)
        self.judged = JudgedTime(monitor.required, monitor.rate)
        self.missing = MissingStretches([name for name in signals if name not in monitor.subjects], monitor.rate)
        self._there: set[str] = set()
        self.defects = InputDefects(self.stuck.names)
        self.needs = tuple(dict.fromkeys((*used, *self.stuck.beside)))
        self._paced = False

    def refuse_slow(self) -> None:
        """Refuse required signals with a low sampling rate; checks with every piece until all rates are known.

        Raises:
            InputError: a signal comes at less than the minimum rate of the monitor
        """
        if not self._paced:
            self._paced = self.quality.refuse_slow(self.monitor.required, self.monitor.minimum_rate)

    def add(self, whole: Recording, start: float, usable: Aligned) -> None:
        """Add the next samples.

        Args:
            whole: piece that the samples come from
            start: start of the recording [s]
            usable: input of the monitor, NaN where a signal is stuck
        """
        self._there.update(name for name in usable.names if name in whole)
        self.judged.add(usable, self._there)
        self.missing.add(usable)
        self.defects.add(whole, start, float(usable.time[-1]), self.stuck.spans())

    def limited(
        self, conclusion: Conclusion, contradictions: Sequence[str], others: Sequence[Defect] = ()
    ) -> Conclusion:
        """Conclusion limited by the defects of the input signals and by the judged part of the recording.

        Args:
            conclusion: conclusion of the session
            contradictions: contradictions between signals over the drive, as sentences
            others: faults of sensors that other monitors declare
        """
        rests_on = {*self.monitor.required, *self.monitor.rests_on}
        others = [each for each in others if rests_on.intersection(each.names)]
        defects = (*self.defects.found(self.quality.units), *conclusion.defects, *others)
        named = with_defects(conclusion.finding, defects, self.monitor)
        named = contradicted(named, (*contradictions, *self._noises(named)), self.monitor)
        finding = self.judged.limited(named, self.monitor.title, self.monitor.reaction, self.stuck.lasting())
        if conclusion.further and finding.status.quiet:
            finding = dataclasses.replace(finding, headline=f"{finding.headline} {conclusion.further}")
        course = conclusion.course
        unchanged = finding.status is conclusion.finding.status
        if finding.status is not named.status and self.judged.last is not None:
            course = (*course, StatusChange(self.judged.last, finding.status))
        return dataclasses.replace(
            conclusion,
            finding=dataclasses.replace(finding, evidence={**finding.evidence, **self.judged.evidence()}),
            baseline=conclusion.baseline if unchanged else None,
            unproven=conclusion.unproven if unchanged else None,
            course=course,
        )

    def warned(
        self, finding: Finding, contradictions: Sequence[str], metadata: Mapping[str, Any], judged_as: str
    ) -> Finding:
        """Finding with the warnings about vehicle, input signals and recording.

        Args:
            finding: finding of the monitor
            contradictions: contradictions between signals over the drive, as sentences
            metadata: metadata of the recording
            judged_as: name of the vehicle whose parameters are used
        """
        other = other_vehicle(metadata, judged_as)
        warnings = (
            *finding.warnings,
            *((other,) if other else ()),
            *self.stuck.warnings(self.quality.units),
            *self.missing.warnings(self.quality.rates(), {each.name for each in self.stuck.spans()}),
            *contradictions,
            *self._noises(finding),
            *self.quality.range_warnings(),
            *self.quality.held_warnings(),
            *metadata.get("warnings", ()),
        )
        return dataclasses.replace(self.stuck.to_repair(finding), warnings=tuple(dict.fromkeys(warnings)))

    def _noises(self, finding: Finding) -> tuple[str, ...]:
        """Warnings of noisy signals, without those whose noise the monitor has named itself."""
        said = f"{finding.cause} {' '.join(finding.warnings)}"
        return tuple(each for each in self.quality.noise_warnings() if each.partition(" by ")[0] not in said)
