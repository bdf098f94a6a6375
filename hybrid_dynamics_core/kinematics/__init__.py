"""Questions asked of the closed kinematics: poses, ranges, inverse kinematics."""
