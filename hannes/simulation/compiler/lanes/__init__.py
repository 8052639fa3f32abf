"""Several grasps in the lanes of vector registers: the same text, compiled for vectors."""
