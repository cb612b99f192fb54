"""Tracing, printing, compiling and running blocks; nothing else in tierod imports CasADi."""
