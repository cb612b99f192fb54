"""Evidence for exported C code on one page: comparisons, checks, and resource use on target processors."""
