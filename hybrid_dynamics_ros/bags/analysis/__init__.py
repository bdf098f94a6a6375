"""What recordings tell: reports, identification, tables."""
