"""Evidence for the C of an export: comparisons, checks, and figures on targets, on one page."""
