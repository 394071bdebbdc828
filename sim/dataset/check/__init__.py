"""What `sim.dataset.verify` looks at: one module a noun, each computed from the files alone."""
