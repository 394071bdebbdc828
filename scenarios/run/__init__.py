"""The verbs `run`, `report`, `compare` and `baseline`, and the pytest plug-in."""
