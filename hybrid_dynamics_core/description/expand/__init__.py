"""Short forms of a description: each becomes links, joints, frames and closures."""
