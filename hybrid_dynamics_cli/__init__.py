"""The command `hybrid-dynamics`: one verb a job, over the library."""
