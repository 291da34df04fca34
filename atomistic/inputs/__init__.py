"""The input files of a cross-validation, of a deck and of a crystal, table by table."""
