"""Campaigns over many virtual drives: the claims of the papers, one by one."""
