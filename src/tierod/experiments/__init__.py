"""Campaigns: matrices of virtual drives, judged by monitors, resumed where they were stopped, and compared."""
