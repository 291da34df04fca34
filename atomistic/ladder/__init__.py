"""Cross-validation: one wall on every rung of the ladder of models, compared state by state, with verdicts."""
