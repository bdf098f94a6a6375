"""What can be wrong with a bag, said in words for the terminal."""


class BagError(Exception):
    """A bag cannot be read or written; the text says which, why and what to do."""
