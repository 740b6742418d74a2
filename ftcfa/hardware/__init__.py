"""What the robot measures and what its motors can do."""
