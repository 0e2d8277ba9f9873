"""The Numba loops of control, and nothing else; the tests hold a plain twin of each."""
