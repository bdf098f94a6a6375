"""What the demo's results say: comparison, figures."""
