"""The back end of processor cores: compiled sweeps over arrays with padded rows, and tiles of contacts."""
