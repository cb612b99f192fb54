"""Fleets: recordings of many vehicles, judged here or on a cluster, stored in tables, and analysed for trends."""
