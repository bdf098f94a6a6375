"""Traces as text of LLVM's intermediate representation: plain text in, nothing here needs a compiler installed."""
