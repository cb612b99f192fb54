"""Pure formulas, one function per published model; they work on floats, arrays and symbols alike."""
