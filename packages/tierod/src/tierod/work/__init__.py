"""The store and the pool of work: processes of this machine or of a cluster, keyed by digests of data and code."""
