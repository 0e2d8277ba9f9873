"""Experiments and measurements, one file each; each returns a table beside the paper's."""
