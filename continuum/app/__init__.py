"""``continuum view``: the page of a prediction alive, in a browser on this machine only."""
