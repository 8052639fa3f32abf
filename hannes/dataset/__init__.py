"""Many grasps from one specification: what is drawn, who simulates it, the file they end in."""
