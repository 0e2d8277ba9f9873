"""The Numba loops of keyframe skills: pure functions on float64 arrays, each with a plain twin in the tests."""
