"""Many recordings of many vehicles: judged on this machine or on a cluster, kept in tables, asked for trends."""
