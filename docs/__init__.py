"""The pages, and the scripts behind them: run from the root, as in ``python -m docs.studies.law``."""
