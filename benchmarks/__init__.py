"""Studies that stay in the checkout: run each as `python -m benchmarks.NAME`."""
