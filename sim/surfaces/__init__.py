"""Surfaces as triangle meshes, their textures, and the assets of a MuJoCo model."""
