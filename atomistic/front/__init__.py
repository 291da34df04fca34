"""The public functions of ``atomistic``: validations, decks and crystals, one for each command."""
