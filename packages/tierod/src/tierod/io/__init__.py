"""Input and output: readers and writers of every format, derived signals, quality, signs."""
