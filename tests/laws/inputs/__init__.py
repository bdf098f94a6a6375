"""Laws of optional inputs: each is heard, and its answer is found another way."""
