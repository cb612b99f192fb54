"""Waiting for jobs of the page."""

from __future__ import annotations

import time

from tierod.web.jobs import Job, Jobs


def ended(jobs: Jobs, job: Job, seconds: float = 300.0) -> Job:
    """The job once it has ended, or after so many seconds."""
    until = time.monotonic() + seconds
    while not job.ended and time.monotonic() < until:
        time.sleep(0.02)
    return jobs.job(job.id)
