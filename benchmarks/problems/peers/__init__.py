"""The problems as users of other engines model them."""
