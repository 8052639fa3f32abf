"""Which Python may run besides hannes' own, and how it is loaded: docs/explanation/trust.md."""
