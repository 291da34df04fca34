"""The back end of any library of the array API: NumPy, PyTorch, CuPy, JAX."""
