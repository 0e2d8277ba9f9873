"""The Numba loops of the manifold family, and nothing else.

Pure functions on float64 arrays; the model's arrays are arguments. The tests hold a plain NumPy twin of each.
"""
