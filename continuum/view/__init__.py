"""``continuum view``: predictions and stored states in a browser, on this machine only."""
