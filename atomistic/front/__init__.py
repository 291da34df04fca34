"""The front door: validations, decks and crystals as a person calls them.  What a command does, one of these does."""
