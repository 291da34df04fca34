"""The error of a surface, from one map of it: to be run; the statement is in docs/studies/spots.md."""
