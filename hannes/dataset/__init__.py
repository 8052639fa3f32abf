"""Many grasps from one specification: sampled, simulated on many cores, written to one file."""
