"""Many runs: the systems of a sweep, their computation here or on a cluster, and their tables."""
