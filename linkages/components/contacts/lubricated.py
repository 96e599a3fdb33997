"""A short journal bearing whose film is ruptured where it would have to pull (Gümbel, Ocvirk)."""

from linkages.components.contributed.normal_laws import film_law

LAW = film_law("lubricated", whole=False)
