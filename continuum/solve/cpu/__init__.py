"""The back end of processor cores: arrays with padded rows, blocks that stay in a cache, threads that sleep."""
