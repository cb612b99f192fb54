"""Presentation of a campaign, or of two compared ones, from its document: a page, and a table in the terminal."""

from tierod_lab.campaign.report.comparison import render_comparison, show_comparison
from tierod_lab.campaign.report.page import render_campaign
from tierod_lab.campaign.report.words import show

__all__ = ["render_campaign", "render_comparison", "show", "show_comparison"]
