"""The command `hybrid-dynamics`: one verb a job, over the library; also `python -m hybrid_dynamics_cli`."""
