"""A hand that is linear about the truth: its runs cost nothing, so thousands can be diagnosed."""
