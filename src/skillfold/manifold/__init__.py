"""Skill manifolds (Havoutis and Ramamoorthy): tangent field, projection, geodesics."""
