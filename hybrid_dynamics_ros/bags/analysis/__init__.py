"""Analysis of recordings: reports, identification, tables."""
