"""Drives that several tests judge, simulated once in a process; a test that changes one changes a copy."""

from functools import lru_cache

from tierod_lab import ground
from tierod_lab.papers.condition import recorded

KEPT = 6
"""A drive of 13 minutes takes 76 MB."""

drive = lru_cache(maxsize=KEPT)(ground.drive)
lock_to_lock = lru_cache(maxsize=KEPT)(ground.lock_to_lock)
odd_drives = lru_cache(maxsize=1)(recorded.odd_drives)
