"""Many runs: the systems of a sweep, what computes them here or on a cluster, and their tables."""
