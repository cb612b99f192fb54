"""What comes in and goes out: readers and writers of every format, derived signals, quality, signs."""
