"""Many grasps at once."""
